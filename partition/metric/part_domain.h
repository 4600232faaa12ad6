// One rank's part of a mesh on which a metric is made in parts.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "meshing/metric/metric_domain.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// Vertices that lie together belong to one rank, whatever their order in the input; a rank has the tets
/// around its vertices in as many rings as are asked for. What is made of them has the same bits for any
/// number of ranks. All ranks call every function but mesh(), owns(), num_points(), largest_size() and
/// numbers() together.
class PartDomain final : public meshing::MetricDomain {
 public:
  /// Throws meshing::InputError, the same on all ranks, for what check_slices() and inverted() refuse.
  /// Memory: 130 bytes a tet of the part, and twice that for a moment.
  PartDomain(Peers& peers, const MeshSlice& slice, int rings, const std::atomic<bool>* interrupt = nullptr)
      : PartDomain(peers, slice, rings, morton_shares(peers, {slice.points}), interrupt) {}
  /// Vertices belong to the ranks that `shares` says, the same on all ranks; largest_size() is its box's.
  PartDomain(Peers& peers, const MeshSlice& slice, int rings, const MortonShares& shares,
             const std::atomic<bool>* interrupt = nullptr);

  const meshing::MeshData& mesh() const override { return mesh_; }
  bool owns(std::size_t vertex) const override { return owners_[vertex] == me_; }
  std::size_t num_points() const override { return points_.total(); }
  double largest_size() const override { return largest_size_; }
  double max(double mine) const override;
  bool any(bool mine) const override;
  double sum(const std::function<double(std::size_t)>& at) const override;
  double signed_sum(const std::function<double(std::size_t)>& at) const override;
  double complexity(const meshing::LogMetricField& field) const override;
  void refresh(std::vector<meshing::SymTensor>& values) const override { refresh_values(values); }
  void refresh(std::vector<std::uint8_t>& values) const override { refresh_values(values); }
  void refresh(std::size_t columns, std::vector<double>& values) const override;
  std::vector<std::uint32_t> refresh_changed(std::span<const std::uint32_t> changed,
                                             std::vector<meshing::SymTensor>& values) const override;

  /// Values at this rank's slice of points become values at the vertices of the part.
  template <class T>
  std::vector<T> from_slices(const std::vector<T>& of_slice) const {
    return from_slices(of_slice, numbers_);
  }
  /// The same at the vertices that have these numbers (ascending) in the whole mesh.
  template <class T>
  std::vector<T> from_slices(const std::vector<T>& of_slice,
                             const std::vector<std::uint32_t>& numbers) const {
    return fetch<T>(peers_, points_, numbers, [&](std::size_t i) { return of_slice[i]; });
  }
  /// The ranks that own the vertices that have these numbers (ascending) in the whole mesh.
  std::vector<std::uint32_t> owners_of(const std::vector<std::uint32_t>& numbers) const {
    return from_slices(slice_owners_, numbers);
  }
  /// Of the part's vertices, in the whole mesh; ascending.
  const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  /// Values at the vertices of the part become values at this rank's slice of points.
  template <class T>
  std::vector<T> to_slices(const std::vector<T>& values) const;

 private:
  /// A tet on its way, with the ranks that own its vertices.
  struct TetRecord {
    std::uint64_t number;
    std::array<std::uint32_t, 4> vertices, owners;
  };
  /// One list after the other ascending; never joined, since they are most of a rank's memory.
  using TetLists = std::vector<std::vector<TetRecord>>;

  void choose_owners(const MeshSlice& slice, const MortonShares& shares);
  TetLists first_ring(const MeshSlice& slice) const;
  void add_ring(const std::vector<TetRecord>& first, std::vector<std::vector<std::uint32_t>>& asked,
                std::vector<TetRecord>& tets) const;
  void build_mesh(const MeshSlice& slice, TetLists&& tets);
  void join_copies();
  std::uint32_t local(std::uint32_t number) const;

  template <class T>
  void refresh_values(std::vector<T>& values) const;

  Peers& peers_;
  Ranges points_;
  std::uint32_t me_;
  double largest_size_ = 1;
  std::vector<std::uint32_t> slice_owners_;   ///< of this rank's slice of points
  std::vector<std::uint32_t> owned_numbers_;  ///< in the whole mesh, ascending
  meshing::MeshData mesh_;
  std::vector<std::uint32_t> numbers_,
      owners_;                   ///< of the part's vertices: in the whole mesh, ascending; ranks
  std::vector<double> volumes_;  ///< quarters of those of tets at vertices

  /// Of each rank: the vertices here whose values it gets, and those whose values come from it, in one order.
  std::vector<std::vector<std::uint32_t>> given_, taken_;
  /// A copy of an owned vertex: on which rank, and where among those that it takes from here.
  struct Copy {
    std::uint32_t vertex, rank;
    std::uint64_t place;
    friend auto operator<=>(const Copy&, const Copy&) = default;
  };
  std::vector<Copy> copies_;  ///< sorted
};

template <class T>
std::vector<T> PartDomain::to_slices(const std::vector<T>& values) const {
  std::vector<std::vector<T>> to_each(static_cast<std::size_t>(peers_.ranks()));
  for (const std::uint32_t number : owned_numbers_)
    to_each[points_.rank_of(number)].push_back(values[local(number)]);
  const std::vector<std::vector<T>> from_each = partition::all_to_all(peers_, std::move(to_each));
  std::vector<std::size_t> next(from_each.size(), 0);
  std::vector<T> of_slice;
  of_slice.reserve(slice_owners_.size());
  for (const std::uint32_t owner : slice_owners_) of_slice.push_back(from_each[owner][next[owner]++]);
  return of_slice;
}

template <class T>
void PartDomain::refresh_values(std::vector<T>& values) const {
  std::vector<std::vector<T>> to_each(given_.size());
  for (std::size_t r = 0; r < given_.size(); ++r) {
    to_each[r].reserve(given_[r].size());
    for (const std::uint32_t v : given_[r]) to_each[r].push_back(values[v]);
  }
  const std::vector<std::vector<T>> from_each = partition::all_to_all(peers_, std::move(to_each));
  for (std::size_t r = 0; r < taken_.size(); ++r)
    for (std::size_t i = 0; i < taken_[r].size(); ++i) values[taken_[r][i]] = from_each[r][i];
}

}  // namespace weft::partition
