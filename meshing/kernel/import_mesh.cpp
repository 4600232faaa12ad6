// Checked construction of the kernel's mesh from plain arrays.
#include "meshing/kernel/import_mesh.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

#include "meshing/base/error.h"
#include "meshing/kernel/on_model.h"
#include "meshing/mesh/adjacency.h"
#include "meshing/mesh/boundary_entities.h"
#include "meshing/mesh/predicates.h"
#include "meshing/mesh/touching_edges.h"

namespace weft::meshing {
namespace {

void check_size(const char* what, std::size_t refs, std::size_t entities) {
  if (refs != entities)
    throw InputError("", what, fmt::format("{} references for {} entities", refs, entities));
}

/// Every index of `list` must be below `count`.
void check_list(const char* what, const char* of, const std::vector<std::uint32_t>& list, std::size_t count) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i] >= count)
      throw InputError("", fmt::format("{} {}", what, i + 1),
                       fmt::format("{} {} is out of range 1..{}", of, list[i] + 1, count));
}

template <std::size_t N>
void check_vertices(const char* what, const std::vector<std::array<std::uint32_t, N>>& entities,
                    std::size_t points) {
  for (std::size_t i = 0; i < entities.size(); ++i)
    for (const std::uint32_t v : entities[i])
      if (v >= points)
        throw InputError("", fmt::format("{} {}", what, i + 1),
                         fmt::format("vertex {} is out of range 1..{}", v + 1, points));
}

void refuse_tet(const MeshData& m, std::size_t t) {
  const auto& v = m.tets[t];
  const int sign = orientation(m.points[v[0]], m.points[v[1]], m.points[v[2]], m.points[v[3]]);
  throw InputError("", fmt::format("tet {} ({} {} {} {})", t + 1, v[0] + 1, v[1] + 1, v[2] + 1, v[3] + 1),
                   sign < 0 ? "is inverted (negative volume)" : "is flat (exactly zero volume)");
}

bool is_positive(const MeshData& m, const std::array<std::uint32_t, 4>& v) {
  return orientation(m.points[v[0]], m.points[v[1]], m.points[v[2]], m.points[v[3]]) > 0;
}

/// Throws for the first tet that is not positive.
void check_tets(const MeshData& m) {
  if (m.tets.empty()) throw InputError("", "Tetrahedra", "the mesh has none");
  const std::size_t first = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, m.tets.size()), m.tets.size(),
      [&](const tbb::blocked_range<std::size_t>& r, std::size_t found) {
        for (std::size_t t = r.begin(); t < r.end() && t < found; ++t)
          if (!is_positive(m, m.tets[t])) found = t;
        return found;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (first < m.tets.size()) refuse_tet(m, first);
}

/// Two positive tets across a face see it turning in opposite ways; the same way means they overlap.
void check_sides(const MeshData& m, const Adjacency& adjacency) {
  if (adjacency.turns_differ) return;
  for (std::uint32_t t = 0; t < m.tets.size(); ++t)
    for (int f = 0; f < 4; ++f) {
      const std::uint32_t n = adjacency.neighbours[t][f];
      if (n == kNoNeighbour || n >> 2 < t) continue;
      Triangle mine, other;
      for (int i = 0; i < 3; ++i) {
        mine[i] = m.tets[t][kTetFaces[f][i]];
        other[i] = m.tets[n >> 2][kTetFaces[n & 3][i]];
      }
      const auto at = std::find(other.begin(), other.end(), mine[0]) - other.begin();
      if (other[(at + 1) % 3] == mine[1])
        throw InputError("", fmt::format("tets {} and {}", t + 1, (n >> 2) + 1),
                         overlap_reason(m.tets[t] == m.tets[n >> 2]));
    }
}

/// Triangles of the boundary and of material interfaces, each with the code of one of its tet faces.
struct Boundary {
  MeshData data;  ///< points, triangles, feature entities; no tets
  std::vector<std::uint32_t> codes;
};

bool needs_triangle(const MeshData& m, std::uint32_t t, std::uint32_t neighbour) {
  return neighbour == kNoNeighbour || (m.tet_refs[t] != m.tet_refs[neighbour >> 2] && t < neighbour >> 2);
}

/// Takes the input's triangles, drops repeated ones, and returns the new index of each required triangle.
void take_triangles(const MeshData& m, const std::vector<std::uint32_t>& codes, const Adjacency& adjacency,
                    std::vector<std::uint8_t>& covered, Boundary& b, std::vector<std::string>& warnings) {
  std::vector<std::uint32_t> new_index(m.triangles.size(), kDropped);
  std::size_t repeated = 0;
  for (std::size_t i = 0; i < m.triangles.size(); ++i) {
    const auto& v = m.triangles[i];
    if (codes[i] == kNoNeighbour) throw InputError("", triangle_name(i, v), kIsNoFace);
    std::uint8_t& mine = covered[codes[i] >> 2];
    if (mine >> (codes[i] & 3) & 1) {
      ++repeated;
      continue;
    }
    mine = static_cast<std::uint8_t>(mine | 1u << (codes[i] & 3));
    if (const std::uint32_t n = adjacency.neighbours[codes[i] >> 2][codes[i] & 3]; n != kNoNeighbour)
      covered[n >> 2] = static_cast<std::uint8_t>(covered[n >> 2] | 1u << (n & 3));
    new_index[i] = static_cast<std::uint32_t>(b.codes.size());
    b.data.triangles.push_back(v);
    b.data.triangle_refs.push_back(m.triangle_refs[i]);
    b.codes.push_back(codes[i]);
  }
  if (repeated > 0) warnings.push_back(repeated_triangles_warning(repeated));
  take_required_triangles(m, new_index, b.data);
}

void create_missing(const MeshData& m, const Adjacency& adjacency, const std::vector<std::uint8_t>& covered,
                    Boundary& b, std::vector<std::string>& warnings) {
  std::size_t created = 0;
  for (std::uint32_t t = 0; t < m.tets.size(); ++t)
    for (int f = 0; f < 4; ++f) {
      if (covered[t] >> f & 1 || !needs_triangle(m, t, adjacency.neighbours[t][f])) continue;
      const auto& face = kTetFaces[f];
      b.data.triangles.push_back({m.tets[t][face[0]], m.tets[t][face[2]], m.tets[t][face[1]]});
      b.data.triangle_refs.push_back(0);
      b.codes.push_back(4 * t + static_cast<std::uint32_t>(f));
      ++created;
    }
  if (created > 0) warnings.push_back(created_triangles_warning(created));
}

/// See require_touching_edges.
void keep_touching_edges(const Adjacency& adjacency, Boundary& b, std::vector<std::string>& warnings) {
  std::vector<Triangle> outer;
  for (std::size_t i = 0; i < b.codes.size(); ++i)
    if (adjacency.neighbours[b.codes[i] >> 2][b.codes[i] & 3] == kNoNeighbour)
      outer.push_back(b.data.triangles[i]);
  if (const std::size_t count = require_touching_edges(outer, b.data); count > 0)
    warnings.push_back(touching_edges_warning(count));
}

std::unique_ptr<Surface> make_surface(const MeshData& m, MeshData& boundary, double ridge_angle_degrees,
                                      std::shared_ptr<const Model> model, std::vector<std::string>& warnings,
                                      ModelFaults& faults) {
  const Surface::Options options{ridge_angle_degrees};
  if (!model) return std::make_unique<Surface>(boundary, options);
  boundary.association = m.association;
  ModelClassification classification = classify_on_model(boundary, std::move(model));
  warnings.insert(warnings.end(), classification.warnings.begin(), classification.warnings.end());
  faults = classification.faults;
  return std::make_unique<Surface>(boundary, options, std::move(classification));
}

void fill_tets(const MeshData& m, const Adjacency& adjacency, TetMesh& mesh) {
  mesh.take_vertex_slots(static_cast<std::uint32_t>(m.points.size()));
  mesh.take_tet_slots(static_cast<std::uint32_t>(m.tets.size()));
  for (std::uint32_t v = 0; v < m.points.size(); ++v) {
    mesh.set_point(VertexId(v), m.points[v]);
    mesh.set_ref(VertexId(v), m.point_refs[v]);
  }
  for (std::uint32_t i = 0; i < m.tets.size(); ++i) {
    const TetId t(i);
    const auto& v = m.tets[i];
    mesh.set_vertices(t, {VertexId(v[0]), VertexId(v[1]), VertexId(v[2]), VertexId(v[3])});
    mesh.set_ref(t, m.tet_refs[i]);
    for (int f = 0; f < 4; ++f) {
      mesh.set_neighbour(t, f, TetFace(adjacency.neighbours[i][f]));
      mesh.set_tet_of(VertexId(v[f]), t);
    }
  }
}

void classify_boundary(const Boundary& b, const MeshData& m, const Surface& surface, TetMesh& mesh) {
  for (std::uint32_t i = 0; i < b.codes.size(); ++i) {
    const TetFace f(b.codes[i]);
    mesh.set_patch(f.tet(), f.face(), surface.triangle_patch(i));
    if (const TetFace n = mesh.neighbour(f.tet(), f.face()); n.valid())
      mesh.set_patch(n.tet(), n.face(), surface.triangle_patch(i));
  }
  for (std::uint32_t v = 0; v < m.points.size(); ++v) {
    mesh.set_kind(VertexId(v), surface.vertex_kind(v));
    mesh.set_surface_hint(VertexId(v), surface.vertex_hint(v));
    mesh.set_flags(VertexId(v), surface.vertex_kind(v) == VertexKind::corner ? kFixed : 0);
  }
  const auto add = [&](std::uint32_t v, int flag) {
    mesh.set_flags(VertexId(v), mesh.flags(VertexId(v)) | flag);
  };
  for (std::uint32_t i = 0; i < b.codes.size(); ++i)
    if (!surface.patches()[surface.triangle_patch(i).value].planar)
      for (const std::uint32_t v : b.data.triangles[i]) add(v, kOnCurved);
  for (const auto& e : surface.feature_edges())
    mesh.set_curve(VertexId(e.vertices[0]), VertexId(e.vertices[1]), e.curve);
  for (const std::uint32_t t : b.data.required_triangles)
    for (const std::uint32_t v : b.data.triangles[t]) add(v, kFixed);
  for (const std::uint32_t e : b.data.required_edges)
    for (const std::uint32_t v : b.data.edges[e]) add(v, kFixed);
  for (const std::uint32_t v : m.required_points) add(v, kFixed | kListedRequired);
  for (const std::uint32_t v : m.corners) add(v, kFixed | kListedCorner);
}

}  // namespace

void check_arrays(const MeshData& m) {
  check_size("vertices", m.point_refs.size(), m.points.size());
  check_size("tets", m.tet_refs.size(), m.tets.size());
  check_size("triangles", m.triangle_refs.size(), m.triangles.size());
  check_size("edges", m.edge_refs.size(), m.edges.size());
  for (std::size_t i = 0; i < m.points.size(); ++i)
    if (!std::isfinite(m.points[i].x + m.points[i].y + m.points[i].z))
      throw InputError("", fmt::format("vertex {}", i + 1), "has a coordinate that is not finite");
  check_vertices("tet", m.tets, m.points.size());
  check_vertices("triangle", m.triangles, m.points.size());
  check_vertices("edge", m.edges, m.points.size());
  check_list("corner", "vertex", m.corners, m.points.size());
  check_list("required vertex", "vertex", m.required_points, m.points.size());
  check_list("ridge", "edge", m.ridges, m.edges.size());
  check_list("required edge", "edge", m.required_edges, m.edges.size());
  check_list("required triangle", "triangle", m.required_triangles, m.triangles.size());
}

ImportedMesh import_mesh(const MeshData& m, double ridge_angle_degrees, std::size_t vertex_capacity,
                         std::size_t tet_capacity, std::shared_ptr<const Model> model) {
  check_arrays(m);
  check_tets(m);
  ImportedMesh r;
  Boundary b;
  b.data.points = m.points;
  b.data.corners = m.corners;
  b.data.required_points = m.required_points;
  r.adjacency = build_adjacency(m.tets, m.points.size());
  check_sides(m, r.adjacency);
  std::vector<std::uint8_t> covered(m.tets.size(), 0);
  take_triangles(m, match_triangles(m.triangles, m.tets, m.points.size()), r.adjacency, covered, b,
                 r.warnings);
  create_missing(m, r.adjacency, covered, b, r.warnings);
  take_boundary_edges(m, b.data, r.warnings);
  keep_touching_edges(r.adjacency, b, r.warnings);
  r.mesh = reserve_tet_mesh({vertex_capacity, tet_capacity}, {2 * m.points.size(), 2 * m.tets.size()});
  fill_tets(m, r.adjacency, *r.mesh);
  r.surface = make_surface(m, b.data, ridge_angle_degrees, std::move(model), r.warnings, r.on_model);
  classify_boundary(b, m, *r.surface, *r.mesh);
  r.patch_required.assign(r.surface->patches().size(), false);
  for (const std::uint32_t t : b.data.required_triangles)
    r.patch_required[r.surface->triangle_patch(t).value] = true;
  std::size_t unused = 0;
  for (std::uint32_t v = 0; v < m.points.size(); ++v) unused += !r.mesh->alive(VertexId(v));
  if (unused > 0) r.warnings.push_back(fmt::format("{} points that belong to no tet were dropped", unused));
  return r;
}

void read_metric(TetMesh& mesh, const Background& background, bool background_is_input) {
  if (background_is_input) {
    tbb::parallel_for(0u, mesh.vertex_slots(), [&](std::uint32_t i) {
      mesh.set_metric(VertexId(i), background.log_metric(i), exp_fast(background.log_metric(i)));
      mesh.set_background_hint(VertexId(i), mesh.tet_of(VertexId(i)).value);  // numbered alike
    });
    return;
  }
  // Neighbours in the file are often neighbours in space: each walk starts where the last one ended.
  std::uint32_t hint = Background::kNoHint;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) {
    const VertexId v(i);
    if (!mesh.alive(v)) continue;
    const Background::Sample s = background.at(mesh.point(v), hint);
    mesh.set_metric(v, s.log_metric, exp_fast(s.log_metric));
    mesh.set_background_hint(v, hint = s.tet);
  }
}

namespace {

void export_vertices(const TetMesh& mesh, MeshData& d, LogMetricField& log_metrics) {
  for (std::uint32_t i = 0, place = 0; i < mesh.vertex_slots(); ++i) {
    const VertexId v(i);
    if (!mesh.alive(v)) continue;
    d.points[place] = mesh.point(v);
    d.point_refs[place] = mesh.ref(v);
    log_metrics[place] = mesh.log_metric(v);
    if (mesh.kind(v) == VertexKind::corner || mesh.flags(v) & kListedCorner) d.corners.push_back(place);
    if (mesh.flags(v) & kListedRequired) d.required_points.push_back(place);
    ++place;
  }
}

void export_triangles(const TetMesh& mesh, TetId t, const std::array<std::uint32_t, 4>& v,
                      const Surface& surface, const std::vector<bool>& patch_required, MeshData& d) {
  for (int f = 0; f < 4; ++f) {
    const PatchId p = mesh.patch(t, f);
    if (!p.valid() || (mesh.neighbour(t, f).valid() && mesh.neighbour(t, f).tet() < t)) continue;
    if (patch_required[p.value])
      d.required_triangles.push_back(static_cast<std::uint32_t>(d.triangles.size()));
    // Outward normal: the face as seen from its tet turns inward.
    d.triangles.push_back({v[kTetFaces[f][0]], v[kTetFaces[f][2]], v[kTetFaces[f][1]]});
    d.triangle_refs.push_back(surface.patches()[p.value].ref);
  }
}

}  // namespace

std::vector<std::uint32_t> places_of_vertices(const TetMesh& mesh, std::uint32_t& count) {
  std::vector<std::uint32_t> places(mesh.vertex_slots());
  count = 0;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (mesh.alive(VertexId(i))) places[i] = count++;
  return places;
}

void export_mesh(const TetMesh& mesh, const Surface& surface, const std::vector<bool>& patch_required,
                 MeshData& d, LogMetricField& log_metrics) {
  std::uint32_t nv = 0;
  const std::vector<std::uint32_t> places = places_of_vertices(mesh, nv);
  d.points.resize(nv);
  d.point_refs.resize(nv);
  log_metrics.resize(nv);
  export_vertices(mesh, d, log_metrics);
  d.tets.reserve(mesh.tet_slots());
  d.tet_refs.reserve(mesh.tet_slots());
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    const TetVertices v = mesh.vertices(t);
    d.tets.push_back({places[v[0].value], places[v[1].value], places[v[2].value], places[v[3].value]});
    d.tet_refs.push_back(mesh.ref(t));
    export_triangles(mesh, t, d.tets.back(), surface, patch_required, d);
  }
  d.association = associate(mesh, surface, places);
  for (const TetMesh::FeatureEdge& e : mesh.feature_edges()) {
    const auto index = static_cast<std::uint32_t>(d.edges.size());
    const Curve& curve = surface.curves()[e.curve.value];
    d.edges.push_back({places[e.a.value], places[e.b.value]});
    d.edge_refs.push_back(curve.ref);
    d.ridges.push_back(index);
    if (curve.required) d.required_edges.push_back(index);
  }
}

}  // namespace weft::meshing
