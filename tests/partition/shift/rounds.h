// The distributed method played by one thread: all subdomains at hand, messages delivered by hand.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "meshing/kernel/tet_mesh_arrays.h"
#include "partition/divide/divide.h"
#include "partition/shift/shift.h"
#include "partition/subdomain/adapt_subdomain.h"
#include "tests/partition/cut.h"

namespace weft::support {

/// One for each subdomain; values repeat, so that ids have to decide now and then.
inline std::vector<partition::Priority> random_priorities(std::size_t subdomains, std::mt19937& random) {
  std::vector<partition::Priority> priorities;
  for (std::uint32_t i = 0; i < subdomains; ++i)
    priorities.push_back({random() % subdomains, partition::SubdomainId(i)});
  return priorities;
}

class Rounds {
 public:
  using SubdomainId = partition::SubdomainId;
  template <class T>
  using ForEach = std::vector<std::vector<T>>;  ///< [subdomain][...]

  Rounds(const Cut& cut, double hausd, partition::ShiftOptions shift)
      : geometry_(cut.geometry), shift_(shift) {
    limits_.hausd = hausd;
    std::size_t tets = 0;
    for (const auto& s : cut.starts) tets += s.tets.size();
    for (const auto& s : cut.starts) subdomains_.emplace_back(s, 20 * tets + 200000);
  }

  std::vector<partition::Subdomain>& subdomains() { return subdomains_; }
  const partition::Geometry& geometry() const { return geometry_; }
  meshing::AdaptOptions& options() { return options_; }
  meshing::Limits& limits() { return limits_; }

  /// The shifts so far were of a coarse mesh.
  void begin_next_phase() {
    for (auto& s : subdomains_) partition::begin_next_phase(s);
    round_ = 0;
  }

  void refine_interfaces() {
    ForEach<partition::InterfaceVertices> created;
    for (auto& s : subdomains_) {
      partition::InterfaceRefinement refinement(s, geometry_);
      refinement.refine(meshing::Limits().long_edge);
      created.push_back(refinement.created());
    }
    register_interfaces(std::move(created));
  }

  /// The first adaptation, with the interfaces refined level by level in its course.
  void adapt_interiors() {
    ForEach<partition::InterfaceVertices> created;
    for (auto& s : subdomains_) {
      partition::InterfaceRefinement refinement(s, geometry_);
      adapt_subdomain(
          s, geometry_.surface, limits_, meshing::Extent::everything, options_,
          [&](double long_edge, meshing::MetricMean mean) { refinement.refine(long_edge, mean); });
      created.push_back(refinement.created());
    }
    register_interfaces(std::move(created));
  }

  void adapt(meshing::Extent extent) {
    for (auto& s : subdomains_) adapt_subdomain(s, geometry_.surface, limits_, extent, options_);
  }

  ForEach<partition::GlobalId> wants() const {
    ForEach<partition::GlobalId> ids;
    for (const auto& s : subdomains_) ids.push_back(partition::wanted(s, round_));
    return ids;
  }

  /// Proposals, gathering and scattering. update() must follow, with or without an adaptation between.
  /// Returns the number of tets that moved.
  std::uint64_t shift(const std::vector<partition::Priority>& priorities) {
    const ForEach<partition::GlobalId> wants = this->wants();
    const ForEach<SubdomainId> neighbours = find_neighbours();
    ForEach<partition::Proposal> proposals;
    for (std::size_t i = 0; i < subdomains_.size(); ++i)
      proposals.push_back(propose(subdomains_[i], priorities[i], wants[i]));
    ForEach<partition::Parcel> parcels;
    std::vector<std::size_t> vertices;  // that each receives the tets around
    for (std::size_t i = 0; i < subdomains_.size(); ++i) {
      const std::vector<partition::Proposal> arrived = arrived_at(i, proposals, neighbours);
      const partition::ReceiverOrder order(priorities[i], partition::priorities_of(arrived));
      vertices.push_back(vertices_received(subdomains_[i], order, wants[i], arrived));
      parcels.push_back(gather(subdomains_[i], priorities[i], wants[i], arrived, shift_));
    }
    std::uint64_t moved = 0;
    expected_.clear();
    notices_.assign(subdomains_.size(), {});
    for (std::size_t i = 0; i < subdomains_.size(); ++i) {
      auto arrived = arrived_at(i, parcels, neighbours);
      const std::uint64_t received = scatter_in(i, arrived);
      if (received > 0 && vertices[i] == 0) throw std::logic_error("tets have come that were not expected");
      moved += received;
    }
    return moved;
  }

  /// Subdomain i hands parts of itself to itself and the parts[i] - 1 after it, which have nothing yet; 0: it
  /// is one of these. update() must follow.
  void divide(const std::vector<std::uint32_t>& parts) {
    const ForEach<SubdomainId> neighbours = find_neighbours();
    std::vector<std::map<SubdomainId, partition::Parcel>> parcels(subdomains_.size());  // [to][from]
    for (std::size_t i = 0; i < subdomains_.size(); ++i) {
      if (parts[i] == 0) continue;
      for (auto& [to, parcel] : partition::divide(subdomains_[i], {parts[i], {}, false}).parcels)
        parcels[to.value].emplace(subdomains_[i].id, std::move(parcel));
    }
    expected_.clear();
    notices_.assign(subdomains_.size(), {});
    for (std::size_t i = 0; i < subdomains_.size(); ++i) {
      std::vector<partition::Parcel> arrived;
      for (auto& [from, parcel] : parcels[i]) arrived.push_back(std::move(parcel));
      const std::size_t due = parts[i] == 0 ? 1 : neighbours[i].size();
      if (arrived.size() != due) throw std::logic_error("a parcel is missing, or is one too many");
      scatter_in(i, arrived);
    }
  }

  /// The notices. Returns the number of subdomains that did not get them from exactly those they expected.
  int update() {
    int misunderstandings = 0;
    for (std::size_t i = 0; i < subdomains_.size(); ++i) {
      std::vector<partition::Notice> notices;
      std::vector<SubdomainId> from;
      for (auto& [sender, notice] : notices_[i]) {
        from.push_back(sender);
        notices.push_back(std::move(notice));
      }
      misunderstandings += from != expected_[i];
      update_topology(subdomains_[i], notices);
    }
    ++round_;
    return misunderstandings;
  }

  /// Of copies: what is looked at does not change.
  std::vector<partition::MeshPiece> pieces() const {
    std::vector<partition::MeshPiece> all;
    for (const auto& s : subdomains_) {
      partition::Subdomain copy;
      copy.id = s.id;
      copy.interface = s.interface;
      copy.mesh = meshing::from_arrays(meshing::to_arrays(*s.mesh), s.mesh->vertex_slots() + 1,
                                       s.mesh->tet_slots() + 1, meshing::Pages::small);
      all.push_back(make_piece(copy, geometry_.surface, geometry_.patch_required));
    }
    return all;
  }

 private:
  /// Returns the number of tets that have arrived.
  std::uint64_t scatter_in(std::size_t i, std::vector<partition::Parcel>& arrived) {
    partition::Scattered r = scatter(subdomains_[i], arrived);
    expected_.push_back(std::move(r.expected));
    for (auto& [to, notice] : r.notices)
      notices_[to.value].emplace(SubdomainId(static_cast<std::uint32_t>(i)), std::move(notice));
    return r.received;
  }

  void register_interfaces(ForEach<partition::InterfaceVertices> created) {
    const ForEach<SubdomainId> neighbours = find_neighbours();
    for (std::size_t i = 0; i < subdomains_.size(); ++i)
      register_interface(subdomains_[i], geometry_, arrived_at(i, created, neighbours));
  }

  ForEach<SubdomainId> find_neighbours() const {
    ForEach<SubdomainId> all;
    for (const auto& s : subdomains_)
      all.emplace_back(s.interface.neighbours().begin(), s.interface.neighbours().end());
    return all;
  }

  /// Of sent[from], one for each neighbour of `from`, those to `to`, in the order of its neighbours.
  template <class T>
  static std::vector<T> arrived_at(std::size_t to, ForEach<T>& sent, const ForEach<SubdomainId>& neighbours) {
    std::vector<T> arrived;
    for (const SubdomainId from : neighbours[to]) {
      const auto& back = neighbours[from.value];
      const SubdomainId self(static_cast<std::uint32_t>(to));
      const auto at = std::lower_bound(back.begin(), back.end(), self);
      if (at == back.end() || *at != self) throw std::logic_error("neighbours do not agree that they are");
      arrived.push_back(std::move(sent[from.value][static_cast<std::size_t>(at - back.begin())]));
    }
    return arrived;
  }

  const partition::Geometry& geometry_;
  meshing::Limits limits_;
  partition::ShiftOptions shift_;
  meshing::AdaptOptions options_;
  std::vector<partition::Subdomain> subdomains_;
  ForEach<SubdomainId> expected_;  ///< senders of notices
  std::uint64_t round_ = 0;
  std::vector<std::map<SubdomainId, partition::Notice>> notices_;  ///< that are under way, by addressee
};

}  // namespace weft::support
