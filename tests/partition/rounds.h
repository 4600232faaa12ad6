// The distributed method played by one thread: all subdomains at hand, messages delivered by hand, in order.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "partition/adapt_subdomain.h"
#include "partition/shift.h"
#include "tests/partition/cut.h"

namespace weft::support {

class Rounds {
 public:
  Rounds(Cut& cut, std::size_t capacity, double hausd, partition::ShiftOptions shift)
      : geometry_(cut.geometry), hausd_(hausd), shift_(shift) {
    for (const auto& s : cut.starts) subdomains.emplace_back(s, capacity);
  }

  void adapt(meshing::Extent extent) {
    for (auto& s : subdomains) {
      auto r = partition::adapt_subdomain(s, geometry_.surface, hausd_, extent, options);
      counts += r.counts;
    }
  }

  void refine_interfaces() {
    using namespace partition;
    std::vector<std::vector<InterfaceVertices>> sent(subdomains.size()), theirs(subdomains.size());
    for (std::size_t i = 0; i < subdomains.size(); ++i) sent[i] = refine_interface(subdomains[i], geometry_);
    for (std::size_t i = 0; i < subdomains.size(); ++i)
      for (const SubdomainId from : subdomains[i].interface.neighbours()) {
        const auto back = subdomains[from].interface.neighbours();
        const auto at = std::lower_bound(back.begin(), back.end(), static_cast<SubdomainId>(i)) - back.begin();
        theirs[i].push_back(sent[from][at]);
      }
    for (std::size_t i = 0; i < subdomains.size(); ++i) register_interface(subdomains[i], theirs[i]);
  }

  /// One shift without the adaptation; returns the number of tets that moved.
  std::uint64_t shift(std::uint64_t round) {
    using namespace partition;
    const std::size_t n = subdomains.size();
    std::vector<std::vector<GlobalId>> wants(n);
    std::vector<Priority> priority(n);
    std::vector<std::vector<Proposal>> proposals(n);
    wanted_total = 0;
    for (std::size_t i = 0; i < n; ++i) {
      wants[i] = wanted(subdomains[i]);
      wanted_total += wants[i].size();
      priority[i] = {hash(i, round), static_cast<SubdomainId>(i)};
      proposals[i] = propose(subdomains[i], priority[i], wants[i]);
    }
    std::vector<std::vector<SubdomainId>> neighbours(n);
    for (std::size_t i = 0; i < n; ++i)
      neighbours[i].assign(subdomains[i].interface.neighbours().begin(), subdomains[i].interface.neighbours().end());
    const auto deliver = [&](auto& sent, std::size_t to) {
      std::remove_reference_t<decltype(sent[0])> arrived;
      for (const SubdomainId from : neighbours[to]) {
        const auto& back = neighbours[from];
        const auto at = std::lower_bound(back.begin(), back.end(), static_cast<SubdomainId>(to)) - back.begin();
        arrived.push_back(std::move(sent[from][at]));
      }
      return arrived;
    };
    std::vector<std::vector<Proposal>> proposed(n);
    for (std::size_t i = 0; i < n; ++i) proposed[i] = deliver(proposals, i);
    std::vector<std::vector<Parcel>> parcels(n);
    for (std::size_t i = 0; i < n; ++i)
      parcels[i] = gather(subdomains[i], priority[i], wants[i], proposed[i], shift_);
    std::vector<std::vector<Parcel>> arrived(n);
    for (std::size_t i = 0; i < n; ++i) arrived[i] = deliver(parcels, i);
    std::uint64_t moved = 0;
    expected_.assign(n, {});
    notices_.assign(n, {});
    receivers = 0;
    for (std::size_t i = 0; i < n; ++i) {
      Scattered r = scatter(subdomains[i], arrived[i]);
      moved += r.received;
      receivers += r.received > 0;
      expected_[i] = r.expected;
      for (auto& a : r.notices) notices_[a.to][static_cast<SubdomainId>(i)] = a.notice;
    }
    return moved;
  }

  void update() {
    for (std::size_t i = 0; i < subdomains.size(); ++i) {
      std::vector<partition::Notice> mine;
      std::vector<partition::SubdomainId> from;
      for (auto& [f, n] : notices_[i]) {
        from.push_back(f);
        mine.push_back(n);
      }
      if (from != expected_[i]) misunderstandings++;
      partition::update_topology(subdomains[i], mine);
    }
  }

  std::vector<partition::MeshPiece> pieces() {
    std::vector<partition::MeshPiece> all;
    for (auto& s : subdomains) all.push_back(partition::make_piece(s, geometry_.surface, geometry_.patch_required));
    return all;
  }

  static std::uint64_t hash(std::uint64_t i, std::uint64_t round) {
    std::uint64_t x = (i + 1) * 0x9E3779B97F4A7C15ull ^ (round + 1) * 0xC2B2AE3D27D4EB4Full;
    x ^= x >> 31;
    x *= 0x7FB5D329728EA185ull;
    x ^= x >> 27;
    x *= 0x81DADEF4BC2DD44Dull;
    return x ^ x >> 33;
  }

  std::vector<partition::Subdomain> subdomains;
  meshing::AdaptOptions options;
  meshing::OperationCounts counts;
  int misunderstandings = 0;
  std::uint64_t wanted_total = 0, receivers = 0;

 private:
  const partition::Geometry& geometry_;
  double hausd_;
  partition::ShiftOptions shift_;
  std::vector<std::vector<partition::SubdomainId>> expected_;
  std::vector<std::map<partition::SubdomainId, partition::Notice>> notices_;
};

}  // namespace weft::support
