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

/// The tets arrive in the order of their numbers, rank after rank, and keep it within each subdomain.
std::vector<TetRecord> by_subdomain(std::vector<std::vector<TetRecord>> arrived) {
  SubdomainId first(std::numeric_limits<std::uint32_t>::max()), last(0);
  std::size_t count = 0;
  for (const auto& of_rank : arrived) {
    for (const TetRecord& t : of_rank)
      first = std::min(first, t.subdomain), last = std::max(last, t.subdomain);
    count += of_rank.size();
  }
  if (count == 0) return {};
  std::vector<std::size_t> next(last.value - first.value + 2, 0);
  for (const auto& of_rank : arrived)
    for (const TetRecord& t : of_rank) ++next[t.subdomain.value - first.value + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<TetRecord> sorted(count);
  for (auto& of_rank : arrived) {
    for (const TetRecord& t : of_rank) sorted[next[t.subdomain.value - first.value]++] = t;
    meshing::release(of_rank);
  }
  return sorted;
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
  const auto home = [&](SubdomainId s) {
    return static_cast<std::size_t>(home_rank(s, num_subdomains, peers.ranks()));
  };
  std::vector<std::vector<TetRecord>> to_each(static_cast<std::size_t>(peers.ranks()));
  std::vector<std::size_t> tets_to(to_each.size(), 0);
  for (const SubdomainId s : subdomains) ++tets_to[home(s)];
  for (std::size_t r = 0; r < to_each.size(); ++r) to_each[r].reserve(tets_to[r]);
  for (std::size_t t = 0; t < slice.tets.size(); ++t)
    to_each[home(subdomains[t])].push_back(
        {slice.first_tet + t, slice.tets[t], slice.tet_refs[t], subdomains[t]});
  meshing::release(slice.tets);
  meshing::release(slice.tet_refs);
  return by_subdomain(partition::all_to_all(peers, std::move(to_each)));
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
  std::vector<InputHolder> met = all_to_all_joined(peers, std::move(to_each));
  std::sort(met.begin(), met.end());
  to_each.assign(ranks, {});
  Holders result;
  for (std::size_t begin = 0, end = 0; begin < met.size(); begin = end, ++result.used) {
    while (end < met.size() && met[end].vertex == met[begin].vertex) ++end;
    if (end - begin > 1) send_to_holders(std::span(met).subspan(begin, end - begin), num_subdomains, to_each);
  }
  result.used = partition::sum(peers, result.used);
  meshing::release(met);
  result.shared = all_to_all_joined(peers, std::move(to_each));
  std::sort(result.shared.begin(), result.shared.end());
  return result;
}

}  // namespace weft::partition
