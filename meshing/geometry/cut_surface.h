// The pieces of a whole surface.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/geometry/model_classification.h"
#include "meshing/geometry/surface_tables.h"
#include "meshing/geometry/surface_topology.h"

namespace weft::meshing {

/// What there is to cut.
struct WholeSurface {
  std::span<const Point> points;  ///< of the mesh
  SurfaceTopology topology;
  std::vector<std::array<Vec, 2>> handles;  ///< by edge; may be empty
  // With a model:
  ModelClassification classification;
  std::vector<std::array<double, 2>> feature_t;  ///< parameters of a feature edge's ends
  std::vector<bool> turned;                      ///< triangles whose order is not the input's
};

/// Says who is in which piece, and makes the pieces: triangles of patches that have no formula along a Morton
/// curve, then feature edges where the curve or a triangle beside it is asked for.
class SurfaceCutter {
 public:
  /// Sets `curve_in_pieces` of the tables.
  SurfaceCutter(WholeSurface&& whole, SurfaceTables& tables);
  SurfaceCutter(const SurfaceCutter&) = delete;

  /// The topology's, as names.
  std::vector<std::uint32_t> vertex_hints() const;
  /// Of the pieces, ascending.
  std::vector<std::uint32_t> ids() const;
  SurfacePieces::Piece piece(std::uint32_t id) const;
  /// SurfacePiece::box of it, without making it.
  Box box(std::uint32_t id) const;

 private:
  using Names = std::vector<std::uint32_t>;
  struct NamedCorner {
    std::uint32_t vertex, name;
  };

  void find_needed_curves(SurfaceTables& tables) const;
  std::uint32_t name(const Names& order, std::uint32_t first_piece, Names& names) const;
  void name_corners();
  std::span<const std::uint32_t> members(std::uint32_t id) const;
  void add_triangles(std::span<const std::uint32_t> triangles, SurfacePieceParts& parts) const;
  SurfaceTriangle triangle(std::uint32_t t, const Names& edges, const Names& fans,
                           const SurfacePieceParts& parts) const;
  std::uint32_t lending_fan(std::uint32_t t) const;
  std::array<Parameters, 3> parameters(std::uint32_t t) const;
  void add_feature(std::uint32_t f, SurfacePieceParts& parts) const;
  void add_corner(std::uint32_t corner, SurfacePieceParts& parts) const;
  std::uint32_t node(std::uint32_t corner) const;

  const WholeSurface whole_;
  const SurfaceTopology& s_;
  Names triangles_, features_;  // in the order of their pieces
  Names triangle_name_, feature_name_;
  std::uint32_t triangle_pieces_ = 0, feature_pieces_ = 0;
  std::vector<NamedCorner> corners_;  // that have anything in pieces, ascending by name
};

}  // namespace weft::meshing
