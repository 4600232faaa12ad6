// Runs across the ends of shares: their owner adds up weights, which are integers, and tells the part.
#include "partition/decompose/runs.h"

#include <algorithm>

#include "meshing/mesh/mesh_data.h"
#include "meshing/metric/fit.h"
#include "partition/communication/reduce.h"
#include "partition/decompose/ordered_cuts.h"
#include "partition/decompose/slabs.h"

namespace weft::partition {
namespace {

using meshing::Tet;

constexpr std::uint64_t kTetsOfRun = 32;

/// The number of the tet that stands for a run.
std::uint64_t middle_of(std::uint64_t run, const Ranges& tets) {
  return std::min(run * kTetsOfRun + kTetsOfRun / 2, tets.total() - 1);
}

/// What this rank's tets add to a run.
struct RunShare {
  std::uint64_t run, weight;
};

/// The runs that this rank's tets are in, in their order, at the ranks that have their middles.
std::vector<std::vector<RunShare>> shares_of_runs(const Peers& peers, const Ranges& tets,
                                                  std::span<const std::uint64_t> weights) {
  std::vector<std::vector<RunShare>> to_each(static_cast<std::size_t>(peers.ranks()));
  std::uint64_t number = tets.first(peers.rank());
  for (std::size_t i = 0; i < weights.size();) {
    RunShare share{number / kTetsOfRun, 0};
    for (; i < weights.size() && number / kTetsOfRun == share.run; ++i, ++number) share.weight += weights[i];
    to_each[tets.rank_of(middle_of(share.run, tets))].push_back(share);
  }
  return to_each;
}

/// This rank's runs, ascending without gaps, as the partitioners take them.
struct RunItems {
  std::uint64_t first = 0;
  std::vector<std::uint64_t> weights, numbers;
  std::vector<TetCorners> corners;
  std::vector<meshing::Point> centres;
  std::vector<meshing::SymTensor> cut_tensors;
};

RunItems items_of(const Peers& peers, const Ranges& tets, const std::vector<std::vector<RunShare>>& arrived,
                  const std::function<RunSample(std::size_t)>& sample) {
  RunItems items;
  const std::uint64_t begin = tets.first(peers.rank()), end = tets.first(peers.rank() + 1);
  items.first = begin / kTetsOfRun;
  while (items.first * kTetsOfRun < end && middle_of(items.first, tets) < begin) ++items.first;
  for (std::uint64_t run = items.first; run * kTetsOfRun < end && middle_of(run, tets) < end; ++run) {
    const RunSample s = sample(middle_of(run, tets) - begin);
    items.numbers.push_back(run);
    items.corners.push_back(s.corners);
    items.centres.push_back(0.25 * (s.corners[0] + s.corners[1] + (s.corners[2] + s.corners[3])));
    items.cut_tensors.push_back(s.cut_tensor);
  }
  items.weights.assign(items.numbers.size(), 0);
  for (const auto& of_rank : arrived)
    for (const RunShare& share : of_rank) items.weights[share.run - items.first] += share.weight;
  return items;
}

}  // namespace

bool follow_each_other(Peers& peers, std::span<const Tet> tets) {
  meshing::Followers mine = meshing::count_followers(tets);
  std::vector<Tet> ends;
  if (!tets.empty()) ends = {tets.front(), tets.back()};
  const std::vector<std::vector<Tet>> all = allgather(peers, ends);
  for (std::size_t r = static_cast<std::size_t>(peers.rank()) + 1; r < all.size() && !tets.empty(); ++r) {
    if (all[r].empty()) continue;
    mine += meshing::count_followers(std::array{tets.back(), all[r].front()});
    break;
  }
  const std::vector<std::uint64_t> sums = partition::sum(peers, std::vector{mine.all, mine.joined});
  return meshing::Followers{sums[0], sums[1]}.in_order();
}

std::vector<SubdomainId> bisect_runs(Peers& peers, const Ranges& tets, std::span<const double> work,
                                     const std::function<RunSample(std::size_t)>& sample,
                                     std::uint32_t num_subdomains) {
  const std::vector<std::uint64_t> weights = integer_weights(peers, work);
  std::vector<std::vector<RunShare>> mine = shares_of_runs(peers, tets, weights);
  const std::vector<std::vector<RunShare>> arrived = partition::all_to_all(peers, mine);
  const RunItems items = items_of(peers, tets, arrived, sample);
  const std::vector<SubdomainId> parts = bisection(
      peers, {items.centres, items.corners, items.weights, items.numbers, items.cut_tensors}, num_subdomains);
  std::vector<std::vector<SubdomainId>> answers(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (const RunShare& share : arrived[r]) answers[r].push_back(parts[share.run - items.first]);
  answers = partition::all_to_all(peers, std::move(answers));
  // Owners ascend with the runs, and so do the answers.
  std::vector<SubdomainId> result;
  result.reserve(weights.size());
  std::uint64_t number = tets.first(peers.rank());
  for (std::size_t r = 0; r < mine.size(); ++r)
    for (std::size_t k = 0; k < mine[r].size(); ++k)
      for (; result.size() < weights.size() && number / kTetsOfRun == mine[r][k].run; ++number)
        result.push_back(answers[r][k]);
  return result;
}

}  // namespace weft::partition
