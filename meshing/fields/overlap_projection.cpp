// Integrals over the overlap of two meshes tet by tet, the projection, and the bounded correction.
#include "meshing/fields/overlap_projection.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "meshing/base/box.h"
#include "meshing/base/parallel.h"
#include "meshing/base/small_set.h"
#include "meshing/fields/tet_overlap.h"
#include "meshing/mesh/mass_matrix.h"

namespace weft::meshing {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::array<Point, 4> corners_of(const MeshData& mesh, std::size_t t) {
  const auto& [a, b, c, d] = mesh.tets[t];
  return {mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]};
}

double volume_of(const std::array<Point, 4>& x) {
  return std::max(0.0, six_volume(x[0], x[1], x[2], x[3]) / 6);  // a flat tet may compute a negative volume
}

/// What a new tet receives from the old mesh: for every column the integrals of the old field times its four
/// hat functions, and the range that the old field has in it.
struct Receipt {
  std::vector<double> loads;  ///< of hat i and column c at i * columns + c
  std::vector<double> lo, hi;
};

/// Finds the tets of the old mesh that a new one overlaps, by their neighbours. Where that begins depends on
/// the two meshes alone, and whether it goes on to a neighbour on two tets alone: so does what is found, down
/// to what only touches by rounding. One thread's scratch.
class Receiver {
 public:
  Receiver(const TetLocator& from, const ValueTable& old) : from_(from), old_(old) {}

  void receive(const MeshData& to, std::size_t t, std::span<const std::uint32_t> places,
               const ValueTable& interpolated, Receipt& receipt) {
    corners_ = corners_of(to, t);
    const double volume = volume_of(corners_);
    receipt.loads.assign(4 * old_.columns, 0);
    receipt.lo.assign(old_.columns, kInfinity);
    receipt.hi.assign(old_.columns, -kInfinity);
    seen_.clear();
    parts_.clear();
    numbers_.clear();
    const auto& tet = to.tets[t];
    if (!(volume > 0)) return complete(tet, 0, interpolated, receipt);  // flat: it receives bounds alone
    const Point centre = midpoint(midpoint(corners_[0], corners_[1]), midpoint(corners_[2], corners_[3]));
    if (const auto place = from_.locate(centre, places[tet[0]]); place.inside) collect(place.tet);
    // A new tet can reach several parts of an old mesh that is not convex.
    for (const std::uint32_t v : tet) collect(places[v]);
    const double covered = add_parts(receipt);
    complete(tet, std::max(0.0, volume - covered), interpolated, receipt);
  }

 private:
  /// What one old tet gives.
  struct Part {
    std::uint32_t old_tet;
    double volume;
    std::size_t first;  ///< among numbers_: of each column four loads, lo, hi
  };
  static constexpr std::size_t kNumbers = 6;

  /// Finds the old tets that are reached from `seed`.
  void collect(std::uint32_t seed) {
    visit(seed);
    while (!pending_.empty()) {
      const std::uint32_t old_tet = pending_.back();
      pending_.pop_back();
      const std::array<Point, 4> old_corners = corners_of(from_.mesh(), old_tet);
      const bool flat = !(volume_of(old_corners) > 0);  // it has no part of anything, but lies on the way
      if (flat ? !box_of(corners_).meets(box_of(old_corners)) : !overlap_.find(corners_, old_corners))
        continue;
      if (!flat) keep_part(old_tet);
      const unsigned faces = flat ? 0b1111 : overlap_.faces_of_second();
      const auto& neighbours = from_.adjacency().neighbours[old_tet];
      for (std::size_t k = 0; k < 4; ++k)
        if (neighbours[k] != kNoNeighbour && (faces >> k & 1) != 0) visit(neighbours[k] >> 2);
    }
  }

  void visit(std::uint32_t old_tet) {
    if (seen_.insert(old_tet)) pending_.push_back(old_tet);
  }

  /// Integrals over the pieces: of products of linear functions, V/20 times (sum of the products at the
  /// corners plus product of the sums).
  void keep_part(std::uint32_t old_tet) {
    parts_.push_back({old_tet, overlap_.volume(), numbers_.size()});
    for (std::size_t c = 0; c < old_.columns; ++c) {
      std::array<double, 4> nodal, loads{};
      for (std::size_t j = 0; j < 4; ++j)
        nodal[j] = old_.values[from_.mesh().tets[old_tet][j] * old_.columns + c];
      double lo = kInfinity, hi = -kInfinity;
      std::array<double, TetOverlap::kPlaces> values, weights;
      overlap_.for_each_corner([&](std::size_t k, const TetOverlap::Corner& corner) {
        const auto l = corner.in_second();
        values[k] = l[0] * nodal[0] + l[1] * nodal[1] + l[2] * nodal[2] + l[3] * nodal[3];
        weights[k] = 0;
        lo = std::min(lo, values[k]);
        hi = std::max(hi, values[k]);
      });
      for (const TetOverlap::Piece& piece : overlap_.pieces()) {
        const auto& [p, q, r, s] = piece.corners;
        const double sum = values[p] + values[q] + values[r] + values[s];
        for (const std::uint8_t k : piece.corners) weights[k] += piece.volume / 20 * (sum + values[k]);
      }
      overlap_.for_each_corner([&](std::size_t k, const TetOverlap::Corner& corner) {
        for (std::size_t i = 0; i < 4; ++i) loads[i] += corner.in_first()[i] * weights[k];
      });
      numbers_.insert(numbers_.end(), {loads[0], loads[1], loads[2], loads[3], lo, hi});
    }
  }

  /// In the order of the old tets' vertices, which those of a part of the mesh have too. Returns the volume.
  double add_parts(Receipt& receipt) {
    std::ranges::sort(parts_, {}, [&](const Part& part) { return from_.mesh().tets[part.old_tet]; });
    double covered = 0;
    for (const Part& part : parts_) {
      covered += part.volume;
      const double* numbers = &numbers_[part.first];
      for (std::size_t c = 0; c < old_.columns; ++c, numbers += kNumbers) {
        for (std::size_t i = 0; i < 4; ++i) receipt.loads[i * old_.columns + c] += numbers[i];
        receipt.lo[c] = std::min(receipt.lo[c], numbers[4]);
        receipt.hi[c] = std::max(receipt.hi[c], numbers[5]);
      }
    }
    return covered;
  }

  /// The part outside the old mesh (beside a curved boundary) takes the values interpolated at the corners.
  void complete(const std::array<std::uint32_t, 4>& tet, double uncovered, const ValueTable& interpolated,
                Receipt& receipt) const {
    for (std::size_t c = 0; c < old_.columns; ++c) {
      std::array<double, 4> u;
      for (std::size_t i = 0; i < 4; ++i) {
        u[i] = interpolated.values[tet[i] * old_.columns + c];
        receipt.lo[c] = std::min(receipt.lo[c], u[i]);
        receipt.hi[c] = std::max(receipt.hi[c], u[i]);
      }
      const double sum = u[0] + u[1] + u[2] + u[3];
      for (std::size_t i = 0; i < 4; ++i)
        receipt.loads[i * old_.columns + c] += uncovered / 20 * (u[i] + sum);
    }
  }

  const TetLocator& from_;
  const ValueTable& old_;
  SmallSet seen_;
  std::vector<std::uint32_t> pending_;
  TetOverlap overlap_;
  std::vector<Part> parts_;
  std::vector<double> numbers_;
  std::array<Point, 4> corners_;
};

/// The right side of the projection and the bounds of its result.
struct Demands {
  std::vector<double> loads, lo, hi;  ///< as in a ValueTable
};

/// Not all where this part is interrupted.
Demands demands_of(const TetLocator* from, const ValueTable& old, const MetricDomain& domain,
                   std::span<const std::uint32_t> places, const ValueTable& interpolated) {
  const MeshData& to = domain.mesh();
  // Tets in batches that are worked out in parallel and added up in order: sums do not depend on the threads.
  constexpr std::size_t kBatch = 8192, kGrain = 64;
  const std::size_t n = old.columns, size = to.points.size() * n;
  Demands demands{std::vector<double>(size, 0), std::vector<double>(size, kInfinity),
                  std::vector<double>(size, -kInfinity)};
  tbb::enumerable_thread_specific<Receiver> receivers([&] { return Receiver(*from, old); });
  std::vector<Receipt> receipts(std::min(kBatch, to.tets.size()));
  for (std::size_t begin = 0; begin < to.tets.size() && !domain.interrupted_here(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, to.tets.size() - begin);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
      Receiver& receiver = receivers.local();
      for (std::size_t i = range.begin(); i < range.end(); ++i)
        receiver.receive(to, begin + i, places, interpolated, receipts[i]);
    });
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t c = 0; c < n; ++c) {
          const std::size_t at = to.tets[begin + i][k] * n + c;
          demands.loads[at] += receipts[i].loads[k * n + c];
          demands.lo[at] = std::min(demands.lo[at], receipts[i].lo[c]);
          demands.hi[at] = std::max(demands.hi[at], receipts[i].hi[c]);
        }
  }
  return demands;
}

/// One column of the projection, brought within its bounds and to its integral by the least change in the sum
/// of m (change)^2 / (hi - lo): Lagrange's condition is value = clamp(projected + x (hi - lo), lo, hi) with
/// one x. (Bochev et al. 2011, optimization-based remap.) A field keeps its value where it is constant
/// nearby.
class BoundedColumn {
 public:
  BoundedColumn(std::size_t column, const MetricDomain& domain, const Demands& demands,
                std::span<const double> masses, ValueTable& table)
      : c_(column), domain_(domain), demands_(demands), masses_(masses), table_(table) {}

  /// Returns how far the values had to leave their bounds for the integral's sake.
  double correct(double wanted) {
    const double x = multiplier(wanted);
    for_each_index(masses_.size(), [&](std::size_t v) { value(v) = limited(v, x); });
    const double volume = domain_.sum([&](std::size_t v) { return masses_[v]; });
    // Rounding is left over, or all that the bounds had no room for.
    const double rest =
        (wanted - domain_.signed_sum([&](std::size_t v) { return masses_[v] * value(v); })) / volume;
    for_each_index(masses_.size(), [&](std::size_t v) {
      if (masses_[v] > 0) value(v) += rest;
    });
    return std::abs(rest);
  }

 private:
  double& value(std::size_t v) const { return table_.values[v * table_.columns + c_]; }
  double limited(std::size_t v, double x) const {
    const double lo = demands_.lo[v * table_.columns + c_], hi = demands_.hi[v * table_.columns + c_];
    return lo <= hi ? std::clamp(value(v) + x * (hi - lo), lo, hi) : value(v);
  }
  double integral(double x) const {
    return domain_.signed_sum([&](std::size_t v) { return masses_[v] * limited(v, x); });
  }

  /// The integral grows with x; at 1 and -1 from within the bounds every value is at one of them.
  double multiplier(double wanted) const {
    constexpr int kSteps = 60;
    const double now = integral(0);
    if (now == wanted) return 0;
    double near = 0, far = now < wanted ? 1e-12 : -1e-12;
    while (std::abs(far) < 1e3 && (integral(far) < wanted) == (now < wanted)) near = far, far *= 8;
    for (int i = 0; i < kSteps; ++i) {
      const double middle = 0.5 * (near + far);
      if (middle == near || middle == far) break;
      ((integral(middle) < wanted) == (now < wanted) ? near : far) = middle;
    }
    return far;
  }

  std::size_t c_;
  const MetricDomain& domain_;
  const Demands& demands_;
  std::span<const double> masses_;
  ValueTable& table_;
};

}  // namespace

std::vector<double> integrals(const MetricDomain& domain, const ValueTable& table) {
  const std::vector<double> volumes = vertex_volumes(domain.mesh());
  std::vector<double> sums;
  for (std::size_t c = 0; c < table.columns; ++c)
    sums.push_back(
        domain.signed_sum([&](std::size_t v) { return volumes[v] * table.values[v * table.columns + c]; }));
  return sums;
}

std::optional<std::vector<double>> project(const TetLocator* from, const ValueTable& old,
                                           const MetricDomain& to, std::span<const std::uint32_t> places,
                                           std::span<const double> wanted,
                                           std::span<const TensorColumns> tensors, ValueTable& table,
                                           const std::function<void()>& old_is_read) {
  if (to.interrupted()) return std::nullopt;  // of one part alone: the others need not begin
  const Demands demands = demands_of(from, old, to, places, table);
  if (to.interrupted()) return std::nullopt;
  if (old_is_read) old_is_read();
  const MassMatrix mass(to.mesh());
  const auto refresh = [&](std::vector<double>& values) { to.refresh(table.columns, values); };
  mass.solve(demands.loads, table.columns, table.values, refresh);
  std::vector<double> beyond(table.columns, 0);
  std::vector<bool> of_tensor(table.columns,
                              false);  // these are limited together; their eigenvalues only bound them
  for (const TensorColumns& t : tensors) {
    const auto change = limit_tensors(to, mass, t, demands.loads, demands.lo, demands.hi, wanted, table);
    std::ranges::copy(change, beyond.begin() + static_cast<std::ptrdiff_t>(t.first));
    for (std::size_t c = 0; c < 6; ++c) of_tensor[t.first + c] = true;
    of_tensor[t.least] = of_tensor[t.largest] = true;
  }
  for (std::size_t c = 0; c < table.columns; ++c)
    if (!of_tensor[c]) beyond[c] = BoundedColumn(c, to, demands, mass.lumped(), table).correct(wanted[c]);
  refresh(table.values);
  return beyond;
}

}  // namespace weft::meshing
