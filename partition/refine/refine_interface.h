// Refinement of the interface without communication: all holders of an interface edge split it at the same
// point, because the decision rests on nothing but what all of them hold.
//
// Longest edge first (in the metric; ties by global ids), until none is long. That may be interrupted at any
// length, to adapt what is not frozen, and gone on with: the order of the splits is the same. Two subdomains
// that share a face see the same edges of it appear in the same order, whatever happens elsewhere: the
// longest edge of the face is split before all others of it, and splits in other faces do not change them.
// Metrics at new vertices are interpolated along the edge, which is what the background has there: interface
// faces are faces of the background's tets.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "partition/refine/refined_vertices.h"
#include "partition/subdomain/geometry.h"
#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// A caller's flag beside kHasBeenFree: edges at this vertex must not be split unasked, since rounding might
/// invert tets around it in one of the subdomains that hold it. All holders of a vertex have the same.
inline constexpr std::uint8_t kDelicate = meshing::kCallerSecond;

/// Could a tet with such points be inverted by the rounding of a few points on its edges?
bool is_delicate(const std::array<meshing::Point, 4>& tet);

/// New vertices of the interface, for a subdomain that may have them too.
struct InterfaceVertices {
  struct Vertex {
    GlobalId id;
    std::uint32_t surface_hint;
    meshing::VertexKind kind;
  };
  std::vector<Vertex> vertices;  ///< by id

  template <class Archive>
  void serialize(Archive& archive) {
    archive(vertices);
  }
};

/// Splits the long edges of one subdomain's interface, level by level, between which the subdomain may be
/// adapted: so neither the interface nor what lies behind it is ever much finer than the other.
class InterfaceRefinement {
 public:
  InterfaceRefinement(Subdomain& subdomain, const Geometry& geometry);

  /// Splits all edges of the interface's faces longer than `longest` (in the metric), except required ones
  /// and those between vertices of curved boundary, and those inside a face that have no end as long as a
  /// side of it must stay. New vertices are frozen. Throws std::runtime_error should a split fail that must
  /// not.
  void refine(double longest, meshing::MetricMean mean = meshing::MetricMean::arithmetic);

  /// For each of the interface's neighbours, the new vertices that it may have too.
  std::vector<InterfaceVertices> created() const;

 private:
  Subdomain& subdomain_;
  const Geometry& geometry_;
  RefinedVertices vertices_;  ///< new ones sorted, except within a level
};

/// Which of the new vertices the neighbours have too, in the order of the neighbours: with this the interface
/// is right again.
void register_interface(Subdomain& subdomain, std::span<const InterfaceVertices> theirs);

}  // namespace weft::partition
