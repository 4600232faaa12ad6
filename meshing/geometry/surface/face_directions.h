// Whether a boundary has curved surfaces at all, found out cheaply and in shares.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"
#include "weft/data.h"

namespace weft::meshing {

/// The directions of triangles, to 1e-4, by reference: few where the boundary consists of planes. Bytes that
/// ranks can send each other; shares of a boundary merge in any order to the same answer.
class FaceDirections {
 public:
  void add(std::int32_t ref, const Point& a, const Point& b, const Point& c);
  void merge(const FaceDirections& other);
  /// May triangles of one reference that meet belong to a curved surface? Not where each two directions of
  /// the reference are the same or sharper than the ridge angle. More than kMost directions: yes.
  bool may_curve(double ridge_angle_degrees) const;

 private:
  struct Direction {
    std::int32_t ref, x, y, z;
    friend bool operator==(const Direction&, const Direction&) = default;
  };
  static constexpr std::uint32_t kMost = 64;
  void add(const Direction& direction);

  std::uint32_t count_ = 0;  ///< kMost + 1: too many
  std::array<Direction, kMost> directions_{};
};

/// Whether the boundary of a mesh has curved surfaces, as far as its triangles tell; those with a point that
/// is none are left out.
bool may_curve(const MeshData& mesh, double ridge_angle_degrees = kRidgeAngle);

}  // namespace weft::meshing
