// Boundary faces tell the faces of the model, feature edges the edges, corners the nodes.
#include "meshing/kernel/on_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace weft::meshing {
namespace {

using Kind = ModelEntityAccount::Kind;
constexpr std::size_t kMostListed = 100;

/// A face of a tet on a patch of the model, once, seen from that tet.
struct BoundaryFace {
  std::array<VertexId, 3> v;
  PatchId patch;
  std::int32_t ref;  ///< of the tet
  bool both;         ///< there is a tet of the same reference behind it: it has no side of its own
};

std::vector<BoundaryFace> boundary_faces(const TetMesh& mesh) {
  std::vector<BoundaryFace> faces;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const TetId t(i);
    if (!mesh.alive(t)) continue;
    for (int f = 0; f < 4; ++f) {
      const PatchId p = mesh.patch(t, f);
      const TetFace behind = mesh.neighbour(t, f);
      if (!p.valid() || (behind.valid() && behind.tet() < t)) continue;
      const auto at = [&](int k) { return mesh.vertex(t, kTetFaces[f][k]); };
      faces.push_back(
          {{at(0), at(2), at(1)}, p, mesh.ref(t), behind.valid() && mesh.ref(behind.tet()) == mesh.ref(t)});
    }
  }
  return faces;
}

/// A vertex on an entity of the model.
struct Place {
  VertexId vertex;
  Kind kind;
  std::uint32_t entity;
  double distance;
  Parameters at;
};

std::vector<Place> places_on_faces(const TetMesh& mesh, const Surface& surface,
                                   const std::vector<BoundaryFace>& faces) {
  std::vector<std::pair<VertexId, PatchId>> pairs;
  for (const BoundaryFace& f : faces)
    if (!surface.faces(f.patch).empty())
      for (const VertexId v : f.v) pairs.emplace_back(v, f.patch);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<Place> places;
  for (const auto& [v, patch] : pairs) {
    const auto q = surface.closest_on_model(patch, mesh.point(v), mesh.kind(v), mesh.surface_hint(v));
    places.push_back({v, Kind::face, q.face, q.at.distance, surface.model()->wrapped(q.face, q.at.at)});
  }
  // A vertex between two patches on one face.
  const auto key = [](const Place& p) { return std::tuple(p.vertex, p.entity); };
  std::stable_sort(places.begin(), places.end(),
                   [&](const Place& a, const Place& b) { return key(a) < key(b); });
  places.erase(std::unique(places.begin(), places.end(),
                           [&](const Place& a, const Place& b) { return key(a) == key(b); }),
               places.end());
  return places;
}

std::vector<Place> places_on_edges(const TetMesh& mesh, const Surface& surface) {
  std::vector<std::pair<VertexId, CurveId>> pairs;
  for (const TetMesh::FeatureEdge& e : mesh.feature_edges())
    if (surface.edge(e.curve) != kNoEntity)
      for (const VertexId v : {e.a, e.b}) pairs.emplace_back(v, e.curve);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<Place> places;
  for (const auto& [v, curve] : pairs) {
    const OnEdge q = surface.closest_on_model(curve, mesh.point(v), mesh.kind(v), mesh.surface_hint(v));
    const std::uint32_t e = surface.edge(curve);
    if (!places.empty() && places.back().vertex == v && places.back().entity == e) continue;
    places.push_back({v, Kind::edge, e, q.distance, {q.t, 0}});
  }
  return places;
}

std::vector<Place> places_on_nodes(const TetMesh& mesh, const Surface& surface) {
  std::vector<Place> places;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) {
    const VertexId v(i);
    if (!mesh.alive(v) || mesh.kind(v) != VertexKind::corner) continue;
    const std::uint32_t n = surface.node(mesh.surface_hint(v));
    if (n != kNoEntity)
      places.push_back({v, Kind::node, n, norm(mesh.point(v) - surface.model()->node(n)), {}});
  }
  return places;
}

/// Entities by kind and id, each with what is known of it.
class EntityTable {
 public:
  explicit EntityTable(const Model& model) {
    add(Kind::node, model.num_nodes());
    add(Kind::edge, model.num_edges());
    add(Kind::face, model.num_faces());
  }
  ModelEntitySums& of(Kind kind, std::uint32_t entity) {
    return all_[begin_[static_cast<std::size_t>(kind)] + entity];
  }
  void add(const Place& p) {
    ModelEntitySums& a = of(p.kind, p.entity);
    ++a.vertices;
    a.distance += p.distance;
    a.largest = std::max(a.largest, p.distance);
  }
  std::vector<ModelEntitySums> take() {
    std::erase_if(all_, [](const ModelEntitySums& a) { return a.vertices == 0 && a.measured == 0; });
    return std::move(all_);
  }

 private:
  void add(Kind kind, std::size_t count) {
    begin_[static_cast<std::size_t>(kind)] = all_.size();
    for (std::uint32_t i = 0; i < count; ++i) {
      ModelEntitySums a;
      a.kind = kind;
      a.entity = i;
      all_.push_back(a);
    }
  }
  std::vector<ModelEntitySums> all_;
  std::array<std::size_t, 3> begin_{};
};

using Normals = std::map<std::pair<std::uint32_t, std::int32_t>, ModelNormalSums>;

void judge_normal(const BoundaryFace& f, std::uint32_t face, const Vec& n, const Vec& of_model,
                  Normals& normals) {
  if (norm(n) == 0 || norm(of_model) == 0) return;
  const double product = f.both ? std::abs(dot(n, of_model)) : dot(n, of_model), cosine = product / norm(n);
  normals[{face, f.ref}].add({face, f.ref, product, cosine, cosine, cosine > 0, cosine < 0});
}

/// Deviation and normals of boundary faces.
void judge_faces(const TetMesh& mesh, const Surface& surface, const std::vector<BoundaryFace>& faces,
                 const ModelShare& share, EntityTable& entities, ModelSums& sums,
                 std::vector<double>* deviations) {
  Normals normals;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const BoundaryFace& f = faces[i];
    if (!share.triangles.empty() && !share.triangles[i]) continue;
    if (surface.faces(f.patch).empty()) {
      ++sums.unclassified_triangles;
      continue;
    }
    ++sums.triangles;
    const Point &a = mesh.point(f.v[0]), &b = mesh.point(f.v[1]), &c = mesh.point(f.v[2]);
    const auto q = surface.closest_on_model(f.patch, (1.0 / 3) * (a + b + c), mesh.kind(f.v[0]),
                                            mesh.surface_hint(f.v[0]));
    if (deviations)
      for (const VertexId v : f.v) {
        double& largest = (*deviations)[v.value];
        largest = std::fmax(largest, q.at.distance);  // NaN until there is one
      }
    ModelEntitySums& entity = entities.of(Kind::face, q.face);
    ++entity.measured;
    entity.deviation = std::max(entity.deviation, q.at.distance);
    judge_normal(f, q.face, cross(b - a, c - a), q.at.normal, normals);
  }
  for (const auto& [key, n] : normals) sums.normals.push_back(n);
}

void judge_edges(const TetMesh& mesh, const Surface& surface, EntityTable& entities) {
  for (const TetMesh::FeatureEdge& e : mesh.feature_edges()) {
    if (surface.edge(e.curve) == kNoEntity) continue;
    const OnEdge q = surface.closest_on_model(e.curve, midpoint(mesh.point(e.a), mesh.point(e.b)),
                                              mesh.kind(e.a), mesh.surface_hint(e.a));
    ModelEntitySums& entity = entities.of(Kind::edge, surface.edge(e.curve));
    ++entity.measured;
    entity.deviation = std::max(entity.deviation, q.distance);
  }
}

double tolerance_of(const Model& model, Kind kind, std::uint32_t entity) {
  return kind == Kind::node   ? model.node_tolerance(entity)
         : kind == Kind::edge ? model.edge_tolerance(entity)
                              : model.face_tolerance(entity);
}

/// The totals over vertices, each with its own entity: a node, else an edge, else a face.
void judge_vertices(std::vector<Place> places, const Model& model, ModelSums& sums) {
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return std::tuple(a.vertex, a.kind, a.distance) < std::tuple(b.vertex, b.kind, b.distance);
  });
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& p = places[i];
    if (i > 0 && places[i - 1].vertex == p.vertex) continue;
    ++sums.vertices;
    sums.distance += p.distance;
    sums.largest = std::max(sums.largest, p.distance);
    if (p.distance > std::max(kOffModel * model.size(), tolerance_of(model, p.kind, p.entity)))
      sums.listed.emplace_back(p.distance, p.vertex.value);
  }
  sums.off = sums.listed.size();
}

ModelEntityAccount account_of(const Model& model, const ModelEntitySums& sums) {
  ModelEntityAccount a;
  a.kind = sums.kind;
  a.id = static_cast<std::int32_t>(sums.entity + 1);
  a.tolerance = tolerance_of(model, sums.kind, sums.entity);
  a.vertices = sums.vertices;
  a.mean = sums.distance / static_cast<double>(sums.vertices);
  a.largest = sums.largest;
  a.deviation = sums.deviation;
  return a;
}

/// Which way a face looks from one side is what most of its triangles there say. Entities are in the order of
/// kinds and ids.
void add_normals(const std::vector<ModelNormalSums>& normals, std::vector<ModelEntityAccount>& entities) {
  for (const ModelNormalSums& n : normals) {
    const std::tuple wanted(Kind::face, static_cast<std::int32_t>(n.face + 1));
    const auto name = [](const ModelEntityAccount& e) { return std::tuple(e.kind, e.id); };
    const auto a = std::ranges::lower_bound(entities, wanted, {}, name);
    if (a == entities.end() || name(*a) != wanted) continue;
    a->least_normal = std::min(a->least_normal, n.side < 0 ? -n.largest_cosine : n.least_cosine);
    a->turned += n.side < 0 ? n.along : n.against;
  }
}

}  // namespace

void ModelNormalSums::add(const ModelNormalSums& more) {
  face = more.face;
  ref = more.ref;
  side += more.side;
  least_cosine = std::min(least_cosine, more.least_cosine);
  largest_cosine = std::max(largest_cosine, more.largest_cosine);
  along += more.along;
  against += more.against;
}

ModelSums sum_on_model(const TetMesh& mesh, const Surface& surface, const ModelShare& share,
                       std::vector<double>* deviations) {
  ModelSums sums;
  const std::vector<BoundaryFace> faces = boundary_faces(mesh);
  EntityTable entities(*surface.model());
  std::vector<Place> all;
  std::size_t record = 0;
  for (const auto& places : {places_on_nodes(mesh, surface), places_on_edges(mesh, surface),
                             places_on_faces(mesh, surface, faces)})
    for (const Place& p : places) {
      if (share.records.empty() || share.records[record]) entities.add(p);
      ++record;
      if (share.vertices.empty() || share.vertices[p.vertex.value]) all.push_back(p);
    }
  if (deviations) deviations->assign(mesh.vertex_slots(), std::numeric_limits<double>::quiet_NaN());
  judge_faces(mesh, surface, faces, share, entities, sums, deviations);
  judge_edges(mesh, surface, entities);
  judge_vertices(std::move(all), *surface.model(), sums);
  sums.entities = entities.take();
  return sums;
}

ModelAccount account_of(const Model& model, ModelSums sums) {
  ModelAccount total;
  total.model = model.geometry().name();
  total.unit = model.geometry().unit();
  total.scale = model.scale();
  total.size = model.size();
  total.nodes = model.num_nodes();
  total.edges = model.num_edges();
  total.faces = model.num_faces();
  total.tolerance = kOffModel * model.size();
  total.vertices = sums.vertices;
  total.triangles = sums.triangles;
  total.unclassified_triangles = sums.unclassified_triangles;
  total.largest = sums.largest;
  if (sums.vertices > 0) total.mean = sums.distance / static_cast<double>(sums.vertices);
  std::sort(sums.listed.begin(), sums.listed.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  total.off = sums.off;
  for (std::size_t i = 0; i < std::min(sums.listed.size(), kMostListed); ++i)
    total.listed.push_back(sums.listed[i].second);
  for (const ModelEntitySums& entity : sums.entities)
    if (entity.vertices > 0) total.entities.push_back(account_of(model, entity));
  add_normals(sums.normals, total.entities);
  for (const ModelEntityAccount& a : total.entities) {
    total.turned += a.turned;
    total.deviation = std::max(total.deviation, a.deviation);
    total.least_normal = std::min(total.least_normal, a.least_normal);
  }
  return total;
}

ModelAccount account_on_model(const TetMesh& mesh, const Surface& surface, std::vector<double>* deviations) {
  return account_of(*surface.model(), sum_on_model(mesh, surface, {}, deviations));
}

Association associate(const TetMesh& mesh, const Surface& surface, std::span<const std::uint32_t> places) {
  Association result;
  if (!surface.model()) return result;
  const auto id = [](const Place& p) { return static_cast<std::int32_t>(p.entity + 1); };
  const auto vertex = [&](const Place& p) { return places[p.vertex.value]; };
  for (const Place& p : places_on_nodes(mesh, surface)) result.nodes.push_back({vertex(p), id(p)});
  for (const Place& p : places_on_edges(mesh, surface))
    result.edges.push_back({vertex(p), id(p), p.at[0], static_cast<double>(id(p))});
  for (const Place& p : places_on_faces(mesh, surface, boundary_faces(mesh)))
    result.faces.push_back({vertex(p), id(p), p.at[0], p.at[1], static_cast<double>(id(p))});
  return result;
}

}  // namespace weft::meshing
