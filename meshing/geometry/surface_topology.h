// The combinatorial half of the reference geometry: edges, features, patches, fans, corners and curves of a
// boundary triangulation.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/geometry/surface.h"
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
  std::vector<std::uint32_t> feature_edge;            ///< feature edge -> edge
  std::vector<std::uint32_t> feature_triangle_begin;  ///< feature edge -> range of feature_triangle
  std::vector<std::uint32_t> feature_triangle;
  std::vector<std::uint32_t> feature_place;  ///< feature edge -> its place in chain_features

  std::vector<Curve> curves;  ///< `straight` is left to the geometric half
  std::vector<std::uint32_t>
      chain_begin;  ///< curve -> range of chain_features; its vertices start at begin + curve
  std::vector<std::uint32_t> chain_features;
  std::vector<std::uint32_t> chain_vertices;  ///< one more than edges for each curve

  std::vector<VertexKind> vertex_kind;
  std::vector<std::uint32_t> vertex_hint;
  /// (corner, triangle at it) and (corner, feature edge at it), sorted.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> corner_triangles, corner_features;

  std::span<const std::uint32_t> triangles_at(std::uint32_t feature) const {
    return std::span(feature_triangle)
        .subspan(feature_triangle_begin[feature],
                 feature_triangle_begin[feature + 1] - feature_triangle_begin[feature]);
  }
  std::span<const std::uint32_t> chain(CurveId c) const {
    return std::span(chain_features)
        .subspan(chain_begin[c.value], chain_begin[c.value + 1] - chain_begin[c.value]);
  }
  std::span<const std::uint32_t> vertices_along(CurveId c) const {
    return std::span(chain_vertices)
        .subspan(chain_begin[c.value] + c.value, chain_begin[c.value + 1] - chain_begin[c.value] + 1);
  }
  /// A curve without ends: its first vertex is its last and no corner.
  bool closed(CurveId c) const {
    const auto v = vertices_along(c);
    return v.front() == v.back() && vertex_kind[v.front()] != VertexKind::corner;
  }
};

inline int corner_of(const std::array<std::uint32_t, 3>& triangle, std::uint32_t vertex) {
  return triangle[0] == vertex ? 0 : triangle[1] == vertex ? 1 : 2;
}

/// What is known of references beside their equality: by triangle reference and by edge reference, whether a
/// model tells the shape there. Then angles between triangles, or along a chain, are those of a coarse mesh
/// and make no feature.
struct KnownShapes {
  std::vector<bool> triangle_refs, edge_refs;
};

/// Builds all of it in O(n log n). Throws InputError where an index is out of range or a triangle has a
/// vertex twice.
SurfaceTopology build_surface_topology(const MeshData& mesh, double ridge_angle_degrees,
                                       const KnownShapes& known = {});

}  // namespace weft::meshing
