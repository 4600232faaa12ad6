// Who is in which piece, then the pieces.
#include "meshing/geometry/cut_surface.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "meshing/base/box.h"
#include "meshing/base/morton.h"
#include "meshing/base/place_in.h"
#include "meshing/base/sort_unique.h"

namespace weft::meshing {
namespace {

using Names = std::vector<std::uint32_t>;

/// Those of `count` things that are needed, by their points' places along the curve.
template <class Needed, class At>
Names in_order(const MortonCurve& curve, std::size_t count, const Needed& needed, const At& at) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  for (std::uint32_t i = 0; i < count; ++i)
    if (needed(i)) keys.emplace_back(curve.key(at(i)), i);
  std::sort(keys.begin(), keys.end());
  Names order;
  order.reserve(keys.size());
  for (const auto& [key, i] : keys) order.push_back(i);
  return order;
}

/// A planar patch, or one on a face with a formula, asks for no triangle.
bool needs_triangles(const SurfaceTables& tables, PatchId patch) {
  if (!tables.patches[patch.value].planar) return true;
  return tables.is_on_model(patch) && !tables.has_formula(patch);
}

/// Appends the names of those that are in pieces; returns how many.
std::uint32_t append(std::span<const std::uint32_t> of, const Names& names, Names& list) {
  const std::size_t before = list.size();
  for (const std::uint32_t i : of)
    if (names[i] != kNone) list.push_back(names[i]);
  return static_cast<std::uint32_t>(list.size() - before);
}

Names at_corner(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& list, std::uint32_t corner) {
  Names all;
  for (auto i = std::ranges::lower_bound(list, std::pair{corner, 0u}); i != list.end() && i->first == corner;
       ++i)
    all.push_back(i->second);
  return all;
}

}  // namespace

SurfaceCutter::SurfaceCutter(WholeSurface&& whole, SurfaceTables& tables)
    : whole_(std::move(whole)),
      s_(whole_.topology),
      triangle_name_(s_.triangles.size(), kNone),
      feature_name_(s_.features.size(), kNone) {
  const auto point = [&](std::uint32_t v) { return whole_.points[v]; };
  Box box;
  for (const auto& t : s_.triangles)
    for (const std::uint32_t v : t) box.include(point(v));
  const MortonCurve curve(box);
  triangles_ = in_order(
      curve, s_.triangles.size(),
      [&](std::uint32_t t) { return needs_triangles(tables, s_.triangle_patch[t]); },
      [&](std::uint32_t t) {
        const auto& v = s_.triangles[t];
        return (1.0 / 3) * (point(v[0]) + point(v[1]) + point(v[2]));
      });
  triangle_pieces_ = name(triangles_, 0, triangle_name_);
  find_needed_curves(tables);
  features_ = in_order(
      curve, s_.features.size(),
      [&](std::uint32_t f) { return tables.curve_in_pieces[s_.features[f].curve.value] != 0; },
      [&](std::uint32_t f) {
        const auto& v = s_.features[f].vertices;
        return midpoint(point(v[0]), point(v[1]));
      });
  feature_pieces_ = name(features_, triangle_pieces_, feature_name_);
  name_corners();
}

void SurfaceCutter::find_needed_curves(SurfaceTables& tables) const {
  tables.curve_in_pieces.assign(s_.curves.size(), 0);
  for (std::uint32_t f = 0; f < s_.features.size(); ++f) {
    const std::uint32_t c = s_.features[f].curve.value;
    const bool on_edge = tables.model && tables.curve_edge[c] != kNoEntity;
    if (!s_.curves[c].straight || on_edge ||
        std::ranges::any_of(s_.triangles_at(f), [&](std::uint32_t t) { return triangle_name_[t] != kNone; }))
      tables.curve_in_pieces[c] = 1;
  }
}

/// Returns for how many pieces.
std::uint32_t SurfaceCutter::name(const Names& order, std::uint32_t first_piece, Names& names) const {
  for (std::uint32_t i = 0; i < order.size(); ++i)
    names[order[i]] = surface_name(first_piece + i / kSurfacePieceSize, i % kSurfacePieceSize);
  return (static_cast<std::uint32_t>(order.size()) + kSurfacePieceSize - 1) / kSurfacePieceSize;
}

/// Each is in the piece of the first thing at it.
void SurfaceCutter::name_corners() {
  std::vector<std::uint32_t> corners_of(triangle_pieces_ + feature_pieces_, 0);
  std::uint32_t last = kNone;
  for (const auto& [v, t] : s_.corner_triangles) {
    if (v == std::exchange(last, v)) continue;
    Names named;
    append(at_corner(s_.corner_features, v), feature_name_, named);
    append(at_corner(s_.corner_triangles, v), triangle_name_, named);
    if (named.empty()) continue;
    const std::uint32_t piece = piece_of_name(named.front());
    corners_.push_back({v, surface_name(piece, corners_of[piece]++)});
  }
  std::ranges::sort(corners_, {}, &NamedCorner::name);
}

std::vector<std::uint32_t> SurfaceCutter::vertex_hints() const {
  Names hints(s_.vertex_hint.size(), kNone);
  for (std::uint32_t v = 0; v < hints.size(); ++v) {
    const std::uint32_t at = s_.vertex_hint[v];
    if (s_.vertex_kind[v] == VertexKind::surface) hints[v] = triangle_name_[at];
    if (s_.vertex_kind[v] == VertexKind::ridge) hints[v] = feature_name_[at];
  }
  for (const NamedCorner& c : corners_) hints[c.vertex] = c.name;
  return hints;
}

std::vector<std::uint32_t> SurfaceCutter::ids() const {
  std::vector<std::uint32_t> all(triangle_pieces_ + feature_pieces_);
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

/// The triangles or the features of a piece.
std::span<const std::uint32_t> SurfaceCutter::members(std::uint32_t id) const {
  const bool of_triangles = id < triangle_pieces_;
  const std::span all(of_triangles ? triangles_ : features_);
  const std::size_t first = std::size_t{of_triangles ? id : id - triangle_pieces_} * kSurfacePieceSize;
  return all.subspan(first, std::min<std::size_t>(kSurfacePieceSize, all.size() - first));
}

SurfacePieces::Piece SurfaceCutter::piece(std::uint32_t id) const {
  SurfacePieceParts parts;
  parts.id = id;
  if (id < triangle_pieces_)
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
      for (const std::uint32_t v : vertices) box.include(whole_.points[v]);
    };
    if (id < triangle_pieces_)
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
  for (const std::uint32_t v : parts.vertices) parts.points.push_back(whole_.points[v]);
  for (const std::uint32_t e : edges)
    parts.handles.push_back(whole_.handles.empty() ? std::array<Vec, 2>{} : whole_.handles[e]);
  for (const std::uint32_t f : fans) parts.normals.push_back(f == kNone ? Vec{0, 0, 1} : s_.fans[f].normal);
  for (const std::uint32_t t : triangles) {
    parts.triangles.push_back(triangle(t, edges, fans, parts));
    if (!whole_.classification.parameters.empty()) parts.parameters.push_back(parameters(t));
  }
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
    r.neighbours[i] = n == kNone ? kNone : triangle_name_[n];
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
  const auto& q = whole_.classification.parameters[t];
  return whole_.turned[t] ? std::array<Parameters, 3>{q[0], q[2], q[1]} : q;
}

void SurfaceCutter::add_feature(std::uint32_t f, SurfacePieceParts& parts) const {
  SurfaceFeature r{};
  r.vertices = s_.features[f].vertices;
  for (std::size_t i = 0; i < 2; ++i) r.ends[i] = whole_.points[r.vertices[i]];
  if (!whole_.handles.empty()) r.handles = whole_.handles[s_.feature_edge[f]];
  if (!whole_.feature_t.empty()) r.t = whole_.feature_t[f];
  r.curve = s_.features[f].curve;
  const std::uint32_t place = s_.feature_place[f], c = r.curve.value;
  const std::uint32_t begin = s_.chain_begin[c], end = s_.chain_begin[c + 1];
  const bool closed = s_.closed(r.curve);
  const auto name_at = [&](std::uint32_t at) { return feature_name_[s_.chain_features[at]]; };
  r.previous = place > begin ? name_at(place - 1) : closed ? name_at(end - 1) : kNone;
  r.next = place + 1 < end ? name_at(place + 1) : closed ? name_at(begin) : kNone;
  r.forward = s_.chain_vertices[place + c] == r.vertices[0];
  r.first_triangle = static_cast<std::uint32_t>(parts.triangle_list.size());
  r.num_triangles = append(s_.triangles_at(f), triangle_name_, parts.triangle_list);
  parts.features.push_back(r);
}

void SurfaceCutter::add_corner(std::uint32_t corner, SurfacePieceParts& parts) const {
  SurfaceCorner r{corner,
                  node(corner),
                  static_cast<std::uint32_t>(parts.triangle_list.size()),
                  0,
                  static_cast<std::uint32_t>(parts.feature_list.size()),
                  0};
  r.num_triangles = append(at_corner(s_.corner_triangles, corner), triangle_name_, parts.triangle_list);
  r.num_features = append(at_corner(s_.corner_features, corner), feature_name_, parts.feature_list);
  parts.corners.push_back(r);
}

std::uint32_t SurfaceCutter::node(std::uint32_t corner) const {
  const auto& nodes = whole_.classification.nodes;
  const auto at = std::ranges::lower_bound(nodes, std::pair{corner, 0u});
  return at != nodes.end() && at->first == corner ? at->second : kNoEntity;
}

}  // namespace weft::meshing
