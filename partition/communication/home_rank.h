// Each entity has a home rank that follows from the ids of its vertices alone: records of all copies of the
// entity meet there, on whatever ranks its subdomains are.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/parallel.h"
#include "meshing/base/release.h"
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

/// So many records are one thread's work.
inline constexpr std::size_t kRecordsOfRun = std::size_t{1} << 13;

/// Records on their way to the homes of their keys, and the way back: answers come in the order of the
/// records.
template <std::size_t N, class Record>
class Rendezvous {
 public:
  explicit Rendezvous(int ranks) : outgoing_(static_cast<std::size_t>(ranks)) {}

  /// Record has a member `key`.
  void add(const Record& record) {
    const std::uint32_t home = home_of(record);
    places_.push_back({home, static_cast<std::uint32_t>(outgoing_[home].size())});
    outgoing_[home].push_back(record);
  }

  /// The same for all records of arrays, one after the other, by several threads (TBB, in the caller's
  /// arena).
  void add(std::span<const std::span<const Record>> arrays) {
    struct Run {
      std::span<const Record> records;
      std::size_t first;  ///< among places_
    };
    std::vector<Run> runs;
    std::size_t size = places_.size();
    for (const std::span<const Record> array : arrays)
      for (std::size_t i = 0; i < array.size(); i += kRecordsOfRun) {
        runs.push_back({array.subspan(i, std::min(kRecordsOfRun, array.size() - i)), size});
        size += runs.back().records.size();
      }
    places_.resize(size);
    const auto for_each_record = [&](const auto& action) {
      meshing::for_each_large(runs.size(), [&](std::size_t k) {
        for (std::size_t i = 0; i < runs[k].records.size(); ++i)
          action(k, runs[k].records[i], places_[runs[k].first + i]);
      });
    };
    const std::size_t ranks = outgoing_.size();
    std::vector<std::uint32_t> next(runs.size() * ranks, 0);  // of each run at each home
    for_each_record([&](std::size_t run, const Record& record, Place& place) {
      place.home = home_of(record);
      ++next[run * ranks + place.home];
    });
    for (std::size_t home = 0; home < ranks; ++home) {
      auto there = static_cast<std::uint32_t>(outgoing_[home].size());
      for (std::size_t run = 0; run < runs.size(); ++run)
        there += std::exchange(next[run * ranks + home], there);
      outgoing_[home].resize(there);
    }
    for_each_record([&](std::size_t run, const Record& record, Place& place) {
      place.index = next[run * ranks + place.home]++;
      outgoing_[place.home][place.index] = record;
    });
  }

  /// All ranks: what has arrived here, by rank of origin.
  std::vector<std::vector<Record>> deliver(Peers& peers) {
    return partition::all_to_all(peers, std::move(outgoing_));
  }

  /// All ranks, after deliver(): answers[r][i] is for arrived[r][i]; returns those to this rank's records.
  template <class Answer>
  std::vector<Answer> answer(Peers& peers, std::vector<std::vector<Answer>> answers) const {
    const std::vector<std::vector<Answer>> back = partition::all_to_all(peers, std::move(answers));
    std::vector<Answer> mine(places_.size());
    meshing::for_each_index(mine.size(),
                            [&](std::size_t i) { mine[i] = back[places_[i].home][places_[i].index]; });
    return mine;
  }

 private:
  /// Where a record is among what leaves.
  struct Place {
    std::uint32_t home, index;
  };

  std::uint32_t home_of(const Record& record) const {
    return static_cast<std::uint32_t>(home_rank<N>(record.key, static_cast<int>(outgoing_.size())));
  }

  std::vector<Place> places_;  ///< of each record
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
  struct Run {
    std::size_t rank, begin, end;
    std::array<std::size_t, kBuckets> next{};  ///< in each bucket
  };
  std::vector<Run> runs;
  for (std::size_t r = 0; r < arrived.size(); ++r)
    for (std::size_t i = 0; i < arrived[r].size(); i += kRecordsOfRun)
      runs.push_back({r, i, std::min(arrived[r].size(), i + kRecordsOfRun)});
  const auto for_each_record = [&](const auto& action) {
    meshing::for_each_large(runs.size(), [&](std::size_t k) {
      for (std::size_t i = runs[k].begin; i < runs[k].end; ++i) {
        const Record& record = arrived[runs[k].rank][i];
        action(record, i, runs[k].rank, runs[k].next[bucket_of(record)]);
      }
    });
  };
  for_each_record([](const Record&, std::size_t, std::size_t, std::size_t& next) { ++next; });
  std::array<std::size_t, kBuckets> sizes{};
  for (std::size_t b = 0; b < kBuckets; ++b)
    for (Run& run : runs) sizes[b] += std::exchange(run.next[b], sizes[b]);
  std::array<std::vector<Keyed>, kBuckets> buckets;
  meshing::for_each_large(kBuckets, [&](std::size_t b) { buckets[b].resize(sizes[b]); });
  for_each_record([&](const Record& record, std::size_t i, std::size_t rank, std::size_t& next) {
    buckets[bucket_of(record)][next++] = {record.key, {rank, i}};
  });
  meshing::for_each_large(kBuckets, [&](std::size_t b) {
    std::vector<Keyed> bucket = std::move(buckets[b]);
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

/// All ranks: for each of these entities, of one array after the other, 1 where no lower subdomain on any
/// rank has named it too, else 0. Gives the arrays' memory back.
template <std::size_t N>
std::vector<std::uint8_t> held_by_no_lower(Peers& peers, std::vector<std::vector<Holding<N>>> holdings) {
  Rendezvous<N, Holding<N>> mail(peers.ranks());
  mail.add(std::vector<std::span<const Holding<N>>>(holdings.begin(), holdings.end()));
  meshing::release(holdings);
  const auto arrived = mail.deliver(peers);

  std::vector<std::vector<std::uint8_t>> lowest(arrived.size());
  for (std::size_t r = 0; r < arrived.size(); ++r) lowest[r].resize(arrived[r].size());
  for_each_key<N>(arrived, [&](std::span<const Arrival> named) {
    const auto subdomain = [&](const Arrival& at) { return arrived[at.rank][at.index].subdomain; };
    const std::uint64_t least = subdomain(*std::ranges::min_element(named, {}, subdomain));
    for (const Arrival& at : named) lowest[at.rank][at.index] = subdomain(at) == least;
  });
  return mail.answer(peers, std::move(lowest));
}

}  // namespace weft::partition
