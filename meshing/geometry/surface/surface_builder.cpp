// A surface is built whole, and then cut into pieces.
#include <algorithm>
#include <map>
#include <utility>

#include "meshing/geometry/surface/cut_surface.h"
#include "meshing/geometry/surface/surface_curves.h"
#include "meshing/geometry/surface/surface_shape.h"
#include "meshing/geometry/surface/surface_tables.h"
#include "meshing/geometry/surface/surface_topology.h"

namespace weft::meshing {
namespace {

/// References that also tell the face or edge of the model: each pair gets a number, 0 for (0, none).
class JointRefs {
 public:
  std::int32_t number(std::int32_t ref, std::uint32_t entity) {
    const auto [at, fresh] =
        numbers_.emplace(std::pair{ref, entity}, static_cast<std::int32_t>(pairs_.size()));
    if (fresh) pairs_.push_back(at->first);
    return at->second;
  }
  std::int32_t ref(std::int32_t number) const { return pairs_[static_cast<std::size_t>(number)].first; }
  std::uint32_t entity(std::int32_t number) const { return pairs_[static_cast<std::size_t>(number)].second; }
  std::vector<bool> on_model() const {
    std::vector<bool> result;
    for (const auto& [ref, entity] : pairs_) result.push_back(entity != kNoEntity);
    return result;
  }

 private:
  std::map<std::pair<std::int32_t, std::uint32_t>, std::int32_t> numbers_{{{0, kNoEntity}, 0}};
  std::vector<std::pair<std::int32_t, std::uint32_t>> pairs_{{0, kNoEntity}};
};

class SurfaceBuilder {
 public:
  SurfaceBuilder(const MeshData& mesh, const Surface::Options& options, ModelClassification&& classification,
                 std::vector<std::uint32_t>&& vertex_numbers)
      : mesh_(mesh),
        options_(options),
        classification_(std::move(classification)),
        vertex_numbers_(std::move(vertex_numbers)) {
    tables_.model = classification_.model;
  }

  BuiltSurface build() {
    if (on_model())
      build_on_model();
    else
      build_topology(mesh_, {});
    find_patches();
    auto handles = control_points(mesh_.points, tables_.patches, curves_, topology_);
    if (on_model()) {
      take_patches_of_model();
      take_curves_of_model();
    }
    tables_.curves = curves_.curves;
    tables_.lines = curves_.lines;
    BuiltSurface built;
    built.input = {topology_.triangle_patch, topology_.features, topology_.vertex_kind, {}};
    UncutSurface uncut{
        mesh_.points,       std::move(topology_),       std::make_shared<SurfaceCurves>(std::move(curves_)),
        std::move(handles), std::move(classification_), std::move(feature_t_),
        std::move(turned_)};
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
  void take_patches_of_model();
  void take_curves_of_model();
  void take_plane(std::uint32_t patch);
  void take_line(std::uint32_t curve);

  const MeshData& mesh_;
  const Surface::Options& options_;
  ModelClassification classification_;
  std::vector<std::uint32_t> vertex_numbers_;
  JointRefs triangle_refs_, edge_refs_;
  SurfaceTopology topology_;
  SurfaceCurves curves_;
  SurfaceTables tables_;
  std::vector<std::array<double, 2>> feature_t_;  // feature edge -> parameters at its lower and upper vertex
  std::vector<bool> turned_;                      // triangles whose order is not the input's
};

/// All at once of what parts of a surface do one after the other.
void SurfaceBuilder::build_topology(const MeshData& mesh, const KnownShapes& known) {
  TopologyBuilder builder(mesh, options_.ridge_angle_degrees, known, {}, std::move(vertex_numbers_));
  std::vector<FlatTriangle> flat = builder.flat_triangles();
  lend_normals(flat);
  builder.take_normals(flat);
  take_components_as_patches(mesh, builder);
  curves_ = form_curves(builder.own_features());
  builder.take_curves(curves_);
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
  build_topology(joint, {triangle_refs_.on_model(), edge_refs_.on_model()});
  for (std::size_t t = 0; t < topology_.triangles.size(); ++t)
    turned_.push_back(topology_.triangles[t] != mesh_.triangles[t]);
}

/// The mesh as the topology is to see it: references tell faces and edges of the model apart, edges on the
/// model's edges are listed, and so are vertices on its nodes.
MeshData SurfaceBuilder::with_joint_refs() {
  const ModelClassification& c = classification_;
  MeshData joint = mesh_;
  for (std::size_t i = 0; i < joint.triangles.size(); ++i) {
    const std::uint32_t face = c.triangle_face[i];
    joint.triangle_refs[i] =
        triangle_refs_.number(mesh_.triangle_refs[i], face == kNoEntity ? kNoEntity : c.face_group[face]);
  }
  std::vector<std::array<std::uint32_t, 2>> listed;
  for (std::size_t i = 0; i < joint.edges.size(); ++i) {
    const auto [a, b] = mesh_.edges[i];
    listed.push_back({std::min(a, b), std::max(a, b)});
    const auto at =
        std::ranges::lower_bound(c.edges, listed.back(), {}, &ModelClassification::Edge::vertices);
    const bool found = at != c.edges.end() && at->vertices == listed.back();
    joint.edge_refs[i] = edge_refs_.number(mesh_.edge_refs[i], found ? at->edge : kNoEntity);
  }
  std::sort(listed.begin(), listed.end());
  for (const ModelClassification::Edge& e : c.edges) {
    if (std::binary_search(listed.begin(), listed.end(), e.vertices)) continue;
    joint.edges.push_back(e.vertices);
    joint.edge_refs.push_back(edge_refs_.number(0, e.edge));
  }
  for (const auto& [vertex, node] : c.nodes) joint.corners.push_back(vertex);
  return joint;
}

/// The plane of the model in the place of one through the points.
void SurfaceBuilder::take_plane(std::uint32_t patch) {
  Patch& p = tables_.patches[patch];
  Plane& plane = tables_.planes[patch];
  const std::vector<std::uint32_t>& faces = tables_.patch_faces[patch];
  const std::optional<Frame>* frame = faces.size() == 1 ? &tables_.model->plane(faces[0]) : nullptr;
  p.planar = frame && *frame;
  if (!p.planar) {
    p.normal = {};
    return;
  }
  const double side = dot((*frame)->z, plane.normal) < 0 ? -1 : 1;
  plane.point = (*frame)->origin;
  p.normal = plane.normal = on_axes(side * (*frame)->z);
}

void SurfaceBuilder::take_patches_of_model() {
  const ModelClassification& c = classification_;
  tables_.patch_faces.resize(tables_.patches.size());
  for (std::uint32_t t = 0; t < topology_.triangles.size(); ++t) {
    auto& faces = tables_.patch_faces[topology_.triangle_patch[t].value];
    const std::uint32_t face = c.triangle_face[t];
    if (face != kNoEntity && std::ranges::find(faces, face) == faces.end()) faces.push_back(face);
  }
  for (std::uint32_t p = 0; p < tables_.patches.size(); ++p) {
    tables_.patches[p].ref = triangle_refs_.ref(tables_.patches[p].ref);
    std::ranges::sort(tables_.patch_faces[p]);
    for (const std::uint32_t f : tables_.patch_faces[p])
      tables_.patches[p].detail = std::min(tables_.patches[p].detail, tables_.model->detail(f));
    if (!tables_.patch_faces[p].empty()) take_plane(p);
  }
}

void SurfaceBuilder::take_line(std::uint32_t curve) {
  const std::optional<Frame>& frame = tables_.model->line(tables_.curve_edge[curve]);
  curves_.curves[curve].straight = frame.has_value();
  if (!frame) return;
  Line& line = curves_.lines[curve];
  const auto points = curves_.points_along(CurveId(curve));
  const Vec chord = points.back() - points.front();
  line.point = frame->origin;
  line.direction = on_axes((dot(chord, frame->x) < 0 ? -1.0 : 1.0) * frame->x);
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += norm(points[i] - points[i - 1]);
  line.rounding = 1e-12 * length;
}

void SurfaceBuilder::take_curves_of_model() {
  const ModelClassification& c = classification_;
  tables_.curve_edge.resize(curves_.curves.size());
  tables_.curve_patch.assign(curves_.curves.size(), kNone);
  feature_t_.resize(topology_.features.size());
  for (std::uint32_t f = 0; f < topology_.features.size(); ++f) {
    const auto at = std::ranges::lower_bound(c.edges, topology_.features[f].vertices, {},
                                             &ModelClassification::Edge::vertices);
    if (at != c.edges.end() && at->vertices == topology_.features[f].vertices) feature_t_[f] = at->t;
  }
  for (std::uint32_t i = 0; i < curves_.curves.size(); ++i) {
    const std::int32_t number = curves_.curves[i].ref;
    curves_.curves[i].ref = edge_refs_.ref(number);
    tables_.curve_edge[i] = edge_refs_.entity(number);
    if (tables_.curve_edge[i] != kNoEntity) {
      take_line(i);
      continue;
    }
    // A curve that the user has drawn on a face: its vertices stay on the face.
    const auto at = topology_.triangles_at(curves_.chain(CurveId(i)).front());
    const PatchId patch = topology_.triangle_patch[at[0]];
    const bool amid = std::ranges::all_of(at, [&](std::uint32_t t) {
      return tables_.patch_faces[topology_.triangle_patch[t].value] == tables_.patch_faces[patch.value];
    });
    if (!amid || !tables_.is_on_model(patch) || tables_.patches[patch.value].planar) continue;
    tables_.curve_patch[i] = patch.value;
    curves_.curves[i].straight = false;
  }
}

}  // namespace

BuiltSurface build_surface(const MeshData& mesh, const Surface::Options& options,
                           ModelClassification&& classification, std::vector<std::uint32_t> vertex_numbers) {
  return SurfaceBuilder(mesh, options, std::move(classification), std::move(vertex_numbers)).build();
}

}  // namespace weft::meshing
