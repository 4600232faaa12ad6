// Who is in which piece, then the pieces.
#include "meshing/geometry/cut_surface.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "meshing/base/box.h"
#include "meshing/base/morton.h"

namespace weft::meshing {
namespace {

using Names = std::vector<std::uint32_t>;

/// The places of points along a Morton curve through their box.
class MortonCurve {
 public:
  explicit MortonCurve(const Box& box)
      : lo_(box.lo), side_(std::max({box.size().x, box.size().y, box.size().z})) {}
  std::uint64_t key(const Point& p) const {
    constexpr double kCells = 1u << 21;
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i) {
      const double cell = side_ > 0 ? (p[i] - lo_[i]) / side_ * kCells : 0;
      key |= spread_bits(static_cast<std::uint64_t>(std::clamp(cell, 0.0, kCells - 1))) << i;
    }
    return key;
  }

 private:
  Point lo_;
  double side_;
};

class Cutter {
 public:
  Cutter(const WholeSurface& whole, SurfaceTables& tables)
      : whole_(whole),
        s_(whole.topology),
        tables_(tables),
        triangle_name_(s_.triangles.size(), kNone),
        feature_name_(s_.features.size(), kNone) {}

  SurfaceCut cut() {
    Box box;
    for (const auto& t : s_.triangles)
      for (const std::uint32_t v : t) box.include(whole_.points[v]);
    const MortonCurve curve(box);
    const Names triangles = in_order(
        curve, s_.triangles.size(), [&](std::uint32_t t) { return needs(t); },
        [&](std::uint32_t t) { return centre(t); });
    name(triangles, triangle_name_);
    find_needed_curves();
    const Names features = in_order(
        curve, s_.features.size(),
        [&](std::uint32_t f) { return tables_.curve_in_pieces[s_.features[f].curve.value] != 0; },
        [&](std::uint32_t f) { return middle(f); });
    name(features, feature_name_);
    for (const std::uint32_t t : triangles) add_triangle(t);
    for (const std::uint32_t f : features) add_feature(f);
    SurfaceCut result;
    result.vertex_hint = name_hints(add_corners());
    std::vector<SurfacePieces::Piece> shared;
    for (SurfacePiece& piece : pieces_) shared.push_back(std::make_shared<SurfacePiece>(std::move(piece)));
    result.pieces.add(shared);
    return result;
  }

 private:
  Point centre(std::uint32_t t) const {
    const auto& v = s_.triangles[t];
    return (1.0 / 3) * (whole_.points[v[0]] + whole_.points[v[1]] + whole_.points[v[2]]);
  }
  Point middle(std::uint32_t f) const {
    const auto& v = s_.features[f].vertices;
    return midpoint(whole_.points[v[0]], whole_.points[v[1]]);
  }

  /// A planar patch, or one on a face with a formula, asks for no triangle.
  bool needs(std::uint32_t t) const {
    const PatchId patch = s_.triangle_patch[t];
    if (!tables_.patches[patch.value].planar) return true;
    return tables_.is_on_model(patch) && !tables_.has_formula(patch);
  }

  void find_needed_curves() {
    tables_.curve_in_pieces.assign(s_.curves.size(), 0);
    for (std::uint32_t f = 0; f < s_.features.size(); ++f) {
      const std::uint32_t c = s_.features[f].curve.value;
      const bool on_edge = tables_.model && tables_.curve_edge[c] != kNoEntity;
      if (!s_.curves[c].straight || on_edge || std::ranges::any_of(s_.triangles_at(f), [&](std::uint32_t t) {
            return triangle_name_[t] != kNone;
          }))
        tables_.curve_in_pieces[c] = 1;
    }
  }

  template <class Needed, class At>
  Names in_order(const MortonCurve& curve, std::size_t count, const Needed& needed, const At& at) const {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    for (std::uint32_t i = 0; i < count; ++i)
      if (needed(i)) keys.emplace_back(curve.key(at(i)), i);
    std::sort(keys.begin(), keys.end());
    Names order;
    order.reserve(keys.size());
    for (const auto& [key, i] : keys) order.push_back(i);
    return order;
  }

  /// Makes pieces for these, in their order.
  void name(const Names& order, Names& names) {
    for (std::uint32_t i = 0; i < order.size(); ++i) {
      if (i % kSurfacePieceSize == 0) {
        pieces_.emplace_back();
        pieces_.back().id = static_cast<std::uint32_t>(pieces_.size()) - 1;
      }
      names[order[i]] = surface_name(pieces_.back().id, i % kSurfacePieceSize);
    }
  }

  /// Appends the names of those that are in pieces; returns how many.
  static std::uint32_t append(std::span<const std::uint32_t> of, const Names& names, Names& list) {
    const std::size_t before = list.size();
    for (const std::uint32_t i : of)
      if (names[i] != kNone) list.push_back(names[i]);
    return static_cast<std::uint32_t>(list.size() - before);
  }

  void add_triangle(std::uint32_t t) {
    SurfacePiece& piece = pieces_[piece_of_name(triangle_name_[t])];
    SurfaceTriangle r{};
    r.vertices = s_.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      r.corners[i] = whole_.points[r.vertices[i]];
      piece.box.include(r.corners[i]);
      const std::uint32_t n = s_.neighbors[t][i];
      r.neighbours[i] = n == kNone ? kNone : triangle_name_[n];
      if (whole_.handles.empty()) continue;
      const auto& h = whole_.handles[s_.triangle_edges[t][i]];
      const bool forward = r.vertices[(i + 1) % 3] < r.vertices[(i + 2) % 3];
      r.handles[i] = forward ? h : std::array<Vec, 2>{h[1], h[0]};
    }
    r.normal = lent_normal(t);
    r.patch = s_.triangle_patch[t];
    r.number = t;
    piece.triangles.push_back(r);
    if (whole_.classification && !whole_.classification->parameters.empty())
      piece.parameters.push_back(parameters(t));
  }

  Vec lent_normal(std::uint32_t t) const {
    for (const std::uint32_t fan : s_.triangle_fans[t])
      if (s_.fans[fan].normal != Vec{}) return s_.fans[fan].normal;
    return {0, 0, 1};
  }

  /// Triangles may have been turned since they were classified; parameters stand in the input's order.
  std::array<Parameters, 3> parameters(std::uint32_t t) const {
    const auto& q = whole_.classification->parameters[t];
    return (*whole_.turned)[t] ? std::array<Parameters, 3>{q[0], q[2], q[1]} : q;
  }

  void add_feature(std::uint32_t f) {
    SurfacePiece& piece = pieces_[piece_of_name(feature_name_[f])];
    SurfaceFeature r{};
    r.vertices = s_.features[f].vertices;
    for (std::size_t i = 0; i < 2; ++i) {
      r.ends[i] = whole_.points[r.vertices[i]];
      piece.box.include(r.ends[i]);
    }
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
    r.first_triangle = static_cast<std::uint32_t>(piece.triangle_list.size());
    r.num_triangles = append(s_.triangles_at(f), triangle_name_, piece.triangle_list);
    piece.features.push_back(r);
  }

  /// (corner, its name), ascending: those that have anything in pieces, each in the piece of that.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> add_corners() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> corners;
    for (const auto& [v, t] : s_.corner_triangles)
      if (corners.empty() || corners.back().first != v) corners.emplace_back(v, kNone);
    for (auto& [v, own_name] : corners) {
      const Names triangles = at_corner(s_.corner_triangles, v), features = at_corner(s_.corner_features, v);
      Names named;
      append(features, feature_name_, named);
      append(triangles, triangle_name_, named);
      if (named.empty()) continue;
      SurfacePiece& piece = pieces_[piece_of_name(named.front())];
      own_name = surface_name(piece.id, static_cast<std::uint32_t>(piece.corners.size()));
      SurfaceCorner r{v,
                      node(v),
                      static_cast<std::uint32_t>(piece.triangle_list.size()),
                      0,
                      static_cast<std::uint32_t>(piece.feature_list.size()),
                      0};
      r.num_triangles = append(triangles, triangle_name_, piece.triangle_list);
      r.num_features = append(features, feature_name_, piece.feature_list);
      piece.corners.push_back(r);
    }
    return corners;
  }

  static Names at_corner(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& list,
                         std::uint32_t corner) {
    Names all;
    for (auto i = std::ranges::lower_bound(list, std::pair{corner, 0u});
         i != list.end() && i->first == corner; ++i)
      all.push_back(i->second);
    return all;
  }

  std::uint32_t node(std::uint32_t corner) const {
    if (!whole_.classification) return kNoEntity;
    const auto& nodes = whole_.classification->nodes;
    const auto at = std::ranges::lower_bound(nodes, std::pair{corner, 0u});
    return at != nodes.end() && at->first == corner ? at->second : kNoEntity;
  }

  Names name_hints(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& corners) const {
    Names hints(s_.vertex_hint.size(), kNone);
    for (std::uint32_t v = 0; v < hints.size(); ++v) {
      const std::uint32_t at = s_.vertex_hint[v];
      if (s_.vertex_kind[v] == VertexKind::surface) hints[v] = triangle_name_[at];
      if (s_.vertex_kind[v] == VertexKind::ridge) hints[v] = feature_name_[at];
    }
    for (const auto& [v, own_name] : corners) hints[v] = own_name;
    return hints;
  }

  const WholeSurface& whole_;
  const SurfaceTopology& s_;
  SurfaceTables& tables_;
  Names triangle_name_, feature_name_;
  std::vector<SurfacePiece> pieces_;
};

}  // namespace

SurfaceCut cut_surface(const WholeSurface& whole, SurfaceTables& tables) {
  return Cutter(whole, tables).cut();
}

}  // namespace weft::meshing
