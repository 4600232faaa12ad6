// The demand of the boundary, from the vertices where the metric falls short of it.
#include "meshing/metric/surface_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/metric/gradation.h"

namespace weft::meshing {
namespace {

constexpr double kLongest = 1.25;  // what boundary edges may be longer than the demand
constexpr double kGrowth = 1.5;

/// How much longer edges of `field` are than those of `demand`, in the direction where they are that most.
double excess(const LogMetric& demand, const LogMetric& field) {
  const Metric finer = exp_exact(demand),
               unit = exp_exact(-0.5 * field);  // of unit vectors to those of field
  const std::array<Vec, 3> edges = {Vec{unit.xx, unit.xy, unit.xz}, Vec{unit.xy, unit.yy, unit.yz},
                                    Vec{unit.xz, unit.yz, unit.zz}};
  const auto square = [&](std::size_t i, std::size_t j) { return dot(edges[i], apply(finer, edges[j])); };
  const SymTensor squares{square(0, 0), square(0, 1), square(1, 1), square(0, 2), square(1, 2), square(2, 2)};
  return std::sqrt(std::max(0.0, eigen_decomposition(squares).values[2]));
}

/// The last in the order of coordinates of the owned vertices that have `value`: the same for any parts.
Point last_with(const MetricDomain& domain, const std::vector<double>& values, double value) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  std::array<double, 3> found{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double mine = kNone;
    for (std::size_t v = 0; v < values.size(); ++v) {
      const Point& p = domain.mesh().points[v];
      bool agrees = domain.owns(v) && values[v] == value;
      for (std::size_t i = 0; i < axis; ++i) agrees = agrees && p[static_cast<int>(i)] == found[i];
      if (agrees) mine = std::max(mine, p[static_cast<int>(axis)]);
    }
    found[axis] = domain.max(mine);
  }
  return {found[0], found[1], found[2]};
}

}  // namespace

std::optional<LimitOfSurface> limit_of_surface(const MetricDomain& domain, LogMetricField demand,
                                               const LogMetricField& field, double most) {
  const LogMetric none = identity_tensor(-2 * std::log(domain.largest_size()));
  std::vector<double> longer(field.size());
  for_each_index(field.size(), [&](std::size_t v) {
    if (demand[v] == none) return;
    longer[v] = excess(demand[v], field[v]);
    if (longer[v] <= kLongest) demand[v] = none;
  });
  double longest = 0;
  for (std::size_t v = 0; v < field.size(); ++v)
    if (domain.owns(v)) longest = std::max(longest, longer[v]);
  longest = domain.max(longest);
  if (longest <= kLongest) return std::nullopt;
  LimitOfSurface limit;
  limit.account.vertices =
      static_cast<std::uint64_t>(domain.sum([&](std::size_t v) { return longer[v] > kLongest ? 1.0 : 0.0; }));
  limit.account.longest = longest;
  limit.account.where = last_with(domain, longer, longest);
  Gradation(domain, kGrowth, GradationSpace::metric).limit(demand);
  const double target = most * domain.complexity(field);
  if (std::isfinite(target) && domain.complexity(demand) > target)
    scale_to_complexity(domain, target, demand);
  limit.demand = std::move(demand);
  return limit;
}

}  // namespace weft::meshing
