// Vertices are dealt out along a Morton curve; rings of tets are asked for at the owners of the outermost
// vertices.
#include "partition/metric/part_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "meshing/base/freed_memory.h"
#include "meshing/base/place_in.h"
#include "meshing/base/place_index.h"
#include "meshing/base/release.h"
#include "meshing/base/sort_unique.h"
#include "meshing/mesh/predicates.h"
#include "partition/communication/input_issue.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/reduce.h"
#include "partition/slice/slice_checks.h"
#include "partition/slice/used_numbers.h"

namespace weft::partition {
namespace {

using meshing::Point;
using meshing::SymTensor;

template <class T>
std::vector<T> joined(const std::vector<std::vector<T>>& parts) {
  std::vector<T> all;
  for (const std::vector<T>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace

PartDomain::PartDomain(Peers& peers, const MeshSlice& slice, int rings, const MortonShares& shares,
                       const std::atomic<bool>* interrupt)
    : MetricDomain(interrupt),
      peers_(peers),
      points_(peers, slice.points.size()),
      me_(static_cast<std::uint32_t>(peers.rank())) {
  check_slices(peers, slice, points_, Ranges(peers, slice.tets.size()), SliceMetric::missing);
  choose_owners(slice, shares);
  TetLists tets = first_ring(slice);
  if (rings > 1) {
    const std::vector<TetRecord> first = joined(std::exchange(tets, {}));
    std::vector<TetRecord> all = first;
    std::vector<std::vector<std::uint32_t>> asked(static_cast<std::size_t>(peers_.ranks()));
    for (int ring = 1; ring < rings; ++ring) add_ring(first, asked, all);
    tets.push_back(std::move(all));
  }
  build_mesh(slice, std::move(tets));
  join_copies();
  volumes_ = meshing::vertex_volumes(mesh_);
  meshing::give_back_freed_memory();  // to make it took several times as much as it keeps
}

void PartDomain::choose_owners(const MeshSlice& slice, const MortonShares& shares) {
  if (points_.total() > 0 && norm(shares.box.size()) > 0) largest_size_ = norm(shares.box.size());
  slice_owners_ = shares.owners(slice.points);
  std::vector<std::vector<std::uint32_t>> to_each(static_cast<std::size_t>(peers_.ranks()));
  for (std::size_t v = 0; v < slice_owners_.size(); ++v)
    to_each[slice_owners_[v]].push_back(static_cast<std::uint32_t>(slice.first_point + v));
  owned_numbers_ = all_to_all_joined(peers_, std::move(to_each));  // ascending: so are slices with the ranks
}

PartDomain::TetLists PartDomain::first_ring(const MeshSlice& slice) const {
  const std::vector<std::uint32_t> vertices = used_numbers(slice.tets), owners = owners_of(vertices);
  const meshing::PlaceIndex place(vertices);
  using Four = std::array<std::uint32_t, 4>;
  const auto owners_at = [&](const Four& tet) {
    return Four{owners[place(tet[0])], owners[place(tet[1])], owners[place(tet[2])], owners[place(tet[3])]};
  };
  const auto for_each_rank = [](const Four& of_tet, const auto& visit) {
    for (auto at = of_tet.begin(); at != of_tet.end(); ++at)
      if (std::find(of_tet.begin(), at, *at) == at) visit(*at);
  };
  TetLists to_each(static_cast<std::size_t>(peers_.ranks()));
  std::vector<std::size_t> counts(to_each.size(), 0);
  for (const Four& tet : slice.tets) for_each_rank(owners_at(tet), [&](std::uint32_t r) { ++counts[r]; });
  for (std::size_t r = 0; r < to_each.size(); ++r) to_each[r].reserve(counts[r]);
  for (std::size_t t = 0; t < slice.tets.size(); ++t) {
    const TetRecord record{slice.first_tet + t, slice.tets[t], owners_at(slice.tets[t])};
    for_each_rank(record.owners, [&](std::uint32_t r) { to_each[r].push_back(record); });
  }
  return partition::all_to_all(peers_, std::move(to_each));
}

/// Adds the tets at all vertices of `tets`, which their owners have among their first rings. Of those that
/// have been `asked` for, ascending by rank, all are here.
void PartDomain::add_ring(const std::vector<TetRecord>& first, std::vector<std::vector<std::uint32_t>>& asked,
                          std::vector<TetRecord>& tets) const {
  std::vector<std::vector<std::uint32_t>> wanted(asked.size());
  for (const TetRecord& tet : tets)
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t owner = tet.owners[i], v = tet.vertices[i];
      if (owner != me_ && !std::ranges::binary_search(asked[owner], v)) wanted[owner].push_back(v);
    }
  for (std::size_t r = 0; r < wanted.size(); ++r) {
    meshing::sort_unique(wanted[r]);
    const auto old = static_cast<std::ptrdiff_t>(asked[r].size());
    asked[r].insert(asked[r].end(), wanted[r].begin(), wanted[r].end());
    std::inplace_merge(asked[r].begin(), asked[r].begin() + old, asked[r].end());
  }
  wanted = partition::all_to_all(peers_, std::move(wanted));
  std::vector<std::vector<TetRecord>> replies(wanted.size());
  for (std::size_t r = 0; r < wanted.size(); ++r) {
    if (wanted[r].empty()) continue;
    for (const TetRecord& tet : first)
      if (std::ranges::any_of(tet.vertices,
                              [&](std::uint32_t v) { return std::ranges::binary_search(wanted[r], v); }))
        replies[r].push_back(tet);
  }
  const std::vector<TetRecord> more = all_to_all_joined(peers_, std::move(replies));
  tets.insert(tets.end(), more.begin(), more.end());
  std::ranges::sort(tets, {}, &TetRecord::number);
  const auto rest = std::ranges::unique(tets, {}, &TetRecord::number);
  tets.erase(rest.begin(), rest.end());
}

std::uint32_t PartDomain::local(std::uint32_t number) const {
  return static_cast<std::uint32_t>(meshing::place_in(numbers_, number));
}

void PartDomain::build_mesh(const MeshSlice& slice, TetLists&& tets) {
  std::vector<std::array<std::uint32_t, 2>> vertices;  // number and owner
  for (const std::uint32_t number : owned_numbers_) vertices.push_back({number, me_});
  std::size_t num_tets = 0;
  for (const std::vector<TetRecord>& list : tets) {
    num_tets += list.size();
    for (const TetRecord& tet : list)
      for (std::size_t i = 0; i < 4; ++i)
        if (tet.owners[i] != me_) vertices.push_back({tet.vertices[i], tet.owners[i]});
  }
  meshing::sort_unique(vertices);
  for (const auto& [number, owner] : vertices) {
    numbers_.push_back(number);
    owners_.push_back(owner);
  }
  mesh_.points = from_slices(slice.points);
  const meshing::PlaceIndex place(numbers_);
  mesh_.tets.reserve(num_tets);
  std::optional<InputIssue> first_inverted;
  for (std::vector<TetRecord>& list : tets) {
    for (const TetRecord& tet : list) {
      std::array<std::uint32_t, 4>& corners = mesh_.tets.emplace_back();
      std::array<const Point*, 4> points;
      for (std::size_t i = 0; i < 4; ++i) {
        corners[i] = place(tet.vertices[i]);
        points[i] = &mesh_.points[corners[i]];
      }
      if (!first_inverted) first_inverted = inverted(tet.number, tet.vertices, points);
    }
    meshing::release(list);
  }
  mesh_.point_refs.resize(mesh_.points.size());
  mesh_.tet_refs.resize(mesh_.tets.size());
  throw_first(peers_, first_inverted);
}

void PartDomain::join_copies() {
  std::vector<std::vector<std::uint32_t>> wanted(static_cast<std::size_t>(peers_.ranks()));
  taken_.resize(wanted.size());
  for (std::uint32_t v = 0; v < owners_.size(); ++v)
    if (owners_[v] != me_) {
      wanted[owners_[v]].push_back(numbers_[v]);
      taken_[owners_[v]].push_back(v);
    }
  given_ = partition::all_to_all(peers_, std::move(wanted));
  for (std::uint32_t r = 0; r < given_.size(); ++r)
    for (std::size_t i = 0; i < given_[r].size(); ++i) {
      given_[r][i] = local(given_[r][i]);
      copies_.push_back({given_[r][i], r, i});
    }
  std::sort(copies_.begin(), copies_.end());
}

double PartDomain::max(double mine) const { return partition::max(peers_, mine); }

bool PartDomain::any(bool mine) const { return partition::max(peers_, mine ? 1 : 0) != 0; }

double PartDomain::sum(const std::function<double(std::size_t)>& at) const {
  std::vector<double> terms;
  terms.reserve(owned_numbers_.size());
  for (std::size_t v = 0; v < owners_.size(); ++v)
    if (owns(v))
      terms.push_back(std::max(0.0, at(v)));  // the volume of a flat tet may be computed as negative
  return ordered_sum(peers_, terms);
}

double PartDomain::signed_sum(const std::function<double(std::size_t)>& at) const {
  std::array<std::vector<double>, 2> terms;  // above 0 and below
  for (auto& some : terms) some.reserve(owned_numbers_.size());
  for (std::size_t v = 0; v < owners_.size(); ++v)
    if (owns(v)) {
      const double value = at(v);
      terms[0].push_back(std::max(0.0, value));
      terms[1].push_back(std::max(0.0, -value));
    }
  const std::vector<double> sums =
      ordered_sums(peers_, std::array<std::span<const double>, 2>{terms[0], terms[1]});
  return sums[0] - sums[1];
}

void PartDomain::refresh(std::size_t columns, std::vector<double>& values) const {
  std::vector<std::vector<double>> to_each(given_.size());
  for (std::size_t r = 0; r < given_.size(); ++r) {
    to_each[r].reserve(given_[r].size() * columns);
    for (const std::uint32_t v : given_[r])
      to_each[r].insert(to_each[r].end(), values.begin() + static_cast<std::ptrdiff_t>(v * columns),
                        values.begin() + static_cast<std::ptrdiff_t>((v + 1) * columns));
  }
  const std::vector<std::vector<double>> from_each = partition::all_to_all(peers_, std::move(to_each));
  for (std::size_t r = 0; r < taken_.size(); ++r)
    for (std::size_t i = 0; i < taken_[r].size(); ++i)
      std::copy_n(from_each[r].data() + i * columns, columns, values.data() + taken_[r][i] * columns);
}

double PartDomain::complexity(const meshing::LogMetricField& field) const {
  return sum([&](std::size_t v) { return std::exp(0.5 * trace(field[v])) * volumes_[v]; });
}

std::vector<std::uint32_t> PartDomain::refresh_changed(std::span<const std::uint32_t> changed,
                                                       std::vector<SymTensor>& values) const {
  struct Change {
    std::uint64_t place;
    SymTensor value;
  };
  std::vector<std::vector<Change>> to_each(given_.size());
  for (const std::uint32_t v : changed) {
    auto copy = std::ranges::lower_bound(copies_, v, {}, &Copy::vertex);
    for (; copy != copies_.end() && copy->vertex == v; ++copy)
      to_each[copy->rank].push_back({copy->place, values[v]});
  }
  std::vector<std::uint32_t> refreshed;
  const std::vector<std::vector<Change>> from_each = partition::all_to_all(peers_, std::move(to_each));
  for (std::size_t r = 0; r < from_each.size(); ++r)
    for (const Change& change : from_each[r]) {
      const std::uint32_t v = taken_[r][change.place];
      values[v] = change.value;
      refreshed.push_back(v);
    }
  return refreshed;
}

}  // namespace weft::partition
