// Two meshes in parts between which fields are carried.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "meshing/fields/mesh_pair.h"
#include "partition/communication/morton_shares.h"
#include "partition/communication/peers.h"
#include "partition/fields/nearby_tets.h"
#include "partition/fields/read_at_vertices.h"
#include "partition/metric/part_domain.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// Both meshes are dealt out anew, what lies together, of either, to one rank; the tets of the old mesh about
/// a part of the new one come to it, and on the way back points of the old one go to where the new one has
/// tets. All ranks call every function together, source() as well: it may be made then. What is carried has
/// the same bits for any number of ranks.
class PartPair final : public meshing::MeshPair {
 public:
  /// Throws as PartDomain does, meshing::NewMeshError for a fault of `to`.
  PartPair(Peers& peers, const MeshSlice& from, const MeshSlice& to,
           const std::atomic<bool>* interrupt = nullptr);

  const PartDomain& old_mesh() const override { return old_; }
  const PartDomain& new_mesh() const override { return new_; }
  const meshing::MeshData& source() const override { return nearby().mesh(); }
  meshing::ValueTable at_source(const meshing::ValueTable& at_old) const override {
    return nearby().carry(at_old);
  }
  bool widen(std::span<const double> distances) override;
  void release_source() override { nearby_.reset(); }
  meshing::ValueTable read_back(const meshing::ValueTable& at_new) const override {
    return read_at_vertices(peers_, new_, at_new, old_, diameter_);
  }

  /// Of the source's vertices, in the whole mesh.
  const std::vector<std::uint64_t>& source_numbers() const { return nearby().numbers(); }

 private:
  PartPair(Peers& peers, const MeshSlice& from, const MeshSlice& to, const MortonShares& shares,
           const std::atomic<bool>* interrupt);

  const NearbyTets& nearby() const;

  Peers& peers_;
  PartDomain old_, new_;
  double diameter_;                                   ///< of the box of both
  std::vector<double> reach_;                         ///< of the source, from each vertex of the new part
  mutable std::unique_ptr<const NearbyTets> nearby_;  ///< made when first asked for
};

}  // namespace weft::partition
