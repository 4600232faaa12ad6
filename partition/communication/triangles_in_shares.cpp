// The rank of the nearest box first; its answer leaves few others that may know better.
#include "partition/communication/triangles_in_shares.h"

#include <algorithm>
#include <utility>

#include "meshing/base/parallel.h"
#include "meshing/base/release.h"
#include "partition/communication/reduce.h"

namespace weft::partition {

using meshing::Point;

TrianglesInShares::TrianglesInShares(Peers& peers, std::vector<Triangle> mine, const Limits& limits)
    : peers_(peers),
      limits_(limits),
      all_here_(peers.ranks() == 1 || partition::sum<std::uint64_t>(peers, mine.size()) <= limits.few),
      mine_(all_here_ && peers.ranks() > 1 ? allgather_joined(peers, mine) : std::move(mine)) {
  if (all_here_) return;
  constexpr std::size_t kBoxesOfShare = 16;
  const auto of_ranks = allgather(peers, mine_.boxes(kBoxesOfShare));
  std::vector<meshing::ClosestForest::Item> items;
  for (std::size_t r = 0; r < of_ranks.size(); ++r)
    for (const meshing::Box& box : of_ranks[r]) {
      items.push_back({box, static_cast<std::uint32_t>(boxes_.size())});
      boxes_.push_back({box, r});
    }
  root_ = tree_.add(items);  // more than few: not none
}

std::vector<TrianglesInShares::Found> TrianglesInShares::closest(std::span<const Point> points) const {
  std::vector<Found> found(points.size());
  if (all_here_) {
    meshing::for_each_index(points.size(), [&](std::size_t i) { found[i] = mine_.closest(points[i]); });
    return found;
  }
  const auto ranks = static_cast<std::uint64_t>(peers_.ranks());
  const std::size_t batch = std::max<std::size_t>(1, limits_.questions / ranks);
  const std::size_t most = partition::max(peers_, points.size());
  for (std::size_t begin = 0; begin < most; begin += batch) {
    const std::size_t first = std::min(begin, points.size());
    const std::size_t count = std::min(batch, points.size() - first);
    closest_of(points.subspan(first, count), std::span(found).subspan(first, count));
  }
  return found;
}

std::size_t TrianglesInShares::nearest_rank(const Point& p) const {
  const std::uint32_t box =
      tree_.closest(root_, p, [&](std::uint32_t i) { return boxes_[i].box.distance2(p); });
  return box < boxes_.size() ? boxes_[box].rank : 0;  // none: the distance overflows
}

void TrianglesInShares::closest_of(std::span<const Point> points, std::span<Found> found) const {
  std::vector<std::size_t> first(points.size());
  meshing::for_each_index(points.size(), [&](std::size_t i) { first[i] = nearest_rank(points[i]); });
  ask(
      points, [&](std::size_t i, const auto& add) { add(first[i]); }, found);
  std::vector<std::size_t> last_point(static_cast<std::size_t>(peers_.ranks()), points.size());
  const auto others_within = [&](std::size_t i, const auto& add) {
    last_point[first[i]] = i;
    tree_.visit_within(root_, points[i], found[i].distance2, [&](std::uint32_t box) {
      const auto& [around, rank] = boxes_[box];
      if (last_point[rank] == i || around.distance2(points[i]) > found[i].distance2) return;
      last_point[rank] = i;
      add(rank);
    });
  };
  ask(points, others_within, found);
}

/// All ranks: ranks_for(i, add) calls add(r) for each rank that is to be asked for point i.
template <class RanksFor>
void TrianglesInShares::ask(std::span<const Point> points, const RanksFor& ranks_for,
                            std::span<Found> found) const {
  const auto ranks = static_cast<std::size_t>(peers_.ranks());
  std::vector<std::vector<Question>> questions(ranks);
  std::vector<std::vector<std::uint32_t>> asked(ranks);  // which points
  for (std::size_t i = 0; i < points.size(); ++i)
    ranks_for(i, [&](std::size_t r) {
      questions[r].push_back({points[i], found[i].distance2});
      asked[r].push_back(static_cast<std::uint32_t>(i));
    });
  questions = partition::all_to_all(peers_, std::move(questions));
  std::vector<std::vector<Found>> answers(ranks);
  for (std::size_t r = 0; r < ranks; ++r) {
    answers[r].resize(questions[r].size());
    meshing::for_each_index(answers[r].size(), [&](std::size_t i) {
      answers[r][i] = mine_.closest(questions[r][i].point, questions[r][i].limit2);
    });
    meshing::release(questions[r]);
  }
  answers = partition::all_to_all(peers_, std::move(answers));
  for (std::size_t r = 0; r < ranks; ++r)
    for (std::size_t i = 0; i < answers[r].size(); ++i) {
      Found& best = found[asked[r][i]];
      if (answers[r][i].before(best)) best = answers[r][i];
    }
}

}  // namespace weft::partition
