// What one rank needs of a mesh in parts: the tets about its part of another mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "meshing/base/value_table.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/fields/cell_grid.h"
#include "partition/metric/part_domain.h"

namespace weft::partition {

/// The tets of `of`, from whatever rank, that come nearer than reach() to a tet or a point of this rank's
/// part of `around`; among them all that overlap one. Ranks find each other by the cells of a grid: a cell
/// has a home rank, at which who is around asks for it and who has tets in it learns of them.
class NearbyTets {
 public:
  /// All ranks. `margin`: cells beside those that the part of `around` touches, 1 and more.
  NearbyTets(Peers& peers, const PartDomain& of, const PartDomain& around, std::uint32_t margin);

  const meshing::MeshData& mesh() const { return mesh_; }
  /// Of its vertices, in the whole mesh; ascending.
  const std::vector<std::uint64_t>& numbers() const { return numbers_; }
  /// All ranks: values at the vertices of the part of `of` become values at those of mesh().
  meshing::ValueTable carry(const meshing::ValueTable& at_part) const;
  double reach() const { return reach_; }

 private:
  struct VertexRecord {
    std::uint64_t number;
    meshing::Point point;
  };

  void send(const PartDomain& of, const std::vector<std::vector<std::uint32_t>>& tets_for);
  void build(const std::vector<std::vector<VertexRecord>>& vertices,
             std::vector<std::array<std::uint32_t, 4>>&& tets);

  Peers& peers_;
  double reach_;
  meshing::MeshData mesh_;
  std::vector<std::uint64_t> numbers_;
  /// Of each rank: the vertices of the part of `of` that it gets, and those here that come from it.
  std::vector<std::vector<std::uint32_t>> given_, taken_;
};

}  // namespace weft::partition
