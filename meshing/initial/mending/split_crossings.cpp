// Decisions by signs of the given doubles, new points in CGAL's exact kernel, pieces in each triangle's
// plane.
#include "meshing/initial/mending/split_crossings.h"

#include <algorithm>
#include <map>
#include <unordered_map>

#include "meshing/initial/grid/interrupted.h"
#include "meshing/initial/mending/exact_plane.h"
#include "meshing/mesh/predicates.h"

namespace weft::meshing {
namespace {

using Segment = std::array<std::uint32_t, 2>;
using Number = ExactKernel::FT;
using Point3 = ExactKernel::Point_3;
using Point2 = ExactKernel::Point_2;

/// Points known by their number; those at exactly one place are one.
class ExactPoints {
 public:
  explicit ExactPoints(std::span<const Point> given) : rounded(given.begin(), given.end()) {
    places_.reserve(given.size());
    for (std::uint32_t v = 0; v < given.size(); ++v) {
      places_.emplace_back(given[v].x, given[v].y, given[v].z);
      at_[key(given[v])].push_back(v);
    }
  }

  const Point3& operator[](std::uint32_t v) const { return places_[v]; }

  std::uint32_t find_or_add(const Point3& p) {
    const auto coordinate = [](const Number& x) { return CGAL::to_double(CGAL::exact(x)); };
    const Point r = {coordinate(p.x()), coordinate(p.y()), coordinate(p.z())};
    auto& here = at_[key(r)];
    for (const std::uint32_t v : here)
      if (places_[v] == p) return v;
    const auto v = static_cast<std::uint32_t>(places_.size());
    places_.push_back(p);
    rounded.push_back(r);
    here.push_back(v);
    return v;
  }

  std::vector<Point> rounded;

 private:
  static std::array<double, 3> key(const Point& p) { return {p.x + 0.0, p.y + 0.0, p.z + 0.0}; }

  std::vector<Point3> places_;
  std::map<std::array<double, 3>, std::vector<std::uint32_t>> at_;
};

/// Coordinates in a triangle's plane: two of the three, so that its corners turn in positive order.
struct Projection {
  int u = 0, v = 1;

  explicit Projection(const std::array<Point, 3>& t) {
    const Vec n = cross(t[1] - t[0], t[2] - t[0]);
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    // Ties and rounding: any axis along which the triangle does not vanish exactly will do.
    std::array<std::pair<double, int>, 3> axes = {{{x, 0}, {y, 1}, {z, 2}}};
    std::sort(axes.begin(), axes.end(), std::greater<>());
    for (const auto& [size, axis] : axes) {
      u = (axis + 1) % 3, v = (axis + 2) % 3;
      const int turn = sign(t);
      if (turn < 0) std::swap(u, v);
      if (turn != 0) return;
    }
  }

  Point2 operator()(const Point3& p) const { return {p[u], p[v]}; }

 private:
  int sign(const std::array<Point, 3>& t) const {
    const auto flat = [&](const Point& p) { return Point2(p[u], p[v]); };
    return static_cast<int>(CGAL::orientation(flat(t[0]), flat(t[1]), flat(t[2])));
  }
};

class Splitting {
 public:
  Splitting(std::span<const Point> points, std::span<const Triangle> triangles)
      : points_(points), triangles_(triangles), exact_(points) {}

  SplitTriangles run(std::span<const std::array<std::uint32_t, 2>> pairs,
                     const std::atomic<bool>* interrupt) {
    for (const auto& [s, t] : pairs) {
      check_interrupt(interrupt);
      meet(s, t);
    }
    SplitTriangles result;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      check_interrupt(interrupt);
      add_pieces(t, interrupt, result);
    }
    result.cuts = cuts();
    result.points = std::move(exact_.rounded);
    return result;
  }

 private:
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
  }
  std::array<Point, 3> places(const Triangle& t) const {
    return {points_[t[0]], points_[t[1]], points_[t[2]]};
  }
  int side(const Triangle& t, std::uint32_t v) const {
    return orientation(points_[t[0]], points_[t[1]], points_[t[2]], points_[v]);
  }

  // --- What two triangles have in common

  void meet(std::uint32_t s, std::uint32_t t) {
    const Triangle &a = triangles_[s], &b = triangles_[t];
    if (side(b, a[0]) == 0 && side(b, a[1]) == 0 && side(b, a[2]) == 0) {
      overlay(s, t);
      overlay(t, s);
      return;
    }
    std::vector<std::uint32_t> common;
    collect(a, t, common);
    collect(b, s, common);
    std::sort(common.begin(), common.end());
    common.erase(std::unique(common.begin(), common.end()), common.end());
    if (common.size() != 2) return;
    segments_[s].push_back({common[0], common[1]});
    segments_[t].push_back({common[0], common[1]});
  }

  /// Where the edges of a meet triangle t, which is not in a's plane.
  void collect(const Triangle& a, std::uint32_t t, std::vector<std::uint32_t>& common) {
    const Triangle& b = triangles_[t];
    std::array<int, 3> o{};
    for (std::size_t i = 0; i < 3; ++i) o[i] = side(b, a[i]);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      if (o[i] == 0 && o[j] == 0)
        clip(a[i], a[j], t, common);
      else if (o[i] * o[j] < 0)
        pierce(a[i], a[j], t, common);
      else if (o[i] == 0)
        touch(a[i], t, common);
    }
  }

  /// The edge's ends are on different sides of t's plane.
  void pierce(std::uint32_t p, std::uint32_t q, std::uint32_t t, std::vector<std::uint32_t>& common) {
    const Triangle& b = triangles_[t];
    std::array<int, 3> o{};
    for (std::size_t i = 0; i < 3; ++i)
      o[i] = orientation(points_[p], points_[q], points_[b[i]], points_[b[(i + 1) % 3]]);
    if (*std::min_element(o.begin(), o.end()) < 0 && *std::max_element(o.begin(), o.end()) > 0) return;
    std::uint32_t v = 0;
    const auto zeros = std::count(o.begin(), o.end(), 0);
    if (zeros >= 2) {  // through the corner between two edges
      const std::size_t i = o[0] == 0 && o[1] == 0 ? 1 : o[1] == 0 && o[2] == 0 ? 2 : 0;
      v = b[i];
    } else {
      v = exact_.find_or_add(on_line(p, q, t));
      put(v, t, o);
    }
    on_edge_[key(p, q)].push_back(v);
    common.push_back(v);
  }

  Point3 on_line(std::uint32_t p, std::uint32_t q, std::uint32_t t) const {
    const Triangle& b = triangles_[t];
    const Point3 &x = exact_[b[0]], &from = exact_[p], &to = exact_[q];
    const auto normal = CGAL::cross_product(exact_[b[1]] - x, exact_[b[2]] - x);
    const Number start = normal * (x - from), way = normal * (to - from);
    return from + (to - from) * (start / way);
  }

  /// v, in the plane of t and there on the sides o of its edges, becomes a vertex of t.
  void put(std::uint32_t v, std::uint32_t t, const std::array<int, 3>& o) {
    const Triangle& b = triangles_[t];
    const auto on = std::find(o.begin(), o.end(), 0);
    if (on == o.end()) {
      inside_[t].push_back(v);
      return;
    }
    const auto i = static_cast<std::size_t>(on - o.begin());
    on_edge_[key(b[i], b[(i + 1) % 3])].push_back(v);
  }

  /// A point of t's plane: whether it is in t, which it is a vertex of then.
  bool touch(std::uint32_t v, std::uint32_t t, std::vector<std::uint32_t>& common) {
    const Triangle& b = triangles_[t];
    if (std::find(b.begin(), b.end(), v) == b.end()) {
      const Projection flat(places(b));
      std::array<int, 3> o{};
      for (std::size_t i = 0; i < 3; ++i) {
        o[i] = static_cast<int>(
            CGAL::orientation(flat(exact_[b[i]]), flat(exact_[b[(i + 1) % 3]]), flat(exact_[v])));
        if (o[i] < 0) return false;
      }
      put(v, t, o);
    }
    common.push_back(v);
    return true;
  }

  /// The part of an edge in t's plane that is in t: its ends, of which some may be the edge's.
  void clip(std::uint32_t p, std::uint32_t q, std::uint32_t t, std::vector<std::uint32_t>& common) {
    const Triangle& b = triangles_[t];
    touch(p, t, common);
    touch(q, t, common);
    const Projection flat(places(b));
    const Point2 from = flat(exact_[p]), to = flat(exact_[q]);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t x = b[i], y = b[(i + 1) % 3];
      if (x == p || x == q) continue;
      const Point2 start = flat(exact_[x]), end = flat(exact_[y]);
      const int of_start = static_cast<int>(CGAL::orientation(from, to, start));
      if (of_start == 0) {  // a corner of t on the edge
        if (!CGAL::collinear_are_ordered_along_line(from, start, to)) continue;
        on_edge_[key(p, q)].push_back(x);
        common.push_back(x);
        continue;
      }
      if (y == p || y == q) continue;
      const int of_end = static_cast<int>(CGAL::orientation(from, to, end));
      const int of_from = static_cast<int>(CGAL::orientation(start, end, from));
      const int of_to = static_cast<int>(CGAL::orientation(start, end, to));
      if (of_start * of_end >= 0 || of_from * of_to >= 0) continue;
      const std::uint32_t v = exact_.find_or_add(crossing(p, q, start, end, flat));
      on_edge_[key(p, q)].push_back(v);
      on_edge_[key(x, y)].push_back(v);
      common.push_back(v);
    }
  }

  Point3 crossing(std::uint32_t p, std::uint32_t q, const Point2& start, const Point2& end,
                  const Projection& flat) const {
    const Point3 &from = exact_[p], &to = exact_[q];
    const auto area = [&](const Point3& x) { return CGAL::determinant(end - start, flat(x) - start); };
    const Number at_from = area(from), at_to = area(to);
    return from + (to - from) * (at_from / (at_from - at_to));
  }

  /// Edges of s on t, in one plane.
  void overlay(std::uint32_t s, std::uint32_t t) {
    const Triangle& a = triangles_[s];
    for (std::size_t i = 0; i < 3; ++i) {
      std::vector<std::uint32_t> common;
      clip(a[i], a[(i + 1) % 3], t, common);
      std::sort(common.begin(), common.end());
      common.erase(std::unique(common.begin(), common.end()), common.end());
      if (common.size() < 2) continue;
      // More than two: corners of t on the edge, too. In order along it, each piece is a segment.
      std::sort(common.begin(), common.end(),
                [&](std::uint32_t x, std::uint32_t y) { return nearer(exact_[a[i]], exact_[x], exact_[y]); });
      for (std::size_t k = 0; k + 1 < common.size(); ++k) segments_[t].push_back({common[k], common[k + 1]});
    }
  }

  static bool nearer(const Point3& from, const Point3& x, const Point3& y) {
    return CGAL::compare_distance_to_point(from, x, y) == CGAL::SMALLER;
  }

  EdgeCuts cuts() const {
    EdgeCuts all;
    for (const auto& [edge, found] : on_edge_) {
      std::vector<std::uint32_t> vertices = found;
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
      const Point3& from = exact_[static_cast<std::uint32_t>(edge >> 32)];
      std::sort(vertices.begin(), vertices.end(),
                [&](std::uint32_t x, std::uint32_t y) { return nearer(from, exact_[x], exact_[y]); });
      all.emplace(edge, std::move(vertices));
    }
    return all;
  }

  // --- Pieces

  void add_pieces(std::uint32_t t, const std::atomic<bool>* interrupt, SplitTriangles& result) {
    const Triangle& corners = triangles_[t];
    std::array<const std::vector<std::uint32_t>*, 3> on{};
    bool whole = !inside_.contains(t) && !segments_.contains(t);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = on_edge_.find(key(corners[i], corners[(i + 1) % 3]));
      if (at == on_edge_.end()) continue;
      on[i] = &at->second;
      whole = false;
    }
    if (whole) {
      result.triangles.push_back(corners);
      result.parent.push_back(t);
      return;
    }
    const Projection flat(places(corners));
    PlaneTriangulation plane(corners,
                             {flat(exact_[corners[0]]), flat(exact_[corners[1]]), flat(exact_[corners[2]])});
    const auto insert = [&](std::uint32_t v) {
      check_interrupt(interrupt);
      plane.insert(v, flat(exact_[v]));
    };
    for (const auto* edge : on)
      if (edge)
        for (const std::uint32_t v : *edge) insert(v);
    for (const std::uint32_t v : inside_[t]) insert(v);
    for (const Segment& s : segments_[t]) {
      check_interrupt(interrupt);
      plane.insert_segment(s[0], s[1], [&](auto a, auto b, auto c, auto d, Point2& where) {
        const std::uint32_t v = exact_.find_or_add(crossing(a, b, flat(exact_[c]), flat(exact_[d]), flat));
        where = flat(exact_[v]);
        return v;
      });
    }
    for (const Triangle& piece : plane.faces()) {
      result.triangles.push_back(piece);
      result.parent.push_back(t);
    }
  }

  std::span<const Point> points_;
  std::span<const Triangle> triangles_;
  ExactPoints exact_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> on_edge_;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> inside_;
  std::unordered_map<std::uint32_t, std::vector<Segment>> segments_;
};

}  // namespace

SplitTriangles split_crossings(std::span<const Point> points, std::span<const Triangle> triangles,
                               std::span<const std::array<std::uint32_t, 2>> pairs,
                               const std::atomic<bool>* interrupt) {
  return Splitting(points, triangles).run(pairs, interrupt);
}

}  // namespace weft::meshing
