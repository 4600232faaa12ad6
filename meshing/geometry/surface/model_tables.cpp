// Patch by patch, then curve by curve.
#include "meshing/geometry/surface/model_tables.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "meshing/geometry/surface/surface_topology.h"

namespace weft::meshing {
namespace {

/// The plane of the model in the place of one through the points.
void take_plane(std::uint32_t patch, SurfaceTables& tables) {
  Patch& p = tables.patches[patch];
  Plane& plane = tables.planes[patch];
  const std::vector<std::uint32_t>& faces = tables.patch_faces[patch];
  const std::optional<Frame>* frame = faces.size() == 1 ? &tables.model->plane(faces[0]) : nullptr;
  p.planar = frame && *frame;
  if (!p.planar) {
    p.normal = {};
    return;
  }
  const double side = dot((*frame)->z, plane.normal) < 0 ? -1 : 1;
  plane.point = (*frame)->origin;
  p.normal = plane.normal = on_axes(side * (*frame)->z);
}

void take_line(std::uint32_t curve, const FoundCurve& found, SurfaceTables& tables) {
  const std::optional<Frame>& frame = tables.model->line(tables.curve_edge[curve]);
  tables.curves[curve].straight = frame.has_value();
  if (!frame) return;
  Line& line = tables.lines[curve];
  line.point = frame->origin;
  line.direction = on_axes((dot(found.chord, frame->x) < 0 ? -1.0 : 1.0) * frame->x);
  line.rounding = kRounding * found.length;
}

/// A curve that the user has drawn on a face: its vertices stay on the face.
void take_patch(std::uint32_t curve, const std::vector<PatchId>& at, SurfaceTables& tables) {
  const PatchId patch = at[0];
  const bool amid = std::ranges::all_of(
      at, [&](PatchId p) { return tables.patch_faces[p.value] == tables.patch_faces[patch.value]; });
  if (!amid || !tables.is_on_model(patch) || tables.patches[patch.value].planar) return;
  tables.curve_patch[curve] = patch.value;
  tables.curves[curve].straight = false;
}

}  // namespace

std::vector<std::array<double, 2>> parameters_at(std::span<const Surface::FeatureEdge> features,
                                                 std::span<const EdgeOnModel> edges) {
  std::vector<std::array<double, 2>> all(features.size());
  for (std::size_t f = 0; f < all.size(); ++f)
    if (const EdgeOnModel* edge = find_edge(edges, features[f].vertices)) all[f] = edge->t;
  return all;
}

void put_patches_on_model(const JointRefs& triangle_refs, std::vector<std::vector<std::uint32_t>> patch_faces,
                          SurfaceTables& tables) {
  tables.patch_faces = std::move(patch_faces);
  for (std::uint32_t p = 0; p < tables.patches.size(); ++p) {
    tables.patches[p].ref = triangle_refs[tables.patches[p].ref].ref;
    for (const std::uint32_t f : tables.patch_faces[p])
      tables.patches[p].detail = std::min(tables.patches[p].detail, tables.model->detail(f));
    if (!tables.patch_faces[p].empty()) take_plane(p, tables);
  }
}

void put_curves_on_model(const JointRefs& edge_refs, std::span<const std::vector<PatchId>> curve_patches,
                         std::span<const FoundCurve> curves, SurfaceTables& tables) {
  tables.curve_patch.assign(tables.curves.size(), kNone);
  for (std::uint32_t c = 0; c < tables.curves.size(); ++c) {
    const JointRef& joint = edge_refs[tables.curves[c].ref];
    tables.curves[c].ref = joint.ref;
    tables.curve_edge.push_back(joint.entity);
    if (joint.entity != kNoEntity)
      take_line(c, curves[c], tables);
    else
      take_patch(c, curve_patches[c], tables);
  }
}

}  // namespace weft::meshing
