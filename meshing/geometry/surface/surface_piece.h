// The reference surface in pieces: what a projection reads of a hundred triangles, or of feature edges and
// corners, cut out once and never changed. A mesh has all pieces of its surface; a part of a mesh has
// those near its boundary, and they travel with it.
//
// Triangles, feature edges and corners have names that mean the same wherever their piece is: the piece's
// number and a place in it. The hints of vertices are such names.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/box.h"
#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/geometry/model/geometry_model.h"

namespace weft::meshing {

inline constexpr std::uint32_t kNoName = 0xFFFFFFFFu;

/// A triangle of a patch that has no formula, as its piece keeps it. Local index i names a corner and the
/// edge opposite to it.
struct SurfaceTriangle {
  std::array<std::uint16_t, 3> corners;     ///< places of its vertices in the piece
  std::array<std::uint16_t, 3> edges;       ///< places of their handles in the piece
  std::uint32_t normal;                     ///< place, in the piece, of one lent by a corner
  std::array<std::uint32_t, 3> neighbours;  ///< names; kNoName across feature edges
  PatchId patch;
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

/// What a piece is made of; either the triangles or the features are empty.
struct SurfacePieceParts {
  std::uint32_t id = 0;
  std::vector<std::uint32_t> vertices;  ///< of the boundary, those of the triangles; ascending
  std::vector<Point> points;            ///< theirs
  std::vector<std::array<Vec, 2>>
      handles;  ///< inner control points of an edge, relative to lower and upper end
  std::vector<Vec> normals;
  std::vector<SurfaceTriangle> triangles;
  /// Of each triangle, where its corners lie on its face; empty where no face of a model asks for it.
  std::vector<std::array<Parameters, 3>> parameters;
  std::vector<SurfaceFeature> features;
  std::vector<SurfaceCorner> corners;
  std::vector<std::uint32_t> triangle_list, feature_list;  ///< names, of features and corners
};

class TriangleView;

/// The parts in one block of bytes, which is what travels: copies of a piece share it, and so do messages.
struct SurfacePiece {
  explicit SurfacePiece(const SurfacePieceParts& parts);
  /// Of bytes() of another; `owner` keeps them, aligned as a double is. Throws std::runtime_error where they
  /// are not a piece's.
  SurfacePiece(std::span<const std::byte> bytes, std::shared_ptr<const void> owner);

  std::uint32_t id = 0;
  Box box;
  // As in SurfacePieceParts:
  std::span<const std::uint32_t> vertices;
  std::span<const Point> points;
  std::span<const std::array<Vec, 2>> handles;
  std::span<const Vec> normals;
  std::span<const SurfaceTriangle> triangles;
  std::span<const std::array<Parameters, 3>> parameters;
  std::span<const SurfaceFeature> features;
  std::span<const SurfaceCorner> corners;
  std::span<const std::uint32_t> triangle_list, feature_list;

  TriangleView triangle(std::size_t place) const;
  std::span<const std::uint32_t> triangles_at(const SurfaceFeature& f) const {
    return triangle_list.subspan(f.first_triangle, f.num_triangles);
  }
  std::span<const std::uint32_t> triangles_at(const SurfaceCorner& c) const {
    return triangle_list.subspan(c.first_triangle, c.num_triangles);
  }
  std::span<const std::uint32_t> features_at(const SurfaceCorner& c) const {
    return feature_list.subspan(c.first_feature, c.num_features);
  }
  std::span<const std::byte> bytes() const { return bytes_; }
  const std::shared_ptr<const void>& owner() const { return owner_; }

 private:
  void find_parts();

  std::span<const std::byte> bytes_;
  std::shared_ptr<const void> owner_;
};

/// A triangle with all that makes it a curved one, read from its piece; null where there is none.
class TriangleView {
 public:
  TriangleView() = default;
  TriangleView(const SurfacePiece& piece, const SurfaceTriangle& triangle)
      : piece_(&piece), triangle_(&triangle) {}
  explicit operator bool() const { return triangle_ != nullptr; }

  PatchId patch() const { return triangle_->patch; }
  const std::array<std::uint32_t, 3>& neighbours() const { return triangle_->neighbours; }
  std::array<std::uint32_t, 3> vertices() const {
    const auto& c = triangle_->corners;
    return {piece_->vertices[c[0]], piece_->vertices[c[1]], piece_->vertices[c[2]]};
  }
  const Point& corner(std::size_t i) const { return piece_->points[triangle_->corners[i]]; }
  std::array<Point, 3> corners() const { return {corner(0), corner(1), corner(2)}; }
  /// Inner control points of edge i (from corner i + 1 to i + 2), relative to its two ends.
  std::array<std::array<Vec, 2>, 3> handles() const {
    return {handles_along(0), handles_along(1), handles_along(2)};
  }
  /// For where the triangle has none.
  const Vec& lent_normal() const { return piece_->normals[triangle_->normal]; }
  Box box() const {
    Box box;
    for (std::size_t i = 0; i < 3; ++i) box.include(corner(i));
    return box;
  }

 private:
  /// Vertices of a piece ascend, and so do their places.
  std::array<Vec, 2> handles_along(std::size_t i) const {
    const std::array<Vec, 2>& h = piece_->handles[triangle_->edges[i]];
    return triangle_->corners[(i + 1) % 3] < triangle_->corners[(i + 2) % 3] ? h
                                                                             : std::array<Vec, 2>{h[1], h[0]};
  }

  const SurfacePiece* piece_ = nullptr;
  const SurfaceTriangle* triangle_ = nullptr;
};

inline TriangleView SurfacePiece::triangle(std::size_t place) const { return {*this, triangles[place]}; }

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
  TriangleView triangle(std::uint32_t name) const {
    const SurfacePiece* piece = piece_of(name);
    const std::uint32_t at = place_of_name(name);
    return piece && at < piece->triangles.size() ? piece->triangle(at) : TriangleView{};
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
  static const T* place(const SurfacePiece* piece, std::span<const T> SurfacePiece::*list,
                        std::uint32_t name) {
    const std::uint32_t at = place_of_name(name);
    return piece && at < (piece->*list).size() ? &(piece->*list)[at] : nullptr;
  }

  std::vector<Piece> pieces_;
  /// Pieces by id in rows, of which only those are there that have any.
  std::vector<std::uint32_t> row_of_;
  std::vector<Row> rows_;
};

/// Messages share the pieces' bytes, and pieces that are unpacked share the message's.
template <class Archive>
void serialize_pieces(Archive& archive, std::vector<SurfacePieces::Piece>& pieces) {
  std::uint64_t count = pieces.size();
  archive(count);
  if constexpr (Archive::kPacks) {
    for (const auto& piece : pieces) archive.share(piece->bytes(), piece->owner());
  } else {
    for (std::uint64_t i = 0; i < count; ++i) {
      auto [bytes, owner] = archive.shared();
      pieces.push_back(std::make_shared<const SurfacePiece>(bytes, std::move(owner)));
    }
  }
}

}  // namespace weft::meshing
