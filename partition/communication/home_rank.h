// Each entity has a home rank that follows from the ids of its vertices alone: records of all copies of the
// entity meet there, on whatever ranks its subdomains are.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <tuple>
#include <vector>

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
int home_rank(const EntityKey<N>& key, int ranks) {
  std::uint64_t hash = 0;
  for (const GlobalId id : key) hash = (hash ^ std::hash<GlobalId>{}(id)) * 0xD6E8FEB86659FD93ull;
  return static_cast<int>((hash >> 32) % static_cast<std::uint64_t>(ranks));
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

  struct Named {
    Holding<N> holding;
    std::size_t rank, index;
  };
  std::vector<Named> places;
  std::vector<std::vector<std::uint8_t>> lowest(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r) {
    lowest[r].resize(arrived[r].size());
    for (std::size_t i = 0; i < arrived[r].size(); ++i) places.push_back({arrived[r][i], r, i});
  }
  std::sort(places.begin(), places.end(), [](const Named& a, const Named& b) {
    return std::tie(a.holding.key, a.holding.subdomain) < std::tie(b.holding.key, b.holding.subdomain);
  });
  for (std::size_t p = 0, first = 0; p < places.size(); ++p) {
    if (places[p].holding.key != places[first].holding.key) first = p;
    lowest[places[p].rank][places[p].index] = places[p].holding.subdomain == places[first].holding.subdomain;
  }
  return mail.answer(peers, lowest);
}

}  // namespace weft::partition
