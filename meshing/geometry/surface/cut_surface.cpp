// Who is in which piece, then the pieces.
#include "meshing/geometry/surface/cut_surface.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"

namespace weft::meshing {
namespace {

using Names = std::vector<std::uint32_t>;

/// In the order of their keys.
Names by_keys(std::vector<std::pair<std::uint64_t, std::uint32_t>> keys) {
  std::ranges::sort(keys);
  Names order;
  order.reserve(keys.size());
  for (const auto& [key, i] : keys) order.push_back(i);
  return order;
}

/// Appends the names of those that are in pieces; returns how many.
template <class Name>
std::uint32_t append(std::span<const std::uint32_t> of, const Name& name, Names& list) {
  const std::size_t before = list.size();
  for (const std::uint32_t i : of)
    if (const std::uint32_t n = name(i); n != kNone) list.push_back(n);
  return static_cast<std::uint32_t>(list.size() - before);
}

Names at_vertex(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& list, std::uint32_t vertex) {
  Names all;
  for (auto i = std::ranges::lower_bound(list, std::pair{vertex, 0u}); i != list.end() && i->first == vertex;
       ++i)
    all.push_back(i->second);
  return all;
}

}  // namespace

std::uint64_t PieceOrder::key(const std::array<Point, 3>& corners) const {
  Point sum;
  for (int i = 0; i < 3; ++i) {
    std::array<double, 3> x{corners[0][i], corners[1][i], corners[2][i]};
    std::ranges::sort(x);
    sum[i] = x[0] + x[1] + x[2];
  }
  return curve_.key((1.0 / 3) * sum);
}

bool needs_triangles(const SurfaceTables& tables, PatchId patch) {
  if (!tables.patches[patch.value].planar) return true;
  return tables.is_on_model(patch) && !tables.has_formula(patch);
}

std::vector<std::uint8_t> curves_asked_for(const SurfaceTables& tables) {
  std::vector<std::uint8_t> asked_for(tables.curves.size());
  for (std::uint32_t c = 0; c < asked_for.size(); ++c)
    asked_for[c] = !tables.curves[c].straight || (tables.model && tables.curve_edge[c] != kNoEntity);
  return asked_for;
}

SurfaceNames name_surface(const UncutSurface& surface, SurfaceTables& tables) {
  const SurfaceTopology& s = surface.topology;
  Box box;
  for (const auto& t : s.triangles)
    for (const std::uint32_t v : t) box.include(surface.points[v]);
  const PieceOrder order(box);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::uint32_t t = 0; t < s.triangles.size(); ++t) {
    if (!needs_triangles(tables, s.triangle_patch[t])) continue;
    const auto& v = s.triangles[t];
    keys.emplace_back(order.key({surface.points[v[0]], surface.points[v[1]], surface.points[v[2]]}), t);
  }
  SurfaceNames names;
  names.triangles.assign(s.triangles.size(), kNone);
  names.of_triangles.members = by_keys(std::move(keys));
  for (std::size_t i = 0; i < names.of_triangles.members.size(); ++i)
    names.triangles[names.of_triangles.members[i]] = name_in_order(i, 0);

  tables.curve_in_pieces = curves_asked_for(tables);
  for (std::uint32_t f = 0; f < s.features.size(); ++f)
    if (std::ranges::any_of(s.triangles_at(f), [&](std::uint32_t t) { return names.triangles[t] != kNone; }))
      tables.curve_in_pieces[s.features[f].curve.value] = 1;
  keys.clear();
  for (std::uint32_t f = 0; f < s.features.size(); ++f) {
    const auto& [a, b] = s.features[f].vertices;
    if (tables.curve_in_pieces[s.features[f].curve.value])
      keys.emplace_back(order.key(std::array{surface.points[a], surface.points[b]}), f);
  }
  names.features.assign(s.features.size(), kNone);
  names.of_features.first = pieces_of(names.of_triangles.members.size());
  names.of_features.members = by_keys(std::move(keys));
  for (std::size_t i = 0; i < names.of_features.members.size(); ++i)
    names.features[names.of_features.members[i]] = name_in_order(i, names.of_features.first);
  return names;
}

SurfaceCutter::SurfaceCutter(UncutSurface&& surface, SurfaceNames&& names)
    : surface_(std::move(surface)), s_(surface_.topology), names_(std::move(names)) {
  name_corners();
}

bool SurfaceCutter::is_of_triangles(std::uint32_t id) const {
  const MadePieces& range = names_.of_triangles;
  return id >= range.first && id < range.first + pieces_of(range.members.size());
}

bool SurfaceCutter::is_own(std::uint32_t id) const {
  const MadePieces& range = names_.of_features;
  return is_of_triangles(id) || (id >= range.first && id < range.first + pieces_of(range.members.size()));
}

/// Each is in the piece of the first thing at it.
void SurfaceCutter::name_corners() {
  std::map<std::uint32_t, std::uint32_t> corners_of;  // piece -> how many
  std::uint32_t last = kNone;
  for (const auto& [v, t] : s_.corner_triangles) {
    if (v == std::exchange(last, v)) continue;
    Names named;
    append(
        at_vertex(s_.vertex_features, v), [&](std::uint32_t f) { return names_.features[f]; }, named);
    append(
        at_vertex(s_.corner_triangles, v), [&](std::uint32_t i) { return names_.triangles[i]; }, named);
    if (named.empty()) continue;
    const std::uint32_t piece = piece_of_name(named.front());
    if (is_own(piece)) corners_.push_back({v, surface_name(piece, corners_of[piece]++)});
  }
  std::ranges::sort(corners_, {}, &NamedCorner::name);
}

std::vector<std::uint32_t> SurfaceCutter::vertex_hints() const {
  Names hints(s_.vertex_hint.size(), kNone);
  for (std::uint32_t v = 0; v < hints.size(); ++v) {
    const std::uint32_t at = s_.vertex_hint[v];
    if (s_.vertex_kind[v] == VertexKind::surface) hints[v] = names_.triangles[at];
    if (s_.vertex_kind[v] == VertexKind::ridge) hints[v] = names_.features[at];
  }
  for (const NamedCorner& c : corners_) hints[c.vertex] = c.name;
  return hints;
}

std::vector<std::uint32_t> SurfaceCutter::ids() const {
  Names all;
  for (const MadePieces* range : {&names_.of_triangles, &names_.of_features})
    for (std::uint32_t i = 0; i < pieces_of(range->members.size()); ++i) all.push_back(range->first + i);
  return all;
}

/// The triangles or the features of a piece.
std::span<const std::uint32_t> SurfaceCutter::members(std::uint32_t id) const {
  const MadePieces& range = is_of_triangles(id) ? names_.of_triangles : names_.of_features;
  const std::size_t first = std::size_t{id - range.first} * kSurfacePieceSize;
  return std::span(range.members)
      .subspan(first, std::min<std::size_t>(kSurfacePieceSize, range.members.size() - first));
}

SurfacePieces::Piece SurfaceCutter::piece(std::uint32_t id) const {
  SurfacePieceParts parts;
  parts.id = id;
  if (is_of_triangles(id))
    add_triangles(members(id), parts);
  else
    for (const std::uint32_t f : members(id)) add_feature(f, parts);
  for (auto corner = std::ranges::lower_bound(corners_, surface_name(id, 0), {}, &NamedCorner::name);
       corner != corners_.end() && piece_of_name(corner->name) == id; ++corner)
    add_corner(corner->vertex, parts);
  return std::make_shared<const SurfacePiece>(parts);
}

Box SurfaceCutter::box(std::uint32_t id) const {
  Box box;
  for (const std::uint32_t i : members(id)) {
    const auto include = [&](const auto& vertices) {
      for (const std::uint32_t v : vertices) box.include(surface_.points[v]);
    };
    if (is_of_triangles(id))
      include(s_.triangles[i]);
    else
      include(s_.features[i].vertices);
  }
  return box;
}

void SurfaceCutter::add_triangles(std::span<const std::uint32_t> triangles, SurfacePieceParts& parts) const {
  Names edges, fans;
  for (const std::uint32_t t : triangles) {
    parts.vertices.insert(parts.vertices.end(), s_.triangles[t].begin(), s_.triangles[t].end());
    edges.insert(edges.end(), s_.triangle_edges[t].begin(), s_.triangle_edges[t].end());
    fans.push_back(lending_fan(t));
  }
  for (Names* list : {&parts.vertices, &edges, &fans}) sort_unique(*list);
  for (const std::uint32_t v : parts.vertices) parts.points.push_back(surface_.points[v]);
  for (const std::uint32_t e : edges)
    parts.handles.push_back(surface_.handles.empty() ? std::array<Vec, 2>{} : surface_.handles[e]);
  for (const std::uint32_t f : fans) parts.normals.push_back(f == kNone ? Vec{0, 0, 1} : s_.fans[f].normal);
  for (const std::uint32_t t : triangles) {
    parts.triangles.push_back(triangle(t, edges, fans, parts));
    if (!surface_.classification.parameters.empty()) parts.parameters.push_back(parameters(t));
  }
  for (std::uint32_t& v : parts.vertices) v = s_.vertex_number(v);
}

SurfaceTriangle SurfaceCutter::triangle(std::uint32_t t, const Names& edges, const Names& fans,
                                        const SurfacePieceParts& parts) const {
  const auto place = [](const Names& list, std::uint32_t i) {
    return static_cast<std::uint16_t>(place_in(list, i));
  };
  SurfaceTriangle r{};
  for (std::size_t i = 0; i < 3; ++i) {
    r.corners[i] = place(parts.vertices, s_.triangles[t][i]);
    r.edges[i] = place(edges, s_.triangle_edges[t][i]);
    const std::uint32_t n = s_.neighbors[t][i];
    r.neighbours[i] = n == kNone ? kNone : names_.triangles[n];
  }
  r.normal = place(fans, lending_fan(t));
  r.patch = s_.triangle_patch[t];
  return r;
}

/// The fan at a corner that has a normal; kNone where none has.
std::uint32_t SurfaceCutter::lending_fan(std::uint32_t t) const {
  for (const std::uint32_t fan : s_.triangle_fans[t])
    if (s_.fans[fan].normal != Vec{}) return fan;
  return kNone;
}

/// Triangles may have been turned since they were classified; parameters stand in the input's order.
std::array<Parameters, 3> SurfaceCutter::parameters(std::uint32_t t) const {
  const auto& q = surface_.classification.parameters[t];
  return surface_.turned[t] ? std::array<Parameters, 3>{q[0], q[2], q[1]} : q;
}

void SurfaceCutter::add_feature(std::uint32_t f, SurfacePieceParts& parts) const {
  SurfaceFeature r{};
  for (std::size_t i = 0; i < 2; ++i) {
    r.ends[i] = surface_.points[s_.features[f].vertices[i]];
    r.vertices[i] = s_.vertex_number(s_.features[f].vertices[i]);
  }
  if (!surface_.handles.empty()) r.handles = surface_.handles[s_.feature_edge[f]];
  if (!surface_.feature_t.empty()) r.t = surface_.feature_t[f];
  r.curve = s_.features[f].curve;
  r.forward = s_.on_curve[f].forward != 0;
  const auto& [low, high] = s_.features[f].vertices;
  r.previous = name_behind(f, r.forward ? low : high);
  r.next = name_behind(f, r.forward ? high : low);
  r.first_triangle = static_cast<std::uint32_t>(parts.triangle_list.size());
  r.num_triangles = append(
      s_.triangles_at(f), [&](std::uint32_t t) { return names_.triangles[t]; }, parts.triangle_list);
  parts.features.push_back(r);
}

/// Of the other feature edge of the curve at a vertex of one; kNone where the curve ends.
std::uint32_t SurfaceCutter::name_behind(std::uint32_t feature, std::uint32_t vertex) const {
  if (s_.vertex_kind[vertex] == VertexKind::corner) return kNone;
  for (const std::uint32_t f : at_vertex(s_.vertex_features, vertex))
    if (f != feature) return names_.features[f];
  return kNone;
}

void SurfaceCutter::add_corner(std::uint32_t corner, SurfacePieceParts& parts) const {
  SurfaceCorner r{s_.vertex_number(corner),
                  node(corner),
                  static_cast<std::uint32_t>(parts.triangle_list.size()),
                  0,
                  static_cast<std::uint32_t>(parts.feature_list.size()),
                  0};
  r.num_triangles = append(
      at_vertex(s_.corner_triangles, corner), [&](std::uint32_t t) { return names_.triangles[t]; },
      parts.triangle_list);
  r.num_features = append(
      at_vertex(s_.vertex_features, corner), [&](std::uint32_t f) { return names_.features[f]; },
      parts.feature_list);
  parts.corners.push_back(r);
}

std::uint32_t SurfaceCutter::node(std::uint32_t corner) const {
  const auto& nodes = surface_.classification.nodes;
  const auto at = std::ranges::lower_bound(nodes, std::pair{corner, 0u});
  return at != nodes.end() && at->first == corner ? at->second : kNoEntity;
}

}  // namespace weft::meshing
