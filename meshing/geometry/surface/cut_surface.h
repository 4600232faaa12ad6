// The pieces of a surface: which triangle and which feature edge is in which piece, and the making of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/morton.h"
#include "meshing/geometry/model/model_classification.h"
#include "meshing/geometry/surface/surface_tables.h"
#include "meshing/geometry/surface/surface_topology.h"

namespace weft::meshing {

/// What there is to cut: a surface, or a part of one.
struct UncutSurface {
  std::span<const Point> points;  ///< of the mesh
  SurfaceTopology topology;
  std::vector<std::array<Vec, 2>> handles;  ///< by edge; may be empty
  // With a model:
  ModelClassification classification;
  std::vector<std::array<double, 2>> feature_t;  ///< parameters of a feature edge's ends
  std::vector<bool> turned;                      ///< triangles whose order is not the input's
};

/// Triangles and feature edges in the order of their pieces, of which each has kSurfacePieceSize: along a
/// Morton curve through the surface's box, those of patches that have no formula; then feature edges where
/// the curve or a triangle beside it is asked for.
class PieceOrder {
 public:
  explicit PieceOrder(const Box& box) : curve_(box) {}
  /// The same for any order of the corners.
  std::uint64_t key(const std::array<Point, 3>& corners) const;
  std::uint64_t key(const std::array<Point, 2>& ends) const { return curve_.key(midpoint(ends[0], ends[1])); }

 private:
  MortonCurve curve_;
};

/// A planar patch, or one on a face with a formula, asks for no triangle.
bool needs_triangles(const SurfaceTables& tables, PatchId patch);
/// Whether each curve's edges are asked for, beside those of curves with a triangle that is in a piece.
std::vector<std::uint8_t> curves_asked_for(const SurfaceTables& tables);

inline std::uint32_t pieces_of(std::size_t count) {
  return static_cast<std::uint32_t>((count + kSurfacePieceSize - 1) / kSurfacePieceSize);
}
/// The name of what has this place in the order, whose first piece is `first_piece`.
inline std::uint32_t name_in_order(std::size_t place, std::uint32_t first_piece) {
  return surface_name(first_piece + static_cast<std::uint32_t>(place / kSurfacePieceSize),
                      static_cast<std::uint32_t>(place % kSurfacePieceSize));
}

/// Consecutive pieces that a cutter can make.
struct MadePieces {
  std::uint32_t first = 0;             ///< piece
  std::vector<std::uint32_t> members;  ///< all of theirs, in order
};

struct SurfaceNames {
  std::vector<std::uint32_t>
      triangles;  ///< names by triangle, of all that touch own ones; kNoName in no piece
  std::vector<std::uint32_t> features;  ///< names by feature edge, of those at own vertices
  MadePieces of_triangles, of_features;
};
/// Of a whole surface. Sets SurfaceTables::curve_in_pieces.
SurfaceNames name_surface(const UncutSurface& surface, SurfaceTables& tables);

/// Makes pieces.
class SurfaceCutter {
 public:
  SurfaceCutter(UncutSurface&& surface, SurfaceNames&& names);
  SurfaceCutter(const SurfaceCutter&) = delete;

  /// Of the vertices of own triangles: the topology's hints, as names.
  std::vector<std::uint32_t> vertex_hints() const;
  /// Corners in the pieces of this cutter, by vertex here.
  struct NamedCorner {
    std::uint32_t vertex, name;
  };
  std::span<const NamedCorner> corners() const { return corners_; }
  /// Of the pieces, ascending.
  std::vector<std::uint32_t> ids() const;
  SurfacePieces::Piece piece(std::uint32_t id) const;
  /// SurfacePiece::box of it, without making it.
  Box box(std::uint32_t id) const;

 private:
  using Names = std::vector<std::uint32_t>;
  void name_corners();
  bool is_own(std::uint32_t id) const;
  bool is_of_triangles(std::uint32_t id) const;
  std::span<const std::uint32_t> members(std::uint32_t id) const;
  void add_triangles(std::span<const std::uint32_t> triangles, SurfacePieceParts& parts) const;
  SurfaceTriangle triangle(std::uint32_t t, const Names& edges, const Names& fans,
                           const SurfacePieceParts& parts) const;
  std::uint32_t lending_fan(std::uint32_t t) const;
  std::array<Parameters, 3> parameters(std::uint32_t t) const;
  void add_feature(std::uint32_t f, SurfacePieceParts& parts) const;
  void add_corner(std::uint32_t corner, SurfacePieceParts& parts) const;
  std::uint32_t node(std::uint32_t corner) const;

  std::uint32_t name_behind(std::uint32_t feature, std::uint32_t vertex) const;

  const UncutSurface surface_;
  const SurfaceTopology& s_;
  const SurfaceNames names_;
  std::vector<NamedCorner> corners_;  // ascending by name
};

}  // namespace weft::meshing
