// Recovery of Hessians: quadratic fits over growing balls, and the double L2 projection.
#include "meshing/metric/sources/hessian.h"

#include <algorithm>
#include <cstdint>

#include "meshing/base/assert.h"
#include "meshing/base/parallel.h"
#include "meshing/base/small_set.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/metric/sources/quadratic_fit.h"

namespace weft::meshing {
namespace {

// --- Quadratic fits
// -----------------------------------------------------------------------------------------------

constexpr int kFirstRings = 2, kMostRings = 4;

/// The vertices within some edges of a centre.
class Ball {
 public:
  void start(std::uint32_t centre) {
    vertices_.assign(1, centre);
    seen_.clear();
    seen_.insert(centre);
    inside_ = 0;
  }
  /// One edge wider; false when there is nothing more to reach.
  bool grow(const VertexLists& neighbours) {
    const std::size_t end = vertices_.size();
    for (; inside_ < end; ++inside_) {
      const auto more = neighbours.of(vertices_[inside_]);
      // All the balls of a hub's k neighbours would have k vertices: k^2 in all. They do without it.
      if (inside_ > 0 && more.size() > kMostNeighbours) continue;
      for (const std::uint32_t v : more)
        if (seen_.insert(v)) vertices_.push_back(v);
    }
    return vertices_.size() > end;
  }
  /// Ascending, as sums are to have the same order in every part that has them.
  std::span<const std::uint32_t> vertices() {
    ascending_ = vertices_;
    std::ranges::sort(ascending_);
    return ascending_;
  }

 private:
  static constexpr std::size_t kMostNeighbours = 256;
  std::vector<std::uint32_t> vertices_, ascending_;  ///< ring by ring from the centre
  std::size_t inside_ = 0;                           ///< how many have all their neighbours here
  SmallSet seen_;
};

struct FitScratch {
  Ball ball;
  QuadraticFit fit;
};

class LeastSquares {
 public:
  LeastSquares(const MeshData& mesh, std::span<const double> values)
      : points_(mesh.points),
        values_(values),
        neighbours_(vertex_neighbours(mesh.tets, mesh.points.size())) {}

  SymTensor at(std::uint32_t v, FitScratch& scratch) const {
    scratch.ball.start(v);
    bool more = scratch.ball.grow(neighbours_);
    for (int rings = kFirstRings; more && rings <= kMostRings; ++rings) {
      more = scratch.ball.grow(neighbours_);
      fill(v, scratch);
      if (const auto hessian = scratch.fit.hessian()) return *hessian;
    }
    return least_norm_at(v, scratch);
  }

 private:
  /// Wider balls did not help, as in a mesh of one layer: near vertices give the smallest error.
  SymTensor least_norm_at(std::uint32_t v, FitScratch& scratch) const {
    scratch.ball.start(v);
    for (int rings = 1; rings <= kFirstRings; ++rings) scratch.ball.grow(neighbours_);
    fill(v, scratch);
    return scratch.fit.least_norm_hessian();
  }
  void fill(std::uint32_t v, FitScratch& scratch) const {
    scratch.fit.clear();
    for (const std::uint32_t w : scratch.ball.vertices())
      if (w != v) scratch.fit.add(points_[w] - points_[v], values_[w] - values_[v]);
  }

  std::span<const Point> points_;
  std::span<const double> values_;
  VertexLists neighbours_;
};

std::vector<SymTensor> fit_hessians(const MetricDomain& domain, std::span<const double> values) {
  std::vector<SymTensor> hessians(domain.mesh().points.size());
  const LeastSquares fits(domain.mesh(), values);
  for_each_index_with<FitScratch>(hessians.size(), [&](std::size_t v, FitScratch& scratch) {
    if (domain.owns(v)) hessians[v] = fits.at(static_cast<std::uint32_t>(v), scratch);
  });
  domain.refresh(hessians);
  return hessians;
}

// --- Double L2 projection
// -----------------------------------------------------------------------------------------

class Projection {
 public:
  explicit Projection(const MeshData& mesh)
      : mesh_(mesh), vertex_tets_(vertex_tets(mesh.tets, mesh.points.size())) {}

  /// The gradients at all vertices of a field whose value at vertex v is value(v): those of its tets,
  /// weighted by their volumes.
  template <class Value>
  std::vector<Vec> gradients(const Value& value) const {
    std::vector<Vec> result(mesh_.points.size());
    for_each_index(result.size(), [&](std::size_t v) {
      Vec sum{};
      double volume = 0;
      for (const std::uint32_t t : vertex_tets_.of(v)) add_tet(mesh_.tets[t], value, sum, volume);
      if (volume > 0) result[v] = (1 / volume) * sum;
    });
    return result;
  }

 private:
  /// Adds six times the volume, and that times the gradient, which needs no division by it.
  template <class Value>
  void add_tet(const std::array<std::uint32_t, 4>& tet, const Value& value, Vec& sum, double& volume) const {
    const auto& [a, b, c, d] = tet;
    const auto& p = mesh_.points;
    const Vec ab = p[b] - p[a], ac = p[c] - p[a], ad = p[d] - p[a];
    const double base = value(a);
    sum += (value(b) - base) * cross(ac, ad) + (value(c) - base) * cross(ad, ab) +
           (value(d) - base) * cross(ab, ac);
    volume += six_volume(p[a], p[b], p[c], p[d]);
  }

  const MeshData& mesh_;
  VertexLists vertex_tets_;
};

std::vector<std::uint8_t> boundary_vertices(const MeshData& mesh) {
  const Adjacency adjacency = build_adjacency(mesh.tets, mesh.points.size());
  std::vector<std::uint8_t> on_boundary(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (int face = 0; face < 4; ++face) {
      if (adjacency.neighbours[t][face] != kNoNeighbour) continue;
      for (int i = 0; i < 4; ++i)
        if (i != face) on_boundary[mesh.tets[t][i]] = 1;
    }
  return on_boundary;
}

/// Replaces the tensors of the vertices marked by the mean of their neighbours' that are not, layer by layer
/// into the marked region; where all are marked, everything stays.
void extrapolate(const MetricDomain& domain, const VertexLists& neighbours, std::vector<std::uint8_t> marked,
                 std::vector<SymTensor>& tensors) {
  domain.refresh(marked);
  for (bool any = true; any;) {
    std::vector<std::uint8_t> still_marked = marked;
    for_each_index(tensors.size(), [&](std::size_t v) {
      if (!marked[v] || !domain.owns(v)) return;
      SymTensor sum;
      int count = 0;
      for (const std::uint32_t w : neighbours.of(v))
        if (!marked[w]) sum = sum + tensors[w], ++count;
      if (count == 0) return;
      tensors[v] = (1.0 / count) * sum;
      still_marked[v] = 0;
    });
    domain.refresh(tensors);
    domain.refresh(still_marked);
    any = domain.any(still_marked != marked);
    marked.swap(still_marked);
  }
}

std::vector<SymTensor> project_hessians(const MetricDomain& domain, std::span<const double> values) {
  const MeshData& mesh = domain.mesh();
  std::vector<SymTensor> hessians(mesh.points.size());
  {
    const Projection projection(mesh);
    const std::vector<Vec> gradients = projection.gradients([&](std::uint32_t v) { return values[v]; });
    const auto x = projection.gradients([&](std::uint32_t v) { return gradients[v].x; });
    const auto y = projection.gradients([&](std::uint32_t v) { return gradients[v].y; });
    const auto z = projection.gradients([&](std::uint32_t v) { return gradients[v].z; });
    for_each_index(hessians.size(), [&](std::size_t v) {
      hessians[v] = {x[v].x, (x[v].y + y[v].x) / 2, y[v].y, (x[v].z + z[v].x) / 2, (y[v].z + z[v].y) / 2,
                     z[v].z};
    });
  }
  domain.refresh(hessians);
  extrapolate(domain, vertex_neighbours(mesh.tets, mesh.points.size()), boundary_vertices(mesh), hessians);
  return hessians;
}

}  // namespace

int rings_of(HessianRecovery recovery) { return recovery == HessianRecovery::least_squares ? kMostRings : 2; }

std::vector<SymTensor> recover_hessians(const MetricDomain& domain, std::span<const double> values,
                                        HessianRecovery recovery) {
  WEFT_ASSERT_LIGHT(values.size() == domain.mesh().points.size(), "one value a vertex");
  return recovery == HessianRecovery::least_squares ? fit_hessians(domain, values)
                                                    : project_hessians(domain, values);
}

std::vector<SymTensor> recover_hessians(const MeshData& mesh, std::span<const double> values,
                                        HessianRecovery recovery) {
  return recover_hessians(WholeDomain(mesh), values, recovery);
}

}  // namespace weft::meshing
