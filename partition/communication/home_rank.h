// Each entity has a home rank that follows from the ids of its vertices alone: records of all copies of the
// entity meet there, on whatever ranks its subdomains are.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "meshing/base/parallel.h"
#include "partition/communication/peers.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// An entity by the ids of its vertices, ascending.
template <std::size_t N>
using EntityKey = std::array<GlobalId, N>;

template <std::size_t N>
EntityKey<N> sorted_key(EntityKey<N> ids) {
  std::sort(ids.begin(), ids.end());
  return ids;
}

template <std::size_t N>
std::uint64_t hash_of(const EntityKey<N>& key) {
  std::uint64_t hash = 0;
  for (const GlobalId id : key) hash = (hash ^ std::hash<GlobalId>{}(id)) * 0xD6E8FEB86659FD93ull;
  return hash;
}

template <std::size_t N>
int home_rank(const EntityKey<N>& key, int ranks) {
  return static_cast<int>((hash_of<N>(key) >> 32) % static_cast<std::uint64_t>(ranks));
}

/// Records on their way to the homes of their keys, and the way back: answers come in the order of the
/// records.
template <std::size_t N, class Record>
class Rendezvous {
 public:
  explicit Rendezvous(int ranks) : outgoing_(static_cast<std::size_t>(ranks)) {}

  /// Record has a member `key`.
  void add(const Record& record) {
    const int home = home_rank<N>(record.key, static_cast<int>(outgoing_.size()));
    homes_.push_back(home);
    outgoing_[static_cast<std::size_t>(home)].push_back(record);
  }

  /// All ranks: what has arrived here, by rank of origin.
  std::vector<std::vector<Record>> deliver(Peers& peers) {
    return partition::all_to_all(peers, std::move(outgoing_));
  }

  /// All ranks, after deliver(): answers[r][i] is for arrived[r][i]; returns those to this rank's records.
  template <class Answer>
  std::vector<Answer> answer(Peers& peers, const std::vector<std::vector<Answer>>& answers) const {
    const std::vector<std::vector<Answer>> back = partition::all_to_all(peers, answers);
    std::vector<std::size_t> next(back.size());
    std::vector<Answer> mine;
    mine.reserve(homes_.size());
    for (const int home : homes_) mine.push_back(back[home][next[home]++]);
    return mine;
  }

 private:
  std::vector<int> homes_;  ///< of each record
  std::vector<std::vector<Record>> outgoing_;
};

/// Where a record has arrived: arrived[rank][index].
struct Arrival {
  std::size_t rank, index;
};

/// Calls visit(span of Arrival) for the records of each key, in no order, several at a time (TBB, in the
/// caller's arena).
template <std::size_t N, class Record, class Visit>
void for_each_key(const std::vector<std::vector<Record>>& arrived, const Visit& visit) {
  constexpr std::size_t kBuckets = 64;
  struct Keyed {
    EntityKey<N> key;
    Arrival at;
  };
  const auto bucket_of = [](const Record& record) { return hash_of<N>(record.key) >> 20 & (kBuckets - 1); };
  std::array<std::size_t, kBuckets + 1> begins{};
  for (const auto& of_rank : arrived)
    for (const Record& record : of_rank) ++begins[bucket_of(record) + 1];
  for (std::size_t b = 0; b < kBuckets; ++b) begins[b + 1] += begins[b];
  std::vector<Keyed> places(begins[kBuckets]);
  auto next = begins;
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (std::size_t i = 0; i < arrived[r].size(); ++i)
      places[next[bucket_of(arrived[r][i])]++] = {arrived[r][i].key, {r, i}};
  meshing::for_each_large(kBuckets, [&](std::size_t b) {
    const std::span<Keyed> bucket = std::span(places).subspan(begins[b], begins[b + 1] - begins[b]);
    std::ranges::sort(bucket, {}, &Keyed::key);
    std::vector<Arrival> group;
    for (std::size_t p = 0; p < bucket.size();) {
      group.clear();
      const std::size_t first = p;
      for (; p < bucket.size() && bucket[p].key == bucket[first].key; ++p) group.push_back(bucket[p].at);
      visit(std::span<const Arrival>(group));
    }
  });
}

/// An entity that a subdomain has and others may have too.
template <std::size_t N>
struct Holding {
  EntityKey<N> key;
  std::uint64_t subdomain;  ///< 64 bits: no padding in messages
};

/// All ranks: for each of these entities 1 where no lower subdomain on any rank has named it too, else 0.
template <std::size_t N>
std::vector<std::uint8_t> held_by_no_lower(Peers& peers, std::span<const Holding<N>> holdings) {
  Rendezvous<N, Holding<N>> mail(peers.ranks());
  for (const Holding<N>& holding : holdings) mail.add(holding);
  const auto arrived = mail.deliver(peers);

  std::vector<std::vector<std::uint8_t>> lowest(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r) lowest[r].resize(arrived[r].size());
  for_each_key<N>(arrived, [&](std::span<const Arrival> named) {
    const auto subdomain = [&](const Arrival& at) { return arrived[at.rank][at.index].subdomain; };
    const std::uint64_t least = subdomain(*std::ranges::min_element(named, {}, subdomain));
    for (const Arrival& at : named) lowest[at.rank][at.index] = subdomain(at) == least;
  });
  return mail.answer(peers, lowest);
}

}  // namespace weft::partition
