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
#include "partition/metric/part_domain.h"
#include "partition/slice/mesh_slice.h"

namespace weft::partition {

/// Both meshes are dealt out anew, what lies together, of either, to one rank; the tets of the other mesh
/// about a part come to it. All ranks call every function together. What is carried has the same bits for any
/// number of ranks.
class PartPair final : public meshing::MeshPair {
 public:
  /// Throws as PartDomain does, meshing::NewMeshError for a fault of `to`.
  PartPair(Peers& peers, const MeshSlice& from, const MeshSlice& to,
           const std::atomic<bool>* interrupt = nullptr);

  const PartDomain& old_mesh() const override { return old_; }
  const PartDomain& new_mesh() const override { return new_; }
  const meshing::MeshData& source(Way way) const override { return nearby(way).mesh(); }
  meshing::ValueTable at_source(Way way, const meshing::ValueTable& at_part) const override {
    return nearby(way).carry(at_part);
  }
  bool widen(Way way, std::span<const double> distances) override;
  void release_source(Way way) override { side(way).tets.reset(); }

  /// Of the source's vertices, in the whole mesh.
  const std::vector<std::uint64_t>& source_numbers(Way way) const { return nearby(way).numbers(); }

 private:
  PartPair(Peers& peers, const MeshSlice& from, const MeshSlice& to, const MortonShares& shares,
           const std::atomic<bool>* interrupt);

  /// The source, and how far it reaches from each vertex of the other part.
  struct Side {
    std::vector<double> reach;
    mutable std::unique_ptr<const NearbyTets> tets;  ///< made when first asked for
  };
  const Side& side(Way way) const { return sides_[way == Way::back]; }
  const NearbyTets& nearby(Way way) const;

  Peers& peers_;
  PartDomain old_, new_;
  double diameter_;  ///< of the box of both
  Side sides_[2];
};

}  // namespace weft::partition
