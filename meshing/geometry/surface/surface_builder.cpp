// A surface is built whole, and then cut into pieces.
#include <algorithm>
#include <utility>

#include "meshing/base/sort_unique.h"
#include "meshing/geometry/surface/cut_surface.h"
#include "meshing/geometry/surface/model_tables.h"
#include "meshing/geometry/surface/surface_curves.h"
#include "meshing/geometry/surface/surface_shape.h"
#include "meshing/geometry/surface/surface_tables.h"
#include "meshing/geometry/surface/surface_topology.h"

namespace weft::meshing {
namespace {

/// Puts these into `all`; their numbers.
std::vector<std::int32_t> numbered(const std::vector<JointRef>& refs, JointRefs& all) {
  all = JointRefs(refs);
  std::vector<std::int32_t> numbers;
  numbers.reserve(refs.size());
  for (const JointRef& ref : refs) numbers.push_back(all.number(ref));
  return numbers;
}

class SurfaceBuilder {
 public:
  SurfaceBuilder(const MeshData& mesh, const Surface::Options& options, ModelClassification&& classification)
      : mesh_(mesh), options_(options), classification_(std::move(classification)) {
    tables_.model = classification_.model;
  }

  BuiltSurface build() {
    if (on_model())
      build_on_model();
    else
      build_topology(mesh_, {});
    find_patches();
    take_curves(curves_, tables_);
    auto handles = control_points(mesh_.points, tables_.patches, tables_.curves, topology_);
    if (on_model()) {
      put_patches_on_model(triangle_refs_, faces_of_patches(), tables_);
      put_curves_on_model(edge_refs_, patches_at_curves(), curves_, tables_);
      feature_t_ = parameters_at(topology_.features, classification_.edges);
    }
    BuiltSurface built;
    built.input = {topology_.triangle_patch, topology_.features, topology_.vertex_kind, {}};
    UncutSurface uncut{mesh_.points,          std::move(topology_),
                       std::move(handles),    std::move(classification_),
                       std::move(feature_t_), std::move(turned_)};
    SurfaceNames names = name_surface(uncut, tables_);
    built.cutter = std::make_shared<SurfaceCutter>(std::move(uncut), std::move(names));
    built.input.vertex_hint = built.cutter->vertex_hints();
    built.tables = std::make_shared<SurfaceTables>(std::move(tables_));
    return built;
  }

 private:
  bool on_model() const { return classification_.model != nullptr; }
  void build_topology(const MeshData& mesh, const KnownShapes& known);
  void build_on_model();
  void find_patches();
  MeshData with_joint_refs();
  std::vector<std::vector<std::uint32_t>> faces_of_patches() const;
  std::vector<std::vector<PatchId>> patches_at_curves() const;

  const MeshData& mesh_;
  const Surface::Options& options_;
  ModelClassification classification_;
  JointRefs triangle_refs_, edge_refs_;
  SurfaceTopology topology_;
  std::vector<FoundCurve> curves_;
  SurfaceTables tables_;
  std::vector<std::array<double, 2>> feature_t_;  // feature edge -> parameters at its lower and upper vertex
  std::vector<bool> turned_;                      // triangles whose order is not the input's
};

/// All at once of what parts of a surface do one after the other.
void SurfaceBuilder::build_topology(const MeshData& mesh, const KnownShapes& known) {
  TopologyBuilder builder(mesh, options_.ridge_angle_degrees, known);
  std::vector<FlatTriangle> flat = builder.flat_triangles();
  lend_normals(flat);
  builder.take_normals(flat);
  take_components_as_patches(mesh, builder);
  FormedCurves formed = form_curves(builder.own_features());
  curves_ = std::move(formed.curves);
  builder.take_curves(std::move(formed.of_features));
  builder.classify_vertices();
  topology_ = builder.take();
}

void SurfaceBuilder::find_patches() {
  const PlaneFits fits(mesh_.points, topology_);
  const std::vector<PatchExtent> extents = fits.extents({});
  const std::vector<PatchSums> sums = fits.sums(extents);
  tables_.planes = planes_of(extents, sums);
  tables_.patches =
      patches_of(topology_.patch_refs, extents, sums, fits.heights(tables_.planes), tables_.planes);
}

void SurfaceBuilder::build_on_model() {
  const MeshData joint = with_joint_refs();
  KnownShapes known{triangle_refs_.on_model(), edge_refs_.on_model(), {}};
  for (const auto& [vertex, node] : classification_.nodes) known.corners.push_back(vertex);
  build_topology(joint, known);
  for (std::size_t t = 0; t < topology_.triangles.size(); ++t)
    turned_.push_back(topology_.triangles[t] != mesh_.triangles[t]);
}

/// The mesh as the topology is to see it: references tell faces and edges of the model apart, and edges on
/// the model's edges are listed.
MeshData SurfaceBuilder::with_joint_refs() {
  const ModelClassification& c = classification_;
  std::vector<JointRef> triangles, edges;
  triangles.reserve(mesh_.triangles.size());
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    const std::uint32_t face = c.triangle_face[i];
    triangles.push_back({mesh_.triangle_refs[i], face == kNoEntity ? kNoEntity : c.face_group[face]});
  }
  std::vector<std::array<std::uint32_t, 2>> listed;
  for (std::size_t i = 0; i < mesh_.edges.size(); ++i) {
    const auto [a, b] = mesh_.edges[i];
    listed.push_back({std::min(a, b), std::max(a, b)});
    const EdgeOnModel* on_model = find_edge(c.edges, listed.back());
    edges.push_back({mesh_.edge_refs[i], on_model ? on_model->edge : kNoEntity});
  }
  std::sort(listed.begin(), listed.end());
  MeshData joint = mesh_;
  for (const EdgeOnModel& e : c.edges) {
    if (std::binary_search(listed.begin(), listed.end(), e.vertices)) continue;
    joint.edges.push_back(e.vertices);
    edges.push_back({0, e.edge});
  }
  joint.triangle_refs = numbered(triangles, triangle_refs_);
  joint.edge_refs = numbered(edges, edge_refs_);
  return joint;
}

std::vector<std::vector<std::uint32_t>> SurfaceBuilder::faces_of_patches() const {
  std::vector<std::vector<std::uint32_t>> faces(tables_.patches.size());
  for (std::uint32_t t = 0; t < topology_.triangles.size(); ++t)
    if (const std::uint32_t face = classification_.triangle_face[t]; face != kNoEntity)
      faces[topology_.triangle_patch[t].value].push_back(face);
  for (auto& of_patch : faces) sort_unique(of_patch);
  return faces;
}

std::vector<std::vector<PatchId>> SurfaceBuilder::patches_at_curves() const {
  std::vector<std::vector<PatchId>> patches(curves_.size());
  for (std::uint32_t f = 0; f < topology_.features.size(); ++f)
    if (topology_.on_curve[f].first)
      for (const std::uint32_t t : topology_.triangles_at(f))
        patches[topology_.features[f].curve.value].push_back(topology_.triangle_patch[t]);
  return patches;
}

}  // namespace

void take_curves(std::span<const FoundCurve> found, SurfaceTables& tables) {
  for (const FoundCurve& curve : found) {
    tables.curves.push_back(curve.curve());
    tables.lines.push_back(curve.line);
  }
}

BuiltSurface build_surface(const MeshData& mesh, const Surface::Options& options,
                           ModelClassification&& classification) {
  return SurfaceBuilder(mesh, options, std::move(classification)).build();
}

}  // namespace weft::meshing
