// Moves the tets and finds the holders of their vertices.
#include "partition/distribute/tet_records.h"

#include <limits>
#include <numeric>
#include <utility>

#include "meshing/base/release.h"
#include "partition/communication/reduce.h"
#include "partition/communication/vertex_numbers.h"

namespace weft::partition {
namespace {

std::vector<InputHolder> holders_here(std::span<const TetRecord> tets) {
  std::vector<InputHolder> result;
  for (std::size_t begin = 0, end = 0; begin < tets.size(); begin = end) {
    while (end < tets.size() && tets[end].subdomain == tets[begin].subdomain) ++end;
    for (const std::uint32_t v : vertices_of(tets.subspan(begin, end - begin)))
      result.push_back({v, tets[begin].subdomain});
  }
  return result;
}

/// By subdomain, in which they keep their order. `for_each` calls a function with each record, and does so
/// three times.
template <class ForEach>
std::vector<TetRecord> by_subdomain(const ForEach& for_each) {
  SubdomainId first(std::numeric_limits<std::uint32_t>::max()), last(0);
  std::size_t count = 0;
  for_each([&](const TetRecord& t) {
    first = std::min(first, t.subdomain), last = std::max(last, t.subdomain);
    ++count;
  });
  if (count == 0) return {};
  std::vector<std::size_t> next(last.value - first.value + 2, 0);
  for_each([&](const TetRecord& t) { ++next[t.subdomain.value - first.value + 1]; });
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<TetRecord> sorted(count);
  for_each([&](const TetRecord& t) { sorted[next[t.subdomain.value - first.value]++] = t; });
  return sorted;
}

/// Those of vertices that have several, sorted; `used`: how many vertices there are. Each is named once by
/// each of its holders, and by one of them mostly. `met`: at the rank that vertex % ranks is.
std::vector<InputHolder> of_several(std::span<const InputHolder> met, std::uint32_t ranks,
                                    std::uint64_t& used) {
  std::uint32_t largest = 0;
  for (const InputHolder& holder : met) largest = std::max(largest, holder.vertex);
  std::vector<std::uint8_t> times(std::size_t{largest} / ranks + 1, 0);
  for (const InputHolder& holder : met) {
    std::uint8_t& known = times[holder.vertex / ranks];
    used += known == 0;
    known = static_cast<std::uint8_t>(std::min(known + 1, 2));
  }
  std::vector<InputHolder> several;
  for (const InputHolder& holder : met)
    if (times[holder.vertex / ranks] > 1) several.push_back(holder);
  std::sort(several.begin(), several.end());
  return several;
}

/// The holders of one vertex, sorted, to each rank that has one of them.
void send_to_holders(std::span<const InputHolder> holders, std::uint32_t num_subdomains,
                     std::vector<std::vector<InputHolder>>& to_each) {
  int last = -1;
  for (const InputHolder& holder : holders) {
    const int rank = home_rank(holder.subdomain, num_subdomains, static_cast<int>(to_each.size()));
    if (rank == last) continue;
    auto& list = to_each[static_cast<std::size_t>(rank)];
    list.insert(list.end(), holders.begin(), holders.end());
    last = rank;
  }
}

}  // namespace

std::vector<TetRecord> send_tets_home(Peers& peers, MeshSlice& slice, std::span<const SubdomainId> subdomains,
                                      std::uint32_t num_subdomains) {
  const auto me = static_cast<std::size_t>(peers.rank());
  const auto home = [&](std::size_t t) {
    return static_cast<std::size_t>(home_rank(subdomains[t], num_subdomains, peers.ranks()));
  };
  const auto record = [&](std::size_t t) {
    return TetRecord{slice.first_tet + t, slice.tets[t], slice.tet_refs[t], subdomains[t]};
  };
  std::vector<std::size_t> tets_to(static_cast<std::size_t>(peers.ranks()), 0);
  for (std::size_t t = 0; t < slice.tets.size(); ++t) ++tets_to[home(t)];
  std::vector<std::vector<TetRecord>> to_each(tets_to.size());
  for (std::size_t r = 0; r < to_each.size(); ++r)
    if (r != me) to_each[r].reserve(tets_to[r]);
  for (std::size_t t = 0; t < slice.tets.size(); ++t)
    if (const std::size_t r = home(t); r != me) to_each[r].push_back(record(t));
  const std::vector<std::vector<TetRecord>> arrived = partition::all_to_all(peers, std::move(to_each));
  // Numbers ascend with the ranks; those from here have stayed in the slice.
  std::vector<TetRecord> mine = by_subdomain([&](const auto& f) {
    for (std::size_t r = 0; r < arrived.size(); ++r) {
      for (const TetRecord& t : arrived[r]) f(t);
      for (std::size_t t = 0; r == me && t < slice.tets.size(); ++t)
        if (home(t) == me) f(record(t));
    }
  });
  meshing::release(slice.tets);
  meshing::release(slice.tet_refs);
  return mine;
}

std::vector<std::uint32_t> vertices_of(std::span<const TetRecord> tets) {
  return distinct_vertices(
      tets, [](const TetRecord& tet) -> const auto& { return tet.vertices; });
}

std::span<const InputHolder> Holders::of(std::uint32_t vertex) const {
  const auto begin = std::lower_bound(shared.begin(), shared.end(), InputHolder{vertex, SubdomainId(0)});
  auto end = begin;
  while (end != shared.end() && end->vertex == vertex) ++end;
  return {begin, end};
}

Holders find_holders(Peers& peers, std::span<const TetRecord> tets, std::uint32_t num_subdomains) {
  const auto ranks = static_cast<std::uint32_t>(peers.ranks());
  std::vector<std::vector<InputHolder>> to_each(ranks);
  for (const InputHolder& holder : holders_here(tets)) to_each[holder.vertex % ranks].push_back(holder);
  Holders result;
  const std::vector<InputHolder> met =
      of_several(all_to_all_joined(peers, std::move(to_each)), ranks, result.used);
  to_each.assign(ranks, {});
  for (std::size_t begin = 0, end = 0; begin < met.size(); begin = end) {
    while (end < met.size() && met[end].vertex == met[begin].vertex) ++end;
    send_to_holders(std::span(met).subspan(begin, end - begin), num_subdomains, to_each);
  }
  result.used = partition::sum(peers, result.used);
  result.shared = all_to_all_joined(peers, std::move(to_each));
  std::sort(result.shared.begin(), result.shared.end());
  return result;
}

}  // namespace weft::partition
