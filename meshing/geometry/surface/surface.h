// The reference geometry: the input's boundary triangulation, cut into patches and feature curves. What a
// patch or a curve is in between is told by a face or an edge of a CAD model, where the triangles have been
// classified on one; else it is read from the triangles, as a curved surface where they are not planar.
// Immutable; safe to read from many threads. Triangles are kept in pieces (surface_piece.h): of a part of a
// mesh those are enough that lie near its boundary.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "meshing/base/ids.h"
#include "meshing/base/point.h"
#include "meshing/geometry/model/model_classification.h"
#include "meshing/geometry/surface/surface_piece.h"
#include "meshing/geometry/surface/vertex_kind.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// A maximal edge-connected set of boundary triangles with one reference that no feature edge cuts off.
struct Patch {
  std::int32_t ref = 0;        ///< the input's triangle reference
  bool planar = false;         ///< all its points in one plane, to 1e-6 of its diameter
  Vec normal;                  ///< unit normal of a planar patch; zero otherwise
  double detail = kUnbounded;  ///< Model::detail of its faces, the least; unbounded where it lies on none
};

/// A chain of feature edges between corners (or a closed loop).
struct Curve {
  std::int32_t ref = 0;   ///< reference of the input's edges, 0 where there were none
  bool straight = false;  ///< all its points on one line, to 1e-6 of its length
  bool required = false;  ///< its edges must stay as they are
};

struct SurfaceTables;

class Surface {
 public:
  struct Options {
    double ridge_angle_degrees = kRidgeAngle;  ///< dihedral deviation above which an edge is a ridge
  };

  /// A feature edge of the input mesh: its end vertices (indices into MeshData::points, first < second).
  struct FeatureEdge {
    std::array<std::uint32_t, 2> vertices;
    CurveId curve;
  };

  /// A point put on the geometry, and the hint with which the next nearby query starts.
  struct OnSurface {
    Point x;
    Vec normal;  ///< unit, oriented as the input triangles of the patch are
    std::uint32_t hint = 0xFFFFFFFFu;
  };
  struct OnCurve {
    Point x;
    Vec tangent;  ///< unit
    std::uint32_t hint = 0xFFFFFFFFu;
  };

  /// Builds the geometry from `mesh.triangles`, `edges`, `ridges`, `corners`, `required_*`, in O(n log n).
  /// The triangles must be all of the mesh's boundary and material interfaces; their orientations may differ:
  /// each patch takes that of most of its triangles. Throws InputError for an index out of range. Feature
  /// edges are: listed edges (ridges and required ones among them) that are edges of a triangle, edges
  /// between different references, of one or more than two triangles, of required triangles, and edges whose
  /// two triangles' normals deviate by more than the ridge angle. Corners are: listed corners and required
  /// points of the surface; ends of a number other than 2 of feature edges (a dangling ridge's too); points
  /// where a chain of them turns by more than the ridge angle or changes reference, patches or being
  /// required; points where the surface only touches itself; tips of cones.
  Surface(const MeshData& mesh, const Options& options);
  /// On the model that the triangles have been classified on. Feature edges are also those between triangles
  /// of different groups of faces and those on edges of the model, corners the vertices on its nodes; within
  /// a face and along an edge of the model angles mean nothing.
  Surface(const MeshData& mesh, const Options& options, ModelClassification classification);
  /// Patches and curves alone, as build_surface() finds them: what lies between is in pieces, which part()
  /// takes.
  explicit Surface(std::shared_ptr<const SurfaceTables> tables);
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  /// The same patches and curves, which it shares, with these pieces of what lies between: a walk ends where
  /// they do. Of the mesh that the surface was built of it knows nothing.
  Surface part(SurfacePieces pieces) const;
  const SurfacePieces& pieces() const;

  std::span<const Patch> patches() const;
  std::span<const Curve> curves() const;

  // --- the mesh that the surface was built of ---
  std::span<const FeatureEdge> feature_edges() const;
  PatchId triangle_patch(std::uint32_t triangle) const;
  /// Kind of an input vertex (interior for one that no boundary triangle touches).
  VertexKind vertex_kind(std::uint32_t vertex) const;
  /// The hint of an input vertex: the name of a triangle for `surface`, of a feature edge for `ridge`, of
  /// itself for `corner`; kNoName where no query asks for it, as in a plane.
  std::uint32_t vertex_hint(std::uint32_t vertex) const;

  // --- queries ---
  /// Closest point of patch `patch` near `p`, found by walking from `hint` (of a vertex of kind `kind`, on or
  /// at the border of the patch; invalid or not there: global search). Planar patch: the input's plane, i.e.
  /// `p` itself where it lies there to rounding, not clamped to the patch's border. Curved: a point on cubic
  /// triangles (PN triangles, Vlachos et al. 2001) through the input's, with the arcs of `project_to_curve`
  /// as the patch's border. They meet without gaps but with slight kinks: a point off the surface may jump by
  /// about the kink times its distance when it passes one. Allocates nothing; below 1 us from a near hint.
  /// Where the patch is not planar and no piece here has any of it: `p`, and no normal.
  OnSurface project_to_patch(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  /// Closest point of the curve near `p`. Straight: the line, `p` itself where it lies there to rounding, not
  /// clamped to the curve's ends. Else cubic Hermite arcs through the input's feature vertices; where none of
  /// them is here `p`, and no tangent.
  OnCurve project_to_curve(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;

  // --- the CAD model ---
  /// Null where there is none.
  const Model* model() const;
  /// The faces that a patch lies on; none where it is reconstructed, several where the mesh does not keep
  /// them apart.
  std::span<const std::uint32_t> faces(PatchId patch) const;
  /// The edge that a curve lies on; kNoEntity where it lies on none.
  std::uint32_t edge(CurveId curve) const;
  /// The node of a corner, which has this hint; kNoEntity where it lies on none.
  std::uint32_t node(std::uint32_t corner_hint) const;
  struct OnModelFace {
    std::uint32_t face = kNoEntity;
    OnFace at;
  };
  /// The closest point of the faces of a patch that lies on some; arguments as of project_to_patch().
  OnModelFace closest_on_model(PatchId patch, const Point& p, VertexKind kind, std::uint32_t hint) const;
  /// The same of the edge of a curve that lies on one.
  OnEdge closest_on_model(CurveId curve, const Point& p, VertexKind kind, std::uint32_t hint) const;

 private:
  struct Impl;
  explicit Surface(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace weft::meshing
