// Refinement of the interface without communication: all holders of an interface edge split it at the same
// point, because the decision uses only data that all of them hold.
//
// Longest edge first (in the metric; ties by global ids), until none is long. This may be interrupted at any
// length, to adapt what is not frozen, and resumed: the order of the splits stays the same. Two subdomains
// that share a face see the same edges of it appear in the same order, whatever happens elsewhere: the
// longest edge of the face is split before all others of it, and splits in other faces do not change them.
// Metrics at new vertices are interpolated along the edge, which is what the background has there: interface
// faces are faces of the background's tets. Where it is another mesh that is a guess, the same for all
// holders; who frees such a vertex reads its metric anew.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "partition/refine/refined_vertices.h"
#include "partition/subdomain/geometry.h"
#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// A caller's flag beside kHasBeenFree: edges at this vertex must not be split without quality checks, since
/// rounding might invert tets around it in one of its holders. All holders of a vertex have the same flag.
inline constexpr std::uint8_t kDelicate = meshing::kCallerSecond;

/// Whether rounding of a few points on its edges might invert this tet.
bool is_delicate(const std::array<meshing::Point, 4>& tet);

/// New vertices of the interface, for a subdomain that may have them too, and all faces of it that this
/// subdomain may have the other side of.
struct InterfaceVertices {
  struct Vertex {
    GlobalId id;
    std::uint32_t surface_hint;
    meshing::VertexKind kind;
  };
  struct Face {
    std::uint64_t name;  ///< a hash of its vertices' ids
    std::uint64_t bits;  ///< a hash of the bits of their coordinates and metrics
    friend auto operator<=>(const Face&, const Face&) = default;
  };
  std::vector<Vertex> vertices;  ///< by id
  std::vector<Face> faces;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(vertices, faces);
  }
};

/// Edges of the interface are split that are longer by this than what is long inside. Bisection leaves more
/// and shorter edges than an adaptation does, and what lies beside them follows: what is left long is split
/// by the shifts. On cube-polar2 to 250,000 in 64 subdomains, for 1, 1.2 and 1.4, the interiors
/// take 17.9, 15.3 and 15.5 s, the shifts 5.0, 5.8 and 6.2; Q 1 % is .723, .726 and .727.
inline constexpr double kLongAtInterface = 1.25;

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

  /// For each of the interface's neighbours, the new vertices and the faces that it may have too. Throws
  /// std::runtime_error where two new vertices have one global id.
  std::vector<InterfaceVertices> created() const;

 private:
  void add_faces(std::vector<InterfaceVertices>& result) const;

  Subdomain& subdomain_;
  const Geometry& geometry_;
  RefinedVertices vertices_;  ///< new ones sorted, except within a level
};

/// Adds the neighbours as holders of the new vertices that they have too; `theirs`: of each neighbour, in
/// their order. Throws std::runtime_error naming a face of the interface that no neighbour has, or has with
/// other bits of coordinates or metrics: then the holders have decided differently.
void register_interface(Subdomain& subdomain, const Geometry& geometry,
                        std::span<const InterfaceVertices> theirs);

}  // namespace weft::partition
