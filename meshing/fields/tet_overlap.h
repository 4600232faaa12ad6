// The common part of two tets: a convex polytope, in barycentric coordinates of both.
#pragma once

#include <array>
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
  struct Corner {
    std::array<double, 4> in_first, in_second;  ///< barycentric coordinates
  };
  /// A tet of the common part.
  struct Piece {
    std::array<std::uint8_t, 4> corners;  ///< among corners()
    double volume;                        ///< below 0 by rounding only
  };

  /// False where two positively oriented tets have no volume in common, or only touch. About 0.3 us.
  bool find(const std::array<Point, 4>& first, const std::array<Point, 4>& second);

  std::span<const Corner> corners() const { return {corners_.data(), size_}; }
  std::span<const Piece> pieces() const { return {pieces_.data(), num_pieces_}; }
  double volume() const { return volume_; }
  /// Whether a part of the face opposite to corner k of the second tet bounds the common part.
  bool reaches_face_of_second(std::size_t k) const;

 private:
  using Coordinates = std::array<double, 4> Corner::*;
  // Four corners become at most 6, 12, 24 and 48, whatever rounding does.
  static constexpr std::size_t kMostCorners = 48, kMostPieces = 2 * kMostCorners;

  void start(Coordinates own, Coordinates cutting, const std::array<std::array<double, 4>, 4>& corners);
  void cut(Coordinates cutting, std::size_t k);
  void cut_edges(Coordinates cutting, std::size_t k, std::uint64_t kept);
  bool close_faces(std::size_t first_new);
  void drop(std::uint64_t dropped);
  void divide(Coordinates own, double volume);
  void add_piece(const std::array<std::uint8_t, 4>& corners, Coordinates own, double volume);
  std::size_t side_of(std::size_t from, std::size_t at) const;

  std::array<Corner, 2 * kMostCorners> corners_{};
  /// Counter-clockwise, seen from outside.
  std::array<std::array<std::uint8_t, 3>, 2 * kMostCorners> neighbours_{};
  std::array<Piece, kMostPieces> pieces_{};
  std::size_t size_ = 0, num_pieces_ = 0;
  double volume_ = 0;
};

}  // namespace weft::meshing
