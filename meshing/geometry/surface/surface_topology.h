// The combinatorial half of the reference geometry: edges, features, patches, fans and corners of a boundary
// triangulation, or of a part of one.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_curves.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

inline constexpr std::uint32_t kNone = 0xFFFFFFFFu;

/// The triangles around a vertex that are connected through it without crossing a feature edge.
struct Fan {
  std::uint32_t vertex = kNone;
  std::uint32_t first = kNone;  ///< the triangle at its clockwise end; any where it closes
  std::array<std::uint32_t, 2> borders{kNone, kNone};  ///< feature edges that end it; kNone where it closes
  Vec normal;                                          ///< unit mean normal, or zero where there is none
  bool peaked = false;                                 ///< no tangent plane: the tip of a cone
};

struct SurfaceTopology {
  /// Input triangles, turned so that they agree within a patch. Local index i names a corner and the edge
  /// opposite to it.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::array<std::uint32_t, 3>> triangle_edges;
  std::vector<std::array<std::uint32_t, 3>> triangle_fans;
  std::vector<std::array<std::uint32_t, 3>> neighbors;  ///< kNone across feature edges
  std::vector<PatchId> triangle_patch;
  std::vector<std::int32_t> patch_refs;

  std::vector<std::array<std::uint32_t, 2>> edges;  ///< every edge once, ends ascending, sorted
  std::vector<std::uint32_t> edge_feature;          ///< edge -> feature edge or kNone
  std::vector<Fan> fans;

  std::vector<Surface::FeatureEdge> features;
  std::vector<FeatureOnCurve> on_curve;               ///< feature edge -> what of its curve is there
  std::vector<std::uint32_t> feature_edge;            ///< feature edge -> edge
  std::vector<std::uint32_t> feature_triangle_begin;  ///< feature edge -> range of feature_triangle
  std::vector<std::uint32_t> feature_triangle;

  /// By triangle; empty where all are 0. 0: one of this part's own; 1: has a vertex of one of those; 2: one
  /// beyond. What is told of edges, fans, kinds and hints counts at the vertices of own triangles.
  std::vector<std::uint8_t> rings;
  std::vector<std::uint32_t> vertex_numbers;  ///< in the whole mesh, ascending; empty where it is whole

  std::vector<VertexKind> vertex_kind;
  std::vector<std::uint32_t> vertex_hint;
  /// (corner, triangle at it) and (vertex, feature edge at it), sorted.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> corner_triangles, vertex_features;

  std::span<const std::uint32_t> triangles_at(std::uint32_t feature) const {
    return std::span(feature_triangle)
        .subspan(feature_triangle_begin[feature],
                 feature_triangle_begin[feature + 1] - feature_triangle_begin[feature]);
  }
  std::uint32_t ring(std::uint32_t triangle) const { return rings.empty() ? 0 : rings[triangle]; }
  /// f(feature edge) of those whose first triangle is an own one: each is one part's.
  template <class F>
  void for_each_own_feature(const F& f) const {
    for (std::uint32_t i = 0; i < features.size(); ++i)
      if (ring(triangles_at(i)[0]) == 0) f(i);
  }
  std::uint32_t vertex_number(std::uint32_t vertex) const {
    return vertex_numbers.empty() ? vertex : vertex_numbers[vertex];
  }
};

inline int corner_of(const std::array<std::uint32_t, 3>& triangle, std::uint32_t vertex) {
  return triangle[0] == vertex ? 0 : triangle[1] == vertex ? 1 : 2;
}

/// What is known of references beside their equality: by triangle reference and by edge reference, whether a
/// model tells the shape there. Then angles between triangles, or along a chain, are those of a coarse mesh
/// and make no feature. Vertices on the model's nodes are corners as listed ones are.
struct KnownShapes {
  std::vector<bool> triangle_refs, edge_refs;
  std::vector<std::uint32_t> corners;
};

/// A triangle whose area is lost in rounding. It takes the normal of the one behind its longest edge.
struct FlatTriangle {
  std::uint32_t triangle;
  std::uint32_t behind;  ///< kNone: none, or several
  double turn;           ///< 1 or -1: `normal` times it is the triangle's
  Vec normal;            ///< of the one behind; zero where it is flat as well
};

/// Finds the normals of flat triangles, ascending, of a whole surface. Those whose chain to one that is not
/// flat is too long stay zero. FlatTriangle::normal becomes that of the triangle itself.
void lend_normals(std::vector<FlatTriangle>& flat);

/// The own triangles that are connected without crossing a feature edge, numbered by their first triangles.
struct SurfaceComponents {
  std::vector<std::uint32_t> of_triangle;  ///< kNone for those of others
  std::vector<std::uint8_t> turned;        ///< triangles that are to be turned to agree with their first
  std::uint32_t count() const { return static_cast<std::uint32_t>(one_sided.size()); }
  std::vector<std::uint8_t> one_sided;  ///< by component: it does not agree with itself, as a Moebius strip
};

/// Of triangles of which it is not known whether they are turned.
inline constexpr std::uint8_t kUnknownTurn = 2;

/// An edge that is no feature between an own triangle and another's.
struct SurfaceCrossing {
  std::uint32_t own, other;
  bool turned;  ///< they agree when one of them is turned
};

/// The steps to the topology of a surface, or of a part of it with two rings of triangles around its own
/// (SurfaceTopology::rings), where what is known of all parts comes in between:
///
///   flat_triangles, take_normals; components, crossings; find_steps, turn_along; take_patches;
///   own_features, take_curves, classify_vertices; take
///
/// Numbers are those of the mesh given; in a part triangles and vertices must have the order of the whole.
class TopologyBuilder {
 public:
  /// Throws InputError where an index is out of range or a triangle has a vertex twice. The mesh must stay.
  TopologyBuilder(const MeshData& mesh, double ridge_angle_degrees, const KnownShapes& known,
                  std::vector<std::uint8_t> rings = {}, std::vector<std::uint32_t> vertex_numbers = {});
  ~TopologyBuilder();
  TopologyBuilder(TopologyBuilder&&) noexcept;

  /// Of the own triangles, ascending.
  std::vector<FlatTriangle> flat_triangles() const;
  /// Of all triangles here that are flat.
  void take_normals(std::span<const FlatTriangle> normals);

  const SurfaceComponents& components();
  std::vector<SurfaceCrossing> crossings() const;
  /// How a patch with one side is turned: as on the shortest ways from its first triangle, of several the one
  /// by the lowest triangle. `steps` by triangle: how long the way is, kNone where that is not known; 0 of
  /// the first, kNone of other patches. The own triangles' become as short as what is here tells; whether
  /// some did.
  bool find_steps(std::vector<std::uint32_t>& steps) const;
  /// When all steps are final. `turned` by triangle: kUnknownTurn where that is not known, 0 of the first
  /// ones. The own triangles' become known as far as what is here tells; whether some did.
  bool turn_along(std::span<const std::uint32_t> steps, std::vector<std::uint8_t>& turned) const;
  /// Of all triangles here; `refs` of the whole surface's patches. Cuts the surface where neighbours do not
  /// agree, since normals must agree across an edge within a patch.
  void take_patches(std::vector<PatchId> of_triangle, std::vector<std::uint8_t> turned,
                    std::vector<std::int32_t> refs);

  /// In the order of SurfaceTopology::for_each_own_feature(), which is that of their vertices, numbers of the
  /// whole mesh.
  std::vector<FoundFeature> own_features() const;
  /// After patches: vertex_kind and vertex_hint.
  void classify_vertices();
  /// By feature edges here; those at own vertices count.
  void take_curves(std::vector<FeatureOnCurve> of_features);

  const SurfaceTopology& so_far() const;
  SurfaceTopology take();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Of a whole surface: each component becomes a patch, with the orientation that most of its triangles have
/// in the mesh.
void take_components_as_patches(const MeshData& mesh, TopologyBuilder& builder);

}  // namespace weft::meshing
