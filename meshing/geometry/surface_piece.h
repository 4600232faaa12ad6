// The reference surface in pieces: what a projection reads of a hundred triangles, or of feature edges and
// corners, cut out once and never changed. A mesh has all pieces of its surface; a part of a mesh has
// those near its boundary, and they travel with it.
//
// Triangles, feature edges and corners have names that mean the same wherever their piece is: the piece's
// number and a place in it. The hints of vertices are such names.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/geometry/geometry_model.h"

namespace weft::meshing {

inline constexpr std::uint32_t kNoName = 0xFFFFFFFFu;

/// A triangle of a patch that has no formula, with all that makes it a curved one. Local index i names a
/// corner and the edge opposite to it.
struct SurfaceTriangle {
  Box box() const {
    Box box;
    for (const Point& p : corners) box.include(p);
    return box;
  }

  std::array<Point, 3> corners;
  /// Inner control points of edge i (from corner i + 1 to i + 2), relative to its two ends.
  std::array<std::array<Vec, 2>, 3> handles;
  Vec normal;                               ///< lent by a corner, for where the triangle has none
  std::array<std::uint32_t, 3> vertices;    ///< of the boundary
  std::array<std::uint32_t, 3> neighbours;  ///< names; kNoName across feature edges
  PatchId patch;
  std::uint32_t number;  ///< in the boundary
};

/// A feature edge.
struct SurfaceFeature {
  Box box() const {
    Box box;
    for (const Point& p : ends) box.include(p);
    return box;
  }

  std::array<Point, 2> ends;              ///< of the lower vertex, of the upper one
  std::array<Vec, 2> handles;             ///< inner control points, relative to these
  std::array<double, 2> t;                ///< parameters of the ends on the model's edge
  std::array<std::uint32_t, 2> vertices;  ///< of the boundary, ascending
  /// Names of the edges before and after it along the curve; kNoName at the curve's ends.
  std::uint32_t previous, next;
  CurveId curve;
  std::uint32_t forward;                        ///< 1: the curve runs from the lower vertex to the upper one
  std::uint32_t first_triangle, num_triangles;  ///< in the piece's list
};

struct SurfaceCorner {
  std::uint32_t vertex;                                                      ///< of the boundary
  std::uint32_t node;                                                        ///< of the model
  std::uint32_t first_triangle, num_triangles, first_feature, num_features;  ///< in the piece's lists
};

/// Plain arrays; either the triangles or the features are empty.
struct SurfacePiece {
  std::uint32_t id = 0;
  Box box;
  std::vector<SurfaceTriangle> triangles;
  /// Of each triangle, where its corners lie on its face; empty where no face of a model asks for it.
  std::vector<std::array<Parameters, 3>> parameters;
  std::vector<SurfaceFeature> features;
  std::vector<SurfaceCorner> corners;
  std::vector<std::uint32_t> triangle_list, feature_list;  ///< names, of features and corners

  template <class Archive>
  void serialize(Archive& archive) {
    archive(id, box, triangles, parameters, features, corners, triangle_list, feature_list);
  }

  std::span<const std::uint32_t> triangles_at(const SurfaceFeature& f) const {
    return std::span(triangle_list).subspan(f.first_triangle, f.num_triangles);
  }
  std::span<const std::uint32_t> triangles_at(const SurfaceCorner& c) const {
    return std::span(triangle_list).subspan(c.first_triangle, c.num_triangles);
  }
  std::span<const std::uint32_t> features_at(const SurfaceCorner& c) const {
    return std::span(feature_list).subspan(c.first_feature, c.num_features);
  }
  std::size_t bytes() const;
};

/// Triangles or feature edges of a piece. Small enough that a part of a mesh takes little more than it needs.
inline constexpr std::uint32_t kSurfacePieceSize = 128;
/// A piece has up to three times as many corners.
inline constexpr int kSurfacePlaceBits = 9;

inline std::uint32_t surface_name(std::uint32_t piece, std::uint32_t place) {
  return piece << kSurfacePlaceBits | place;
}
inline std::uint32_t piece_of_name(std::uint32_t name) { return name >> kSurfacePlaceBits; }
inline std::uint32_t place_of_name(std::uint32_t name) { return name & ((1u << kSurfacePlaceBits) - 1); }

/// Some pieces of a surface, found by names. Copies share the pieces. Safe to read from many threads.
class SurfacePieces {
 public:
  using Piece = std::shared_ptr<const SurfacePiece>;

  /// Those that are here already are passed over.
  void add(std::span<const Piece> pieces);
  /// Ascending by id.
  std::span<const Piece> all() const { return pieces_; }
  bool has(std::uint32_t id) const { return find(id) != nullptr; }

  /// Null where the piece is not here, or has no such thing.
  const SurfacePiece* piece_of(std::uint32_t name) const {
    return name == kNoName ? nullptr : find(piece_of_name(name));
  }
  const SurfaceTriangle* triangle(std::uint32_t name) const {
    return place(piece_of(name), &SurfacePiece::triangles, name);
  }
  const SurfaceFeature* feature(std::uint32_t name) const {
    return place(piece_of(name), &SurfacePiece::features, name);
  }
  const SurfaceCorner* corner(std::uint32_t name) const {
    return place(piece_of(name), &SurfacePiece::corners, name);
  }

 private:
  static constexpr std::uint32_t kRowBits = 6, kRowMask = (1u << kRowBits) - 1;
  using Row = std::array<const SurfacePiece*, 1u << kRowBits>;

  const SurfacePiece* find(std::uint32_t id) const {
    const std::uint32_t row = id >> kRowBits;
    return row < row_of_.size() && row_of_[row] != kNoName ? rows_[row_of_[row]][id & kRowMask] : nullptr;
  }
  template <class T>
  static const T* place(const SurfacePiece* piece, std::vector<T> SurfacePiece::*list, std::uint32_t name) {
    const std::uint32_t at = place_of_name(name);
    return piece && at < (piece->*list).size() ? &(piece->*list)[at] : nullptr;
  }

  std::vector<Piece> pieces_;
  /// Pieces by id in rows, of which only those are there that have any.
  std::vector<std::uint32_t> row_of_;
  std::vector<Row> rows_;
};

/// Packs copies of shared pieces, or unpacks pieces to be shared.
template <class Archive>
void serialize_pieces(Archive& archive, std::vector<SurfacePieces::Piece>& pieces) {
  std::uint64_t count = pieces.size();
  archive(count);
  if constexpr (Archive::kPacks) {
    for (const auto& piece : pieces) archive(*piece);
  } else {
    for (std::uint64_t i = 0; i < count; ++i) {
      auto piece = std::make_shared<SurfacePiece>();
      archive(*piece);
      pieces.push_back(std::move(piece));
    }
  }
}

}  // namespace weft::meshing
