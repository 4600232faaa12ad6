// The feature curves of a surface in shares: which feature edge is on which curve, and its name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "meshing/geometry/surface/cut_surface.h"
#include "meshing/geometry/surface/surface_curves.h"
#include "partition/communication/peers.h"
#include "partition/surface/dealt_pieces.h"

namespace weft::partition {

/// A feature edge that this rank tells of.
struct OwnFeature {
  meshing::FoundFeature found;
  std::uint64_t beside_pieces;  ///< 1: a triangle at it is in a piece of the surface
};

/// What is known of a feature edge; vertices are numbered as in the whole input.
struct FeatureRecord {
  std::array<std::uint32_t, 2> vertices;  ///< ascending
  std::uint32_t name;                     ///< meshing::kNoName: in no piece
  std::uint32_t unused = 0;               ///< no byte of a message is undefined
  meshing::FeatureOnCurve on;
};

/// All ranks know the curves, and of a curve's edges one does, who forms it, until they are named; then what
/// is known of an edge is at the home of its lower vertex.
class FeatureCurves {
 public:
  /// `mine`: each of one rank, in any order. All ranks call together, also what follows.
  FeatureCurves(Peers& peers, const std::vector<OwnFeature>& mine);

  /// In their order.
  const std::vector<meshing::FoundCurve>& found() const { return found_; }
  /// By curve, whether a triangle at one of its edges is in a piece of the surface.
  const std::vector<std::uint8_t>& beside_pieces() const { return beside_pieces_; }

  struct FirstEdge {
    std::array<std::uint32_t, 2> vertices;
    meshing::CurveId curve;
  };
  /// Those of this rank's features with which a curve begins.
  std::vector<FirstEdge> first_edges() const;

  /// Names the edges of these curves (`in_pieces`, by curve), for pieces that begin with number
  /// `first_piece`; `firsts`: where ranks begin along the order (first_keys()). Once.
  void name(const meshing::PieceOrder& order, std::span<const std::uint64_t> firsts,
            std::span<const std::uint8_t> in_pieces, std::uint32_t first_piece);
  /// How the named are dealt.
  const DealtPieces& dealt() const { return dealt_; }

  /// When they are named: those between these vertices (ascending), by their vertices; `asked`:
  /// asked_at_home() of these.
  std::vector<FeatureRecord> between(const std::vector<std::vector<std::uint32_t>>& asked,
                                     const std::vector<std::uint32_t>& vertices) const;

 private:
  /// A feature on its way to its place in the order.
  struct Keyed {
    std::uint64_t key;  ///< all ones: in no piece
    FeatureRecord record;
  };

  void form(std::vector<std::vector<OwnFeature>> arrived);
  void number_curves(std::vector<meshing::FoundCurve> formed, std::vector<std::uint8_t> beside);
  std::vector<Keyed> in_order(const meshing::PieceOrder& order, std::span<const std::uint64_t> firsts,
                              std::span<const std::uint8_t> in_pieces);

  Peers& peers_;
  std::vector<meshing::FoundCurve> found_;
  std::vector<std::uint8_t> beside_pieces_;
  std::vector<meshing::FoundFeature> here_;  // of the curves formed here, in the order of their vertices
  std::vector<meshing::FeatureOnCurve> on_;  // of these
  std::vector<std::uint32_t> told_by_;       // ranks
  DealtPieces dealt_;
  std::vector<FeatureRecord> at_home_;  // in the order of their vertices
};

}  // namespace weft::partition
