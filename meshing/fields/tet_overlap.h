// The common part of two tets: a convex polytope, in barycentric coordinates of both.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "meshing/base/point.h"

namespace weft::meshing {

/// Finds common parts of tets, one after the other. The smaller tet is cut at the faces of the larger one
/// (Powell and Abel 2015: a polytope as the graph of its corners, each of which has three edges). Corners are
/// convex combinations in both tets, and a volume is that of the smaller tet times a determinant of
/// coordinates in it, so that volumes add up to rounding however thin the parts are.
class TetOverlap {
 public:
  /// Barycentric coordinates in the first tet, then those in the second.
  struct alignas(64) Corner {
    std::array<double, 8> both;
    std::span<const double, 4> in_first() const { return std::span(both).first<4>(); }
    std::span<const double, 4> in_second() const { return std::span(both).last<4>(); }
  };
  /// A tet of the common part.
  struct Piece {
    std::array<std::uint8_t, 4> corners;  ///< places
    double volume;                        ///< below 0 by rounding only
  };

  /// False where two positively oriented tets have no volume in common, or only touch. About 0.3 us.
  bool find(const std::array<Point, 4>& first, const std::array<Point, 4>& second);

  /// Calls visit(place, corner).
  template <class Visit>
  void for_each_corner(const Visit& visit) const {
    for (std::uint64_t rest = alive_; rest != 0; rest &= rest - 1) {
      const auto place = static_cast<std::size_t>(std::countr_zero(rest));
      visit(place, corners_[place]);
    }
  }
  const Corner& corner(std::size_t place) const { return corners_[place]; }
  std::span<const Piece> pieces() const { return {pieces_.data(), num_pieces_}; }
  double volume() const { return volume_; }
  /// Bit k: a part of the face opposite to corner k of the second tet bounds the common part.
  unsigned faces_of_second() const;

  // Four corners become at most 6, 12, 24 and 48, whatever rounding does.
  static constexpr std::size_t kPlaces = 64;

 private:
  /// 4 times the corner that it leaves plus which of its edges, counter-clockwise seen from outside.
  using HalfEdge = std::uint8_t;
  static constexpr std::size_t kMostPieces = 2 * 48;

  static std::size_t origin(HalfEdge e) { return e >> 2; }
  static HalfEdge half_edge(std::size_t corner, std::size_t side) {
    return static_cast<HalfEdge>(4 * corner + side);
  }
  /// The one after `e`'s opposite at the corner that `e` leads to: the next on the face.
  HalfEdge next_on_face(HalfEdge e) const;
  void join(HalfEdge a, HalfEdge b);

  // `own` and `cutting`: where in Corner::both the coordinates in the tet that is cut begin, and those in the
  // other.
  void start(std::size_t own, std::size_t cutting, const std::array<std::array<double, 4>, 4>& corners);
  void cut(std::size_t cutting, std::size_t k);
  std::uint64_t cut_edges(std::size_t cutting, std::size_t k, std::uint64_t kept);
  void close_faces(std::uint64_t created);
  void divide(std::size_t own, double volume);
  void add_piece(const std::array<std::uint8_t, 4>& corners, std::size_t own, double volume);

  std::array<Corner, kPlaces> corners_{};
  std::array<HalfEdge, 4 * kPlaces> opposite_{};
  std::uint64_t alive_ = 0;
  std::array<Piece, kMostPieces> pieces_{};
  std::size_t num_pieces_ = 0;
  double volume_ = 0;
};

}  // namespace weft::meshing
