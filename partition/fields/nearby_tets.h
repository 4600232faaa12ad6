// What one rank needs of a mesh in parts: the tets about its part of another mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "meshing/base/value_table.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/metric/part_domain.h"

namespace weft::partition {

/// The tets of `of`, from whatever rank, that overlap a tet of this rank's part of `around` or come as near
/// to one of its points as is asked for, and few more. Ranks find each other by the cells of a grid: a cell
/// has a home rank, at which who is around asks for it and who has tets in it learns of them. What is around
/// is then told to these as boxes of a few tets each.
class NearbyTets {
 public:
  /// All ranks. `reach`: a distance for each vertex of the part of `around`.
  NearbyTets(Peers& peers, const PartDomain& of, const PartDomain& around, std::span<const double> reach);

  const meshing::MeshData& mesh() const { return mesh_; }
  /// Of its vertices, in the whole mesh; ascending.
  const std::vector<std::uint64_t>& numbers() const { return numbers_; }
  /// All ranks: values at the vertices of the part of `of` become values at those of mesh().
  meshing::ValueTable carry(const meshing::ValueTable& at_part) const;

 private:
  struct VertexRecord {
    std::uint64_t number;
    meshing::Point point;
  };

  void send(const PartDomain& of, std::vector<std::vector<std::uint32_t>>&& tets_for);
  void build(const std::vector<std::vector<VertexRecord>>& vertices,
             std::vector<std::array<std::uint32_t, 4>>&& tets);

  Peers& peers_;
  meshing::MeshData mesh_;
  std::vector<std::uint64_t> numbers_;
  /// Of each rank: the vertices of the part of `of` that it gets, and those here that come from it.
  std::vector<std::vector<std::uint32_t>> given_, taken_;
};

}  // namespace weft::partition
