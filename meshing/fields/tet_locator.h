// Where points are in a mesh, by a rule that does not depend on how they are looked for.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/geometry/model/closest_tree.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// A point is in every tet that holds it exactly; of these the largest is its place, or of equal ones the one
/// whose vertices come first. A point that no tet holds, be it by rounding, is at the closest point of the
/// boundary, on the first of its faces by the same rule. So neither the hint nor the order of the tets
/// matters, nor what is missing of the mesh: a face that lost its other side only looks like boundary, and is
/// never the closest one if all tets as near as the true boundary are there, or if it is known as a cut. Safe
/// to use from many threads.
class TetLocator {
 public:
  static constexpr std::uint32_t kNoHint = 0xFFFFFFFFu;

  /// `mesh` must outlive it and has tets, all of them positive, of which `adjacency` is. `may_be_cut`: of
  /// vertices of a part, whether tets at them may be missing; a face of such alone is no boundary.
  TetLocator(const MeshData& mesh, Adjacency adjacency,
             const std::function<bool(std::uint32_t)>& may_be_cut = nullptr);

  struct Place {
    std::uint32_t tet;         ///< the hint for the next point nearby
    std::array<double, 4> at;  ///< weights of its vertices, none negative, of sum 1
    double distance2 = 0;      ///< squared, of the point from the mesh
    bool inside = false;       ///< the tet holds the point exactly
    std::uint32_t face = 0;    ///< of the tet, that a point which is not inside is closest to
  };
  /// Walks from tet `hint` (kNoHint: any). About 0.3 us from near by. Of a part: at an infinite distance
  /// where nothing here holds the point, and no face here is boundary.
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
  BoundaryPoint closest(const Point& p, std::uint32_t root) const;
  std::uint32_t holder_near(const Point& p, const BoundaryPoint& closest) const;
  std::vector<std::uint32_t> holders_from(std::uint32_t tet, const Point& p) const;
  Place place_in(std::uint32_t tet, const Point& p) const;
  Place beyond(const Point& p, const BoundaryPoint& border) const;

  const MeshData& mesh_;
  Adjacency adjacency_;
  ClosestForest faces_;                    ///< without another side
  std::uint32_t border_;                   ///< the tree of all; of a mesh there are always some
  std::optional<std::uint32_t> boundary_;  ///< that of those which are no cuts
};

}  // namespace weft::meshing
