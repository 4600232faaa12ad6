// Builds edges, features, patches, fans and corners of a boundary triangulation; all by sorting.
#include "meshing/geometry/surface/surface_topology.h"

#include <algorithm>
#include <functional>
#include <numbers>
#include <numeric>
#include <queue>
#include <string>
#include <utility>

#include "meshing/base/error.h"

namespace weft::meshing {
namespace {

// kBeyond: not all triangles at the edge are known here.
constexpr std::uint8_t kFeature = 1, kRequired = 2, kBeyond = 4;

std::int32_t ref_at(const std::vector<std::int32_t>& refs, std::size_t i) {
  return i < refs.size() ? refs[i] : 0;
}

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

void check_index(std::uint64_t index, std::size_t size, const char* entity, std::size_t i) {
  if (index >= size) {
    throw InputError("", entity + (" " + std::to_string(i + 1)),
                     "index " + std::to_string(index + 1) + " is out of range");
  }
}

void check_indices(const MeshData& mesh) {
  const std::size_t n = mesh.points.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    for (std::uint32_t v : t) check_index(v, n, "triangle", i);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      throw InputError("", "triangle " + std::to_string(i + 1), "has a vertex twice");
    }
  }
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    for (std::uint32_t v : mesh.edges[i]) check_index(v, n, "edge", i);
  }
  const auto check_list = [](const std::vector<std::uint32_t>& list, std::size_t size, const char* name) {
    for (std::size_t i = 0; i < list.size(); ++i) check_index(list[i], size, name, i);
  };
  check_list(mesh.corners, n, "corner");
  check_list(mesh.required_points, n, "required vertex");
  check_list(mesh.ridges, mesh.edges.size(), "ridge");
  check_list(mesh.required_edges, mesh.edges.size(), "required edge");
  check_list(mesh.required_triangles, mesh.triangles.size(), "required triangle");
}

/// Unit normal; zero where the area is lost in rounding.
Vec triangle_normal(const Point& a, const Point& b, const Point& c) {
  const Vec n = cross(b - a, c - a);
  const double longest2 = std::max({norm2(b - a), norm2(c - b), norm2(a - c)});
  const double length = norm(n);
  return length > 1e-12 * longest2 ? (1 / length) * n : Vec{};
}

}  // namespace

struct TopologyBuilder::Impl {
  Impl(const MeshData& mesh, double ridge_angle_degrees, const KnownShapes& known)
      : mesh_(mesh),
        known_(known),
        ridge_angle_(ridge_angle_degrees * std::numbers::pi / 180),
        cos_ridge_(std::cos(ridge_angle_) - 1e-9) {}  // an angle of just the limit is no ridge

  struct HalfEdge {
    std::uint64_t key;
    std::uint32_t triangle, local;
  };

  void collect_edges();
  void compute_normals();
  FlatTriangle flat_triangle(std::uint32_t triangle) const;
  void find_complete_edges();
  void find_own_vertices();
  void mark_features();
  void mark_listed(std::size_t edge, std::uint8_t flags);
  bool is_ridge(std::uint32_t edge) const;
  void link_neighbors();
  void form_components();
  void flood(std::uint32_t seed);
  bool same_direction(const HalfEdge& a, const HalfEdge& b) const { return forward(a) == forward(b); }
  /// 1: the two triangles at the edge agree when one of them is turned.
  std::uint8_t turns_across(std::uint32_t edge) const {
    return same_direction(halves_[edge_begin_[edge]], halves_[edge_begin_[edge] + 1]);
  }
  bool forward(const HalfEdge& h) const {
    const auto& t = s_.triangles[h.triangle];
    return t[(h.local + 1) % 3] < t[(h.local + 2) % 3];
  }
  bool find_steps(std::vector<std::uint32_t>& steps) const;
  bool turn_along(std::span<const std::uint32_t> steps, std::vector<std::uint8_t>& turned) const;
  void cut_where_turned(std::span<const std::uint8_t> turned);
  void turn_triangles(std::span<const std::uint8_t> turned);
  void list_features();
  void form_fans();
  void walk_fan(std::uint32_t triangle, int corner);
  void compute_fan_normals();
  void find_peaks();
  void find_corners();
  bool chain_breaks(std::uint32_t vertex, std::uint32_t a, std::uint32_t b) const;
  bool same_patches(std::uint32_t a, std::uint32_t b) const;
  void classify_vertices();

  std::uint32_t count_triangles(std::uint32_t edge) const {
    return edge_begin_[edge + 1] - edge_begin_[edge];
  }

  bool is_known(const std::vector<bool>& refs, std::int32_t ref) const {
    return static_cast<std::size_t>(ref) < refs.size() && refs[static_cast<std::size_t>(ref)];
  }

  bool is_own(std::uint32_t triangle) const { return s_.ring(triangle) == 0; }
  bool is_own_vertex(std::uint32_t vertex) const {
    return own_vertex_.empty() ? fan_count_[vertex] > 0 : own_vertex_[vertex] != 0;
  }

  const MeshData& mesh_;
  const KnownShapes known_;
  double ridge_angle_, cos_ridge_;
  SurfaceTopology s_;
  std::vector<HalfEdge> halves_;           // sorted by edge
  std::vector<std::uint32_t> edge_begin_;  // edge -> range of halves_
  std::vector<std::uint8_t> edge_flags_;
  std::vector<std::int32_t> edge_ref_;
  std::vector<Vec> normals_;
  std::vector<std::uint32_t> flat_;       // triangles
  std::vector<std::uint8_t> own_vertex_;  // empty: all that have triangles
  SurfaceComponents components_;
  std::vector<std::uint32_t> queue_;
  std::vector<std::uint32_t> fan_count_;  // vertex -> fans
  std::vector<std::uint8_t> is_corner_;
};

void TopologyBuilder::Impl::collect_edges() {
  s_.triangles = mesh_.triangles;
  const std::uint32_t n = static_cast<std::uint32_t>(s_.triangles.size());
  halves_.reserve(3 * std::size_t{n});
  for (std::uint32_t t = 0; t < n; ++t) {
    const auto& v = s_.triangles[t];
    for (std::uint32_t i = 0; i < 3; ++i) halves_.push_back({edge_key(v[(i + 1) % 3], v[(i + 2) % 3]), t, i});
  }
  std::sort(halves_.begin(), halves_.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.key != b.key ? a.key < b.key : a.triangle < b.triangle;
  });
  s_.triangle_edges.resize(n);
  for (std::uint32_t h = 0; h < halves_.size(); ++h) {
    if (h == 0 || halves_[h].key != halves_[h - 1].key) {
      const std::uint64_t key = halves_[h].key;
      s_.edges.push_back({static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)});
      edge_begin_.push_back(h);
    }
    s_.triangle_edges[halves_[h].triangle][halves_[h].local] =
        static_cast<std::uint32_t>(s_.edges.size() - 1);
  }
  edge_begin_.push_back(static_cast<std::uint32_t>(halves_.size()));
  edge_flags_.assign(s_.edges.size(), 0);
}

/// Of a part: two rings reach all triangles at the edges of the first.
void TopologyBuilder::Impl::find_complete_edges() {
  if (s_.rings.empty()) return;
  for (std::uint32_t e = 0; e < s_.edges.size(); ++e) {
    std::uint32_t least = 2;
    for (std::uint32_t h = edge_begin_[e]; h < edge_begin_[e + 1]; ++h)
      least = std::min(least, s_.ring(halves_[h].triangle));
    if (least == 2) edge_flags_[e] = kBeyond;
  }
}

void TopologyBuilder::Impl::find_own_vertices() {
  if (s_.rings.empty()) return;
  own_vertex_.assign(mesh_.points.size(), 0);
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t)
    if (is_own(t))
      for (const std::uint32_t v : s_.triangles[t]) own_vertex_[v] = 1;
}

void TopologyBuilder::Impl::compute_normals() {
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    const auto& v = s_.triangles[t];
    normals_.push_back(triangle_normal(mesh_.points[v[0]], mesh_.points[v[1]], mesh_.points[v[2]]));
    if (normals_.back() == Vec{}) flat_.push_back(t);
  }
}

// A triangle without area lies, as a set of points, on its longest edge: as a piece of the triangle behind
// that edge it leaves a ridge on its two other edges, where the ridge belongs.
FlatTriangle TopologyBuilder::Impl::flat_triangle(std::uint32_t triangle) const {
  const auto& v = s_.triangles[triangle];
  int longest = 0;
  std::array<double, 3> length2;
  for (int i = 0; i < 3; ++i) {
    length2[i] = norm2(mesh_.points[v[(i + 1) % 3]] - mesh_.points[v[(i + 2) % 3]]);
    if (length2[i] > length2[longest]) longest = i;
  }
  const std::uint32_t edge = s_.triangle_edges[triangle][longest];
  if (count_triangles(edge) != 2) return {triangle, kNone, 1, {}};
  const HalfEdge& a = halves_[edge_begin_[edge]];
  const HalfEdge& b = halves_[edge_begin_[edge] + 1];
  const std::uint32_t behind = a.triangle == triangle ? b.triangle : a.triangle;
  return {triangle, behind, same_direction(a, b) ? -1.0 : 1.0, normals_[behind]};
}

void TopologyBuilder::Impl::mark_listed(std::size_t edge, std::uint8_t flags) {
  const auto& e = mesh_.edges[edge];
  const std::array<std::uint32_t, 2> sorted{std::min(e[0], e[1]), std::max(e[0], e[1])};
  const auto found = std::lower_bound(s_.edges.begin(), s_.edges.end(), sorted);
  if (found == s_.edges.end() || *found != sorted) return;  // an edge inside the volume
  const auto i = static_cast<std::size_t>(found - s_.edges.begin());
  edge_flags_[i] |= flags;
  edge_ref_[i] = ref_at(mesh_.edge_refs, edge);
}

void TopologyBuilder::Impl::mark_features() {
  edge_ref_.assign(s_.edges.size(), 0);
  for (std::size_t i = 0; i < mesh_.edges.size(); ++i) mark_listed(i, kFeature);
  for (std::uint32_t i : mesh_.required_edges) mark_listed(i, kFeature | kRequired);
  for (std::uint32_t t : mesh_.required_triangles) {
    for (std::uint32_t e : s_.triangle_edges[t]) edge_flags_[e] |= kFeature | kRequired;
  }
  for (std::uint32_t e = 0; e < s_.edges.size(); ++e) {
    if (edge_flags_[e] & kBeyond)
      edge_flags_[e] = kBeyond;
    else if (!edge_flags_[e] && is_ridge(e))
      edge_flags_[e] = kFeature;
  }
}

bool TopologyBuilder::Impl::is_ridge(std::uint32_t edge) const {
  if (count_triangles(edge) != 2) return true;
  const HalfEdge& a = halves_[edge_begin_[edge]];
  const HalfEdge& b = halves_[edge_begin_[edge] + 1];
  const std::int32_t ref = ref_at(mesh_.triangle_refs, a.triangle);
  if (ref != ref_at(mesh_.triangle_refs, b.triangle)) return true;
  if (is_known(known_.triangle_refs, ref)) return false;
  const Vec &na = normals_[a.triangle], &nb = normals_[b.triangle];
  if (na == Vec{} || nb == Vec{}) return false;
  return (same_direction(a, b) ? -1 : 1) * dot(na, nb) < cos_ridge_;
}

void TopologyBuilder::Impl::link_neighbors() {
  s_.neighbors.assign(s_.triangles.size(), {kNone, kNone, kNone});
  for (std::uint32_t e = 0; e < s_.edges.size(); ++e) {
    if (edge_flags_[e]) continue;
    const HalfEdge& a = halves_[edge_begin_[e]];
    const HalfEdge& b = halves_[edge_begin_[e] + 1];
    s_.neighbors[a.triangle][a.local] = b.triangle;
    s_.neighbors[b.triangle][b.local] = a.triangle;
  }
}

void TopologyBuilder::Impl::form_components() {
  link_neighbors();
  components_.of_triangle.assign(s_.triangles.size(), kNone);
  components_.turned.assign(s_.triangles.size(), 0);
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t)
    if (is_own(t) && components_.of_triangle[t] == kNone) flood(t);
}

void TopologyBuilder::Impl::flood(std::uint32_t seed) {
  std::vector<std::uint32_t>& component = components_.of_triangle;
  std::vector<std::uint8_t>& turned = components_.turned;
  const std::uint32_t number = components_.count();
  components_.one_sided.push_back(0);
  queue_.assign(1, seed);
  component[seed] = number;
  for (std::size_t head = 0; head < queue_.size(); ++head) {
    const std::uint32_t t = queue_[head];
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t n = s_.neighbors[t][i];
      if (n == kNone || !is_own(n)) continue;
      const auto turn = static_cast<std::uint8_t>(turned[t] ^ turns_across(s_.triangle_edges[t][i]));
      if (component[n] == kNone) {
        component[n] = number;
        turned[n] = turn;
        queue_.push_back(n);
      } else if (turned[n] != turn) {
        components_.one_sided[number] = 1;
      }
    }
  }
}

bool TopologyBuilder::Impl::find_steps(std::vector<std::uint32_t>& steps) const {
  using Reached = std::pair<std::uint32_t, std::uint32_t>;  // steps, triangle
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  for (std::uint32_t t = 0; t < steps.size(); ++t)
    if (steps[t] != kNone) queue.emplace(steps[t], t);
  bool changed = false;
  while (!queue.empty()) {
    const auto [so_far, t] = queue.top();
    queue.pop();
    if (so_far > steps[t]) continue;
    for (const std::uint32_t n : s_.neighbors[t]) {
      if (n == kNone || !is_own(n) || steps[n] <= so_far + 1) continue;
      steps[n] = so_far + 1;
      queue.emplace(steps[n], n);
      changed = true;
    }
  }
  return changed;
}

bool TopologyBuilder::Impl::turn_along(std::span<const std::uint32_t> steps,
                                       std::vector<std::uint8_t>& turned) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;  // steps, triangle
  for (std::uint32_t t = 0; t < steps.size(); ++t)
    if (is_own(t) && steps[t] != kNone && turned[t] == kUnknownTurn) open.emplace_back(steps[t], t);
  std::ranges::sort(open);
  bool changed = false;
  for (const auto& [so_far, t] : open) {
    std::pair<std::uint32_t, std::uint32_t> from{kNone, kNone};  // triangle, edge
    for (std::size_t i = 0; i < 3; ++i)
      if (const std::uint32_t n = s_.neighbors[t][i]; n != kNone && steps[n] + 1 == so_far)
        from = std::min(from, std::pair{n, s_.triangle_edges[t][i]});
    if (turned[from.first] == kUnknownTurn) continue;
    turned[t] = static_cast<std::uint8_t>(turned[from.first] ^ turns_across(from.second));
    changed = true;
  }
  return changed;
}

void TopologyBuilder::Impl::cut_where_turned(std::span<const std::uint8_t> turned) {
  for (std::uint32_t e = 0; e < s_.edges.size(); ++e) {
    if (edge_flags_[e]) continue;
    const HalfEdge &a = halves_[edge_begin_[e]], &b = halves_[edge_begin_[e] + 1];
    if ((turned[a.triangle] ^ turned[b.triangle]) == turns_across(e)) continue;
    edge_flags_[e] = kFeature;
    s_.neighbors[a.triangle][a.local] = s_.neighbors[b.triangle][b.local] = kNone;
  }
}

void TopologyBuilder::Impl::turn_triangles(std::span<const std::uint8_t> turned) {
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    if (!turned[t]) continue;
    std::swap(s_.triangles[t][1], s_.triangles[t][2]);
    std::swap(s_.triangle_edges[t][1], s_.triangle_edges[t][2]);
    std::swap(s_.neighbors[t][1], s_.neighbors[t][2]);
    normals_[t] = -1.0 * normals_[t];
  }
}

void TopologyBuilder::Impl::list_features() {
  s_.edge_feature.assign(s_.edges.size(), kNone);
  s_.feature_triangle_begin.push_back(0);
  for (std::uint32_t e = 0; e < s_.edges.size(); ++e) {
    if (!(edge_flags_[e] & kFeature)) continue;
    const auto f = static_cast<std::uint32_t>(s_.features.size());
    s_.edge_feature[e] = f;
    s_.features.push_back({s_.edges[e], CurveId{}});
    s_.feature_edge.push_back(e);
    for (std::uint32_t h = edge_begin_[e]; h < edge_begin_[e + 1]; ++h) {
      s_.feature_triangle.push_back(halves_[h].triangle);
    }
    s_.feature_triangle_begin.push_back(static_cast<std::uint32_t>(s_.feature_triangle.size()));
    for (std::uint32_t v : s_.edges[e]) s_.vertex_features.emplace_back(v, f);
  }
  std::sort(s_.vertex_features.begin(), s_.vertex_features.end());
}

void TopologyBuilder::Impl::form_fans() {
  s_.triangle_fans.assign(s_.triangles.size(), {kNone, kNone, kNone});
  fan_count_.assign(mesh_.points.size(), 0);
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      if (s_.triangle_fans[t][i] == kNone && (own_vertex_.empty() || own_vertex_[s_.triangles[t][i]]))
        walk_fan(t, i);
    }
  }
  compute_fan_normals();
  find_peaks();
}

void TopologyBuilder::Impl::walk_fan(std::uint32_t triangle, int corner) {
  const std::uint32_t vertex = s_.triangles[triangle][corner];
  const auto id = static_cast<std::uint32_t>(s_.fans.size());
  Fan fan{vertex, kNone, {kNone, kNone}, {}, false};
  std::uint32_t t = triangle;
  int i = corner;
  // Back (clockwise) to the fan's beginning, or once around; then forward through all of it.
  for (std::uint32_t n; (n = s_.neighbors[t][(i + 2) % 3]) != kNone;) {
    t = n;
    i = corner_of(s_.triangles[t], vertex);
    if (t == triangle) break;
  }
  fan.first = t;
  fan.borders[0] = s_.edge_feature[s_.triangle_edges[t][(i + 2) % 3]];
  while (s_.triangle_fans[t][i] == kNone) {
    s_.triangle_fans[t][i] = id;
    const std::uint32_t n = s_.neighbors[t][(i + 1) % 3];
    if (n == kNone) {
      fan.borders[1] = s_.edge_feature[s_.triangle_edges[t][(i + 1) % 3]];
      break;
    }
    t = n;
    i = corner_of(s_.triangles[t], vertex);
  }
  s_.fans.push_back(fan);
  ++fan_count_[vertex];
}

// Nelson Max's weights (1999), sin / (product of the two edges): exact on a sphere, and on a cylinder whose
// facets are as long as it is, whatever their widths and diagonals.
void TopologyBuilder::Impl::compute_fan_normals() {
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    const auto& v = s_.triangles[t];
    for (int i = 0; i < 3; ++i) {
      const Vec a = mesh_.points[v[(i + 1) % 3]] - mesh_.points[v[i]];
      const Vec b = mesh_.points[v[(i + 2) % 3]] - mesh_.points[v[i]];
      const double weight = norm2(a) * norm2(b);
      if (weight > 0 && s_.triangle_fans[t][i] != kNone)
        s_.fans[s_.triangle_fans[t][i]].normal += (1 / weight) * cross(a, b);
    }
  }
  for (Fan& fan : s_.fans) {
    const double length = norm(fan.normal);
    fan.normal = length > 0 ? (1 / length) * fan.normal : Vec{};
  }
}

// A peak has normals further from their mean than a ridge's may be from each other; or by half of that, where
// the step from triangle to triangle is so small that the fan is a cone rather than a coarse sphere.
void TopologyBuilder::Impl::find_peaks() {
  std::vector<double> off(s_.fans.size(), 0), step(s_.fans.size(), 0);
  const auto angle = [](const Vec& a, const Vec& b) { return std::atan2(norm(cross(a, b)), dot(a, b)); };
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    if (normals_[t] == Vec{}) continue;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t f = s_.triangle_fans[t][i], n = s_.neighbors[t][(i + 1) % 3];
      if (f == kNone) continue;
      off[f] = std::max(off[f], angle(normals_[t], s_.fans[f].normal));
      if (n != kNone && normals_[n] != Vec{}) step[f] = std::max(step[f], angle(normals_[t], normals_[n]));
    }
  }
  for (std::size_t f = 0; f < s_.fans.size(); ++f) {
    const std::int32_t ref = s_.patch_refs[s_.triangle_patch[s_.fans[f].first].value];
    if (is_known(known_.triangle_refs, ref)) continue;
    s_.fans[f].peaked = off[f] > ridge_angle_ || (off[f] > 0.5 * ridge_angle_ && off[f] > 2 * step[f]);
  }
}

void TopologyBuilder::Impl::find_corners() {
  is_corner_.assign(mesh_.points.size(), 0);
  std::vector<std::uint8_t> on_feature(mesh_.points.size(), 0);
  for (std::size_t i = 0; i < s_.vertex_features.size();) {
    const std::uint32_t v = s_.vertex_features[i].first;
    std::size_t end = i;
    while (end < s_.vertex_features.size() && s_.vertex_features[end].first == v) ++end;
    on_feature[v] = 1;
    if (!is_own_vertex(v)) {
      i = end;
      continue;
    }
    if (end - i != 2 || chain_breaks(v, s_.vertex_features[i].second, s_.vertex_features[i + 1].second)) {
      is_corner_[v] = 1;
    }
    i = end;
  }
  for (const Fan& fan : s_.fans) {
    if (!on_feature[fan.vertex] && (fan.peaked || fan_count_[fan.vertex] > 1)) is_corner_[fan.vertex] = 1;
  }
  for (const auto* list : {&mesh_.corners, &mesh_.required_points, &known_.corners}) {
    for (std::uint32_t v : *list) is_corner_[v] = fan_count_[v] > 0;
  }
}

bool TopologyBuilder::Impl::chain_breaks(std::uint32_t vertex, std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t ea = s_.feature_edge[a], eb = s_.feature_edge[b];
  if (edge_ref_[ea] != edge_ref_[eb] || (edge_flags_[ea] & kRequired) != (edge_flags_[eb] & kRequired))
    return true;
  // Each triangle at the one edge must start a fan that ends at the other; else the surface is pinched here.
  if (count_triangles(ea) != fan_count_[vertex] || !same_patches(a, b)) return true;
  if (is_known(known_.edge_refs, edge_ref_[ea])) return false;
  const auto other = [&](std::uint32_t f) {
    const auto& e = s_.features[f].vertices;
    return mesh_.points[e[0] == vertex ? e[1] : e[0]];
  };
  const Vec in = mesh_.points[vertex] - other(a), out = other(b) - mesh_.points[vertex];
  return dot(in, out) < cos_ridge_ * norm(in) * norm(out);
}

bool TopologyBuilder::Impl::same_patches(std::uint32_t a, std::uint32_t b) const {
  const auto ta = s_.triangles_at(a), tb = s_.triangles_at(b);
  return std::is_permutation(
      ta.begin(), ta.end(), tb.begin(), tb.end(),
      [this](std::uint32_t x, std::uint32_t y) { return s_.triangle_patch[x] == s_.triangle_patch[y]; });
}

void TopologyBuilder::Impl::classify_vertices() {
  s_.vertex_kind.assign(mesh_.points.size(), VertexKind::interior);
  s_.vertex_hint.assign(mesh_.points.size(), kNone);
  const auto counts = [&](std::uint32_t v) { return own_vertex_.empty() || own_vertex_[v]; };
  for (std::uint32_t t = 0; t < s_.triangles.size(); ++t) {
    for (std::uint32_t v : s_.triangles[t]) {
      if (!counts(v)) continue;
      if (is_corner_[v]) s_.corner_triangles.emplace_back(v, t);
      s_.vertex_kind[v] = VertexKind::surface;
      s_.vertex_hint[v] = t;
    }
  }
  std::sort(s_.corner_triangles.begin(), s_.corner_triangles.end());
  for (const auto& [v, f] : s_.vertex_features) {
    if (!counts(v)) continue;
    s_.vertex_kind[v] = VertexKind::ridge;
    s_.vertex_hint[v] = f;
  }
  for (std::uint32_t v = 0; v < is_corner_.size(); ++v) {
    if (!is_corner_[v]) continue;
    s_.vertex_kind[v] = VertexKind::corner;
    s_.vertex_hint[v] = v;
  }
}

// ---- the steps

TopologyBuilder::TopologyBuilder(const MeshData& mesh, double ridge_angle_degrees, const KnownShapes& known,
                                 std::vector<std::uint8_t> rings, std::vector<std::uint32_t> vertex_numbers) {
  check_indices(mesh);
  impl_ = std::make_unique<Impl>(mesh, ridge_angle_degrees, known);
  impl_->s_.rings = std::move(rings);
  impl_->s_.vertex_numbers = std::move(vertex_numbers);
  impl_->collect_edges();
  impl_->find_complete_edges();
  impl_->find_own_vertices();
  impl_->compute_normals();
}
TopologyBuilder::~TopologyBuilder() = default;
TopologyBuilder::TopologyBuilder(TopologyBuilder&&) noexcept = default;

std::vector<FlatTriangle> TopologyBuilder::flat_triangles() const {
  std::vector<FlatTriangle> flat;
  for (const std::uint32_t t : impl_->flat_)
    if (impl_->is_own(t)) flat.push_back(impl_->flat_triangle(t));
  return flat;
}

void TopologyBuilder::take_normals(std::span<const FlatTriangle> normals) {
  for (const FlatTriangle& t : normals) impl_->normals_[t.triangle] = t.normal;
}

const SurfaceComponents& TopologyBuilder::components() {
  impl_->mark_features();
  impl_->form_components();
  return impl_->components_;
}

std::vector<SurfaceCrossing> TopologyBuilder::crossings() const {
  std::vector<SurfaceCrossing> all;
  const SurfaceTopology& s = impl_->s_;
  for (std::uint32_t t = 0; t < s.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3 && impl_->is_own(t); ++i) {
      const std::uint32_t n = s.neighbors[t][i];
      if (n == kNone || impl_->is_own(n)) continue;
      all.push_back({t, n, impl_->turns_across(s.triangle_edges[t][i]) != 0});
    }
  return all;
}

bool TopologyBuilder::find_steps(std::vector<std::uint32_t>& steps) const { return impl_->find_steps(steps); }

bool TopologyBuilder::turn_along(std::span<const std::uint32_t> steps,
                                 std::vector<std::uint8_t>& turned) const {
  return impl_->turn_along(steps, turned);
}

void TopologyBuilder::take_patches(std::vector<PatchId> of_triangle, std::vector<std::uint8_t> turned,
                                   std::vector<std::int32_t> refs) {
  impl_->components_ = {};
  impl_->s_.triangle_patch = std::move(of_triangle);
  impl_->s_.patch_refs = std::move(refs);
  impl_->cut_where_turned(turned);
  impl_->turn_triangles(turned);
  impl_->list_features();
  impl_->form_fans();
  impl_->find_corners();
}

std::vector<FoundFeature> TopologyBuilder::own_features() const {
  std::vector<FoundFeature> all;
  impl_->s_.for_each_own_feature([&](std::uint32_t f) {
    const auto& [a, b] = impl_->s_.features[f].vertices;
    const std::uint32_t edge = impl_->s_.feature_edge[f];
    all.push_back({{impl_->s_.vertex_number(a), impl_->s_.vertex_number(b)},
                   {impl_->mesh_.points[a], impl_->mesh_.points[b]},
                   impl_->edge_ref_[edge],
                   {impl_->is_corner_[a], impl_->is_corner_[b]},
                   (impl_->edge_flags_[edge] & kRequired) != 0});
  });
  return all;
}

void TopologyBuilder::classify_vertices() { impl_->classify_vertices(); }

void TopologyBuilder::take_curves(std::vector<FeatureOnCurve> of_features) {
  SurfaceTopology& s = impl_->s_;
  s.on_curve = std::move(of_features);
  for (std::size_t f = 0; f < s.features.size(); ++f) s.features[f].curve = s.on_curve[f].curve;
}

const SurfaceTopology& TopologyBuilder::so_far() const { return impl_->s_; }
SurfaceTopology TopologyBuilder::take() { return std::move(impl_->s_); }

void lend_normals(std::vector<FlatTriangle>& flat) {
  std::vector<Vec> found(flat.size());
  std::vector<std::size_t> open(flat.size());
  std::iota(open.begin(), open.end(), std::size_t{0});
  const auto normal_behind = [&](const FlatTriangle& t) {
    if (t.behind == kNone || t.normal != Vec{}) return t.normal;
    const auto at = std::ranges::lower_bound(flat, t.behind, {}, &FlatTriangle::triangle);
    return at != flat.end() && at->triangle == t.behind ? found[at - flat.begin()] : Vec{};
  };
  // Each pass gets one triangle further into a cluster of flat ones.
  for (int pass = 0; pass < 8 && !open.empty(); ++pass)
    std::erase_if(open, [&](std::size_t i) {
      const Vec n = normal_behind(flat[i]);
      if (n == Vec{}) return false;
      found[i] = flat[i].turn < 0 ? -1.0 * n : n;
      return true;
    });
  for (std::size_t i = 0; i < flat.size(); ++i) flat[i].normal = found[i];
}

namespace {

/// Of the components with one side.
void turn_one_sided(const TopologyBuilder& builder, const SurfaceComponents& all,
                    std::vector<std::uint8_t>& turned) {
  std::vector<std::uint32_t> steps(turned.size(), kNone);
  std::vector<std::uint8_t> begun = all.one_sided;
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (!all.one_sided[all.of_triangle[t]]) continue;
    turned[t] = kUnknownTurn;
    if (std::exchange(begun[all.of_triangle[t]], 0)) steps[t] = turned[t] = 0;
  }
  builder.find_steps(steps);
  builder.turn_along(steps, turned);
}

}  // namespace

void take_components_as_patches(const MeshData& mesh, TopologyBuilder& builder) {
  const SurfaceComponents& all = builder.components();
  std::vector<std::uint8_t> turned = all.turned;
  if (std::ranges::count(all.one_sided, 1) > 0) turn_one_sided(builder, all, turned);
  std::vector<std::int64_t> excess(all.count(), 0);  // turned triangles over those that are not
  std::vector<std::int32_t> refs(all.count());
  for (std::size_t t = all.of_triangle.size(); t-- > 0;) {
    excess[all.of_triangle[t]] += turned[t] ? 1 : -1;
    refs[all.of_triangle[t]] = ref_at(mesh.triangle_refs, t);
  }
  std::vector<PatchId> patches;
  for (std::size_t t = 0; t < turned.size(); ++t) {
    patches.emplace_back(all.of_triangle[t]);
    turned[t] ^= excess[all.of_triangle[t]] > 0;
  }
  builder.take_patches(std::move(patches), std::move(turned), std::move(refs));
}

}  // namespace weft::meshing
