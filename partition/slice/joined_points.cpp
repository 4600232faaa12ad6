// All copies of a point meet at a home rank, which follows from the ID or the place.
#include "partition/slice/joined_points.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <tuple>

#include "meshing/base/place_in.h"
#include "meshing/base/release.h"
#include "meshing/base/sort_unique.h"
#include "meshing/io/files/point_merger.h"
#include "partition/communication/home_rank.h"
#include "partition/communication/point_limit.h"
#include "partition/communication/reduce.h"

namespace weft::partition {
namespace {

using meshing::Point;

struct CopyRecord {
  EntityKey<1> key;  ///< the ID, or a hash of the place
  Point place;       ///< without IDs
  std::uint64_t copy;

  auto order() const { return std::tuple(key, place.x, place.y, place.z, copy); }
  bool is_same_point(const CopyRecord& other) const { return key == other.key && place == other.place; }
};

/// What the home says: the first copy, and whether the one asked about is the last.
struct CopyAnswer {
  std::uint64_t first, is_last;
};

std::vector<std::vector<CopyAnswer>> answers_to(std::vector<std::vector<CopyRecord>> arrived) {
  struct Asked {
    CopyRecord record;
    std::size_t rank, index;
  };
  std::vector<Asked> all;
  std::vector<std::vector<CopyAnswer>> answers(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r) {
    answers[r].resize(arrived[r].size());
    for (std::size_t i = 0; i < arrived[r].size(); ++i) all.push_back({arrived[r][i], r, i});
    meshing::release(arrived[r]);
  }
  std::ranges::sort(all, {}, [](const Asked& a) { return a.record.order(); });
  for (std::size_t i = 0, first = 0; i < all.size(); ++i) {
    if (!all[i].record.is_same_point(all[first].record)) first = i;
    const bool is_last = i + 1 == all.size() || !all[i + 1].record.is_same_point(all[i].record);
    answers[all[i].rank][all[i].index] = {all[first].record.copy, is_last};
  }
  return answers;
}

}  // namespace

JoinedPoints::JoinedPoints(Peers& peers, std::span<const Point> copies, std::span<const std::int64_t> ids,
                           bool by_ids)
    : copies_(peers, copies.size()) {
  const std::vector<std::uint64_t> first_copies = find_first_copies(peers, copies, ids, by_ids);
  total_ = partition::sum(peers, static_cast<std::uint64_t>(std::ranges::count(is_first_, 1)));
  refuse_too_many_points(total_);
  if (by_ids && ids_are_numbers(peers, ids)) {
    numbers_.assign(ids.begin(), ids.end());
  } else {
    number_by_first_copies(peers, first_copies);
  }
}

JoinedPoints::JoinedPoints(Peers& peers, std::uint64_t num_points_here)
    : copies_(peers, num_points_here), total_(copies_.total()) {
  refuse_too_many_points(total_);
  numbers_.resize(num_points_here);
  is_first_.assign(num_points_here, 1);
  is_last_.assign(num_points_here, 1);
  std::iota(numbers_.begin(), numbers_.end(), static_cast<std::uint32_t>(copies_.first(peers.rank())));
}

/// Of the copies here; sets the flags.
std::vector<std::uint64_t> JoinedPoints::find_first_copies(Peers& peers, std::span<const Point> copies,
                                                           std::span<const std::int64_t> ids, bool by_ids) {
  const std::uint64_t first = copies_.first(peers.rank());
  Rendezvous<1, CopyRecord> mail(peers.ranks());
  for (std::size_t i = 0; i < copies.size(); ++i) {
    CopyRecord record{{}, {}, first + i};
    if (by_ids) {
      record.key = {GlobalId::from_value(static_cast<std::uint64_t>(ids[i]))};
    } else {
      for (int c = 0; c < 3; ++c) record.place[c] = copies[i][c] + 0.0;  // turns -0 into 0
      record.key = {GlobalId::from_value(meshing::PointHash{}(record.place))};
    }
    mail.add(record);
  }
  const std::vector<CopyAnswer> answers = mail.answer(peers, answers_to(mail.deliver(peers)));
  std::vector<std::uint64_t> first_copies;
  first_copies.reserve(answers.size());
  for (std::size_t i = 0; i < answers.size(); ++i) {
    first_copies.push_back(answers[i].first);
    is_first_.push_back(answers[i].first == first + i);
    is_last_.push_back(answers[i].is_last != 0);
  }
  return first_copies;
}

/// Whether they are 0, 1, 2, ...: the order of the points before the mesh was cut. As many different ones as
/// there are points, none below 0 or too large, are all of these.
bool JoinedPoints::ids_are_numbers(Peers& peers, std::span<const std::int64_t> ids) const {
  const bool fit = std::ranges::all_of(
      ids, [&](std::int64_t id) { return id >= 0 && static_cast<std::uint64_t>(id) < total_; });
  return partition::max(peers, static_cast<int>(!fit)) == 0;
}

/// In the order in which points come first.
void JoinedPoints::number_by_first_copies(Peers& peers, const std::vector<std::uint64_t>& first_copies) {
  const Ranges points(peers, static_cast<std::uint64_t>(std::ranges::count(is_first_, 1)));
  numbers_.resize(first_copies.size());
  auto next = static_cast<std::uint32_t>(points.first(peers.rank()));
  std::vector<std::uint64_t> elsewhere;
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    if (is_first_[i]) {
      numbers_[i] = next++;
    } else {
      elsewhere.push_back(first_copies[i]);
    }
  }
  meshing::sort_unique(elsewhere);
  const std::vector<std::uint32_t> found = numbers_of(peers, elsewhere);
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    if (!is_first_[i]) numbers_[i] = found[meshing::place_in(elsewhere, first_copies[i])];
}

}  // namespace weft::partition
