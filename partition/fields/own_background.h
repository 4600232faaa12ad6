// A background that is another mesh than the input: its metric at the input's points, and its pieces where
// subdomains need them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "meshing/fields/coverage.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/communication/ranges.h"
#include "partition/fields/part_pair.h"
#include "partition/slice/mesh_slice.h"
#include "partition/subdomain/background_store.h"
#include "partition/subdomain/subdomain_start.h"

namespace weft::partition {

/// Until the subdomains have their pieces each rank has some of them: tets follow each other along a Morton
/// curve and are cut into pieces in that order, the same for any number of ranks and any shares.
class OwnBackground {
 public:
  /// All ranks: `background` with its metric, which becomes that of the points of `input`; a point beyond it
  /// gets that of the closest point. Throws as PartDomain does.
  OwnBackground(Peers& peers, MeshSlice&& background, MeshSlice& input);

  /// Of the whole background in its metric.
  double complexity() const { return complexity_; }
  /// Of the input's points, on all ranks alike.
  const meshing::Uncovered& uncovered() const { return uncovered_; }
  /// All ranks: gives each start the pieces that its tets cover, and the places of its vertices. The starts'
  /// vertices are named by their numbers in the input.
  void deliver(std::span<SubdomainStart> starts) const;

 private:
  using Tet = meshing::Tet;
  using Pieces = std::vector<std::shared_ptr<const BackgroundPiece>>;

  std::vector<Tet> places_of(PartPair& meshes, const MeshSlice& background, MeshSlice& input);
  void cut(const PartDomain& domain, const MeshSlice& background);
  std::vector<BackgroundTet> names_of(const std::vector<Tet>& tets) const;
  std::size_t rank_of(std::uint64_t piece) const;
  std::vector<std::vector<std::uint64_t>> wanted_by_cells(std::span<const SubdomainStart> starts) const;
  Pieces fetch_pieces(std::span<const SubdomainStart> starts) const;

  Peers& peers_;
  double complexity_ = 0;
  meshing::Uncovered uncovered_;
  Ranges input_points_;
  std::vector<BackgroundTet> places_;  ///< of the input's points here
  std::vector<std::uint64_t> firsts_;  ///< of each rank: its first piece; ends with their number
  Pieces pieces_;                      ///< of this rank
  std::vector<Tet> tets_;              ///< of these pieces one after the other, numbered as in the whole mesh
};

}  // namespace weft::partition
