// Rules on numbers of tets.
#include "graph/adaptation/phase_plan.h"

#include <algorithm>

#include "meshing/metric/expectations.h"

namespace weft::graph::adaptation {
namespace {

/// Of a mesh that conforms to the metric with edges so much longer than wanted.
double tets_of(double complexity, double coarseness) {
  return meshing::kTetsOfUnitVolume * complexity / (coarseness * coarseness * coarseness);
}

/// How coarse the mesh is that is divided: enough tets for each part, that it may have a good shape and its
/// share of the work, and no more, as few subdomains make it. 1: the wanted one has too few.
double coarseness_to_divide(double complexity, std::uint32_t subdomains) {
  constexpr double kCoarsest = 64, kEnough = 100, kLeast = 20;
  const auto is_enough = [&](double coarseness, double of_part) {
    return tets_of(complexity, coarseness) >= of_part * subdomains;
  };
  double coarseness = 1;
  while (coarseness < kCoarsest && is_enough(2 * coarseness, kEnough)) coarseness *= 2;
  if (coarseness == 1 && is_enough(2, kLeast)) coarseness = 2;
  return coarseness;
}

bool is_curved(const partition::Geometry& geometry) {
  return !std::ranges::all_of(geometry.surface.patches(), &meshing::Patch::planar);
}

/// A mesh with curved boundary and fewer tets than wanted begins with a metric as coarse as itself: edges of
/// the boundary in the interface are chords that stay until a shift frees them, and should never be much
/// longer than what is beside them, which is on the surface. The first phase should have some tets in each
/// subdomain.
double coarseness_of_curved(const partition::Distributed& d, std::uint64_t input_tets,
                            const AdaptationPlan& plan) {
  constexpr double kLeastTets = 20, kCoarsest = 64;
  if (!is_curved(*d.geometry) || plan.subdomains < 2 || plan.most_shifts == 0) return 1;
  const double parts = d.seeds.empty() ? plan.subdomains : static_cast<double>(d.seeds.size());
  double first = 1;
  for (double coarseness = 2; coarseness <= kCoarsest; coarseness *= 2) {
    const double tets = tets_of(d.complexity, coarseness);
    if (tets < kLeastTets * parts) break;
    if (tets >= static_cast<double>(input_tets)) first = coarseness;
  }
  return first;
}

/// All subdomains wait for the seed that they come from: it makes no more tets than one of them will have,
/// but so many that its interface is little. More where the input is far from its metric: interfaces would be
/// of needles.
double tets_of_seed(double complexity, bool is_far, const PlanOptions& options) {
  constexpr double kLeast = 1e4;
  const double subdomains = is_far ? 4 : 1;
  return std::min(options.tets_of_seed,
                  std::max(kLeast, subdomains * tets_of(complexity, 1) / options.subdomains));
}

}  // namespace

std::uint32_t parts_at_first(const partition::InputMeasures& input, const PlanOptions& options) {
  constexpr double kFewTets = 100;
  // Boxes under anisotropic metrics have .1 to .5; meshes that were adapted to a metric of a coarser mesh, or
  // of another solution, .7 and more: these have interfaces as good as any, and are not to wait for seeds.
  constexpr double kFarMean = 0.65;
  // A tet is whole: a subdomain that has one with more than its share has the more to do, however others are
  // cut.
  constexpr double kMostOfShare = 2;
  const std::uint32_t all = options.subdomains;
  const auto tets = static_cast<double>(input.tets);
  const double coarseness = coarseness_to_divide(input.complexity, all);
  if (all < 2 || options.most_shifts == 0 || coarseness == 1) return all;
  const bool has_few = tets < kFewTets * all,
             is_far = input.mean_quality<kFarMean, is_crowded = input.largest_share * all> kMostOfShare;
  if (!has_few && !is_far && !is_crowded) return all;
  const double most = std::max(tets, tets_of(input.complexity, coarseness));
  if (options.partitioner.kind == partition::Partitioner::Kind::pqr)
    return most > options.tets_of_seed ? all : 1;  // it divides one mesh
  // A seed has some of the input's tets, too.
  const double parts =
      std::max(most / options.tets_of_seed,
               std::min(most / tets_of_seed(input.complexity, is_far, options), tets / kFewTets));
  return static_cast<std::uint32_t>(std::clamp(parts, 1.0, static_cast<double>(all)));
}

void plan_phases(const partition::Distributed& d, std::uint64_t input_tets, AdaptationPlan& plan) {
  constexpr std::uint64_t kCoarseShifts = 2;  // after one, some of the interface is still what it was
  const double dividing = d.seeds.empty() ? 0 : coarseness_to_divide(d.complexity, plan.subdomains);
  const bool curved = is_curved(*d.geometry);
  double first = std::max(coarseness_of_curved(d, input_tets, plan), dividing);
  if (d.seeds.size() == 1) first = dividing;  // one mesh has no interface that would have to follow
  plan.seeds = d.seeds;
  plan.coarsens = first > 1 && tets_of(d.complexity, first) < static_cast<double>(input_tets);
  plan.phases.clear();
  std::uint64_t round = 0;
  for (double coarseness = first; coarseness >= 1; coarseness /= 2) {
    if (!curved && coarseness != 1 && coarseness != dividing) continue;
    plan.phases.push_back({round, coarseness});
    if (!(coarseness == dividing && d.seeds.size() == 1)) round += kCoarseShifts;
    if (coarseness == dividing) plan.division = round++;
  }
}

}  // namespace weft::graph::adaptation
