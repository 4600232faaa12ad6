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
        sizes_(mesh.points.size(), std::numeric_limits<double>::infinity()),
        given_(mesh.points.size()) {}

  std::vector<double> run() {
    for (std::uint32_t s = 0; s < sources_.size(); ++s) {
      given_[sources_[s].vertex] = 1;
      reach({sources_[s].size, 0, sources_[s].vertex, s});
    }
    while (!queue_.empty()) {
      const Front front = queue_.top();
      queue_.pop();
      if (front.size == sizes_[front.vertex]) advance(front);
    }
    return std::move(sizes_);
  }

 private:
  struct Front {
    double size, way;
    std::uint32_t vertex, source;
    /// Equal sizes in a fixed order, so that the result does not depend on the heap.
    bool operator<(const Front& o) const { return size != o.size ? size > o.size : vertex > o.vertex; }
  };
  static constexpr double kEuclideanShare = 0.9;  ///< of the way along edges in a mesh of good tets

  void reach(const Front& front) {
    if (front.size >= sizes_[front.vertex]) return;
    sizes_[front.vertex] = front.size;
    queue_.push(front);
  }

  void advance(const Front& from) {
    const SizeSource& source = sources_[from.source];
    for (const std::uint32_t v : neighbours_.of(from.vertex)) {
      if (given_[v]) continue;
      const double way = from.way + norm(mesh_.points[v] - mesh_.points[from.vertex]);
      const double straight = norm(mesh_.points[v] - mesh_.points[source.vertex]);
      reach({source.size + source.slope * std::max(straight, kEuclideanShare * way), way, v, from.source});
    }
  }

  const MeshData& mesh_;
  std::span<const SizeSource> sources_;
  VertexLists neighbours_;
  std::vector<double> sizes_;
  std::vector<char> given_;
  std::priority_queue<Front> queue_;
};

}  // namespace

std::vector<double> spread_sizes(const MeshData& mesh, std::span<const SizeSource> sources) {
  return Spread(mesh, sources).run();
}

}  // namespace weft::meshing
