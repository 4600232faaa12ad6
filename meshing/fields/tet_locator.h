// Where points are in a mesh, by a rule that does not depend on how they are looked for.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/geometry/model/closest_tree.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// A point is in every tet that holds it exactly; of these the largest is its place, or of equal ones the one
/// whose vertices come first. A point that no tet holds, be it by rounding, is at the closest point of the
/// boundary. So neither the hint nor the order of the tets matters, nor what is missing of the mesh: a face
/// that lost its other side only looks like boundary, and is never the closest one if all tets as near as the
/// true boundary are there. Safe to use from many threads.
class TetLocator {
 public:
  static constexpr std::uint32_t kNoHint = 0xFFFFFFFFu;

  /// `mesh` must outlive it and has tets, all of them positive, of which `adjacency` is.
  TetLocator(const MeshData& mesh, Adjacency adjacency);

  struct Place {
    std::uint32_t tet;         ///< the hint for the next point nearby
    std::array<double, 4> at;  ///< weights of its vertices, none negative, of sum 1
    double distance2 = 0;      ///< squared, of the point from the mesh
    bool inside = false;       ///< the tet holds the point exactly
  };
  /// Walks from tet `hint` (kNoHint: any). About 0.3 us from near by.
  Place locate(const Point& p, std::uint32_t hint) const;

  const MeshData& mesh() const { return mesh_; }
  const Adjacency& adjacency() const { return adjacency_; }

 private:
  struct BoundaryPoint {
    std::uint32_t face = kNoHint;  ///< 4 times the tet plus which of its faces
    std::array<double, 3> at{};
    double distance2 = 0;
  };

  std::array<Point, 4> corners_of(std::uint32_t tet) const;
  std::array<Point, 3> corners_of_face(std::uint32_t face) const;
  unsigned faces_with(std::uint32_t tet, const Point& p) const;
  bool comes_before(std::uint32_t a, std::uint32_t b) const;
  bool walk(const Point& p, std::uint32_t& tet) const;
  BoundaryPoint closest_on_boundary(const Point& p) const;
  std::uint32_t holder_near(const Point& p, const BoundaryPoint& closest) const;
  std::vector<std::uint32_t> holders_from(std::uint32_t tet, const Point& p) const;
  Place place_in(std::uint32_t tet, const Point& p) const;
  Place on_boundary(const BoundaryPoint& closest) const;

  const MeshData& mesh_;
  Adjacency adjacency_;
  ClosestForest boundary_;  ///< the faces without another side; of a mesh there are always some
  std::uint32_t root_;
};

}  // namespace weft::meshing
