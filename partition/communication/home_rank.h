// Each entity has a home rank that follows from the ids of its vertices alone: records of all copies of the
// entity meet there, on whatever ranks its subdomains are.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
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
std::uint64_t hash_of_key(const EntityKey<N>& key) {
  std::uint64_t hash = 0;
  for (const GlobalId id : key) hash = (hash ^ std::hash<GlobalId>{}(id)) * 0xD6E8FEB86659FD93ull;
  return hash;
}

template <std::size_t N>
int home_rank(const EntityKey<N>& key, int ranks) {
  return static_cast<int>((hash_of_key(key) >> 32) % static_cast<std::uint64_t>(ranks));
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

/// The lowest subdomain that has named each of some entities.
template <std::size_t N>
class LowestHolders {
 public:
  /// For up to `most` records, which stay where they are.
  explicit LowestHolders(std::size_t most) : slots_(std::bit_ceil(2 * most + 1), nullptr) {}

  /// Returns the place of the entity.
  std::size_t add(const Holding<N>& holding) {
    // Keys of one home have something in common in bits 32 and above.
    std::size_t at = hash_of_key(holding.key) * 0x9E3779B97F4A7C15ull >> shift_;
    while (slots_[at] && slots_[at]->key != holding.key) at = (at + 1) & (slots_.size() - 1);
    if (!slots_[at] || holding.subdomain < slots_[at]->subdomain) slots_[at] = &holding;
    return at;
  }
  std::uint64_t subdomain(std::size_t place) const { return slots_[place]->subdomain; }

 private:
  std::vector<const Holding<N>*> slots_;
  int shift_ = 64 - std::max(1, std::countr_zero(slots_.size()));
};

/// All ranks: for each of these entities 1 where no lower subdomain on any rank has named it too, else 0.
template <std::size_t N>
std::vector<std::uint8_t> held_by_no_lower(Peers& peers, std::span<const Holding<N>> holdings) {
  Rendezvous<N, Holding<N>> mail(peers.ranks());
  for (const Holding<N>& holding : holdings) mail.add(holding);
  const auto arrived = mail.deliver(peers);
  std::size_t count = 0;
  for (const auto& of_rank : arrived) count += of_rank.size();
  LowestHolders<N> holders(count);
  std::vector<std::size_t> places;
  places.reserve(count);
  for (const auto& of_rank : arrived)
    for (const Holding<N>& holding : of_rank) places.push_back(holders.add(holding));
  std::vector<std::vector<std::uint8_t>> lowest(arrived.size());
  auto place = places.begin();
  for (std::size_t r = 0; r < arrived.size(); ++r) {
    lowest[r].reserve(arrived[r].size());
    for (const Holding<N>& holding : arrived[r])
      lowest[r].push_back(holders.subdomain(*place++) == holding.subdomain);
  }
  return mail.answer(peers, lowest);
}

}  // namespace weft::partition
