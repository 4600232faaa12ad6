// Points come from the ranks that have them, which know who has the others.
#include "partition/fields/slice_piece.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <ranges>
#include <utility>

#include "meshing/base/sort_unique.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/ranges.h"
#include "partition/communication/vertex_numbers.h"
#include "partition/slice/used_numbers.h"

namespace weft::partition {
namespace {

/// The vertices of these tets and the slice's own points, ascending: every point of the mesh is somebody's.
std::vector<std::uint32_t> numbers_here(const MeshSlice& slice, std::span<const std::uint32_t> more) {
  std::vector<std::uint32_t> used = used_numbers(slice.tets);
  if (!more.empty()) {
    used.insert(used.end(), more.begin(), more.end());
    meshing::sort_unique(used);
  }
  const auto first = static_cast<std::uint32_t>(slice.first_point);
  const auto own = std::views::iota(first, first + static_cast<std::uint32_t>(slice.points.size()));
  std::vector<std::uint32_t> numbers;
  numbers.reserve(used.size() + own.size());
  std::ranges::set_union(used, own, std::back_inserter(numbers));
  return numbers;
}

/// All ranks: who else has these points. Whoever has a point in its slice knows who asks for it; most are
/// asked for by one rank alone.
std::vector<SubdomainStart::Shared> others_of(Peers& peers, const MeshSlice& slice, const Ranges& points,
                                              const std::vector<std::uint32_t>& numbers) {
  struct Holder {
    std::uint32_t number, rank;
    auto operator<=>(const Holder&) const = default;
  };
  const auto asked = sent_to_owners(peers, points, numbers);
  std::vector<std::uint8_t> users(slice.points.size(), 0);
  const auto users_of = [&](std::uint32_t number) -> std::uint8_t& {
    return users[number - slice.first_point];
  };
  for (const auto& of_rank : asked)
    for (const std::uint32_t number : of_rank)
      if (std::uint8_t& known = users_of(number); known < 2) ++known;
  std::vector<Holder> holders;
  const auto for_each_shared = [&](const auto& f) {
    for (std::uint32_t r = 0; r < asked.size(); ++r)
      for (const std::uint32_t number : asked[r])
        if (users_of(number) > 1) f(Holder{number, r});
  };
  for_each_shared([&](const Holder& holder) { holders.push_back(holder); });
  std::ranges::sort(holders);
  std::vector<std::vector<Holder>> answers(asked.size());
  for_each_shared([&](const Holder& asking) {
    for (const Holder& holder : std::ranges::equal_range(holders, asking.number, {}, &Holder::number))
      if (holder.rank != asking.rank) answers[asking.rank].push_back(holder);
  });
  PlacesOfNumbers places(numbers);
  std::vector<SubdomainStart::Shared> shared;
  for (const auto& of_rank : partition::all_to_all(peers, std::move(answers)))
    for (const Holder& holder : of_rank) shared.push_back({places(holder.number), SubdomainId(holder.rank)});
  std::ranges::sort(shared);
  return shared;
}

}  // namespace

SlicePiece piece_of_slice(Peers& peers, const MeshSlice& slice, SliceMetric metric,
                          std::span<const std::uint32_t> more) {
  const Ranges points(peers, slice.points.size());
  SlicePiece result{{}, numbers_here(slice, more)};
  const std::vector<std::uint32_t>& numbers = result.numbers;
  MeshPiece& piece = result.piece;
  piece.subdomain = SubdomainId(static_cast<std::uint32_t>(peers.rank()));
  piece.mesh.points =
      fetch<meshing::Point>(peers, points, numbers, [&](std::size_t i) { return slice.points[i]; });
  piece.mesh.point_refs.resize(numbers.size());
  if (metric == SliceMetric::given)
    piece.log_metrics = fetch<meshing::LogMetric>(peers, points, numbers,
                                                  [&](std::size_t i) { return slice.log_metrics[i]; });
  else
    piece.log_metrics.resize(numbers.size());
  piece.ids.reserve(numbers.size());
  for (const std::uint32_t number : numbers) piece.ids.emplace_back(SubdomainId(0), number);
  piece.shared = others_of(peers, slice, points, numbers);
  PlacesOfNumbers places(numbers);
  piece.mesh.tets.reserve(slice.tets.size());
  for (const meshing::Tet& tet : slice.tets) piece.mesh.tets.push_back(places(tet));
  piece.mesh.tet_refs = slice.tet_refs;
  return result;
}

}  // namespace weft::partition
