// Dijkstra's search from all sources at once; a vertex knows which source its size comes from.
#include "meshing/initial/spread_sizes.h"

#include <algorithm>
#include <limits>
#include <queue>

#include "meshing/mesh/adjacency.h"

namespace weft::meshing {
namespace {

class Spread {
 public:
  Spread(const MeshData& mesh, std::span<const SizeSource> sources)
      : mesh_(mesh),
        sources_(sources),
        neighbours_(vertex_neighbours(mesh.tets, mesh.points.size())),
        sizes_(mesh.points.size(), {std::numeric_limits<double>::infinity(), 0, 0}),
        given_(mesh.points.size()) {}

  std::vector<SpreadSize> run() {
    for (std::uint32_t s = 0; s < sources_.size(); ++s) {
      given_[sources_[s].vertex] = 1;
      reach({sources_[s].size, 0, s}, sources_[s].vertex);
    }
    while (!queue_.empty()) {
      const Front front = queue_.top();
      queue_.pop();
      if (front.size == sizes_[front.vertex].size) advance(front.vertex);
    }
    return std::move(sizes_);
  }

 private:
  struct Front {
    double size;
    std::uint32_t vertex;
    /// Equal sizes in a fixed order, so that the result does not depend on the heap.
    bool operator<(const Front& o) const { return size != o.size ? size > o.size : vertex > o.vertex; }
  };
  void reach(const SpreadSize& front, std::uint32_t vertex) {
    if (front.size >= sizes_[vertex].size) return;
    sizes_[vertex] = front;
    queue_.push({front.size, vertex});
  }

  void advance(std::uint32_t vertex) {
    const SpreadSize from = sizes_[vertex];
    const SizeSource& source = sources_[from.source];
    for (const std::uint32_t v : neighbours_.of(vertex))
      if (!given_[v])
        reach(spread_on(from, source, mesh_.points[source.vertex],
                        norm(mesh_.points[v] - mesh_.points[vertex]), mesh_.points[v]),
              v);
  }

  const MeshData& mesh_;
  std::span<const SizeSource> sources_;
  VertexLists neighbours_;
  std::vector<SpreadSize> sizes_;
  std::vector<char> given_;
  std::priority_queue<Front> queue_;
};

}  // namespace

SpreadSize spread_on(const SpreadSize& from, const SizeSource& source, const Point& origin, double edge,
                     const Point& to) {
  constexpr double kEuclideanShare = 0.9;
  const double way = from.way + edge;
  return {source.size + source.slope * std::max(norm(to - origin), kEuclideanShare * way), way, from.source};
}

std::vector<SpreadSize> spread_sizes(const MeshData& mesh, std::span<const SizeSource> sources) {
  return Spread(mesh, sources).run();
}

}  // namespace weft::meshing
