// Clips the smaller tet at the four faces of the larger one, each cut leaving up to three tets.
#include "meshing/fields/tet_overlap.h"

#include <algorithm>
#include <utility>

namespace weft::meshing {
namespace {

using Corner = OverlapPiece::Corner;
using Coordinates = std::array<double, 4>;
/// Which of a corner's coordinates belong to the tet that cuts.
using Cutting = Coordinates Corner::*;

/// The point a share `s` of the way from `a`, where coordinate k is positive, to `b`, where it is not: on the
/// face k.
Corner cut_point(const Corner& a, const Corner& b, double s, Cutting cutting, std::size_t k) {
  Corner p;
  for (std::size_t i = 0; i < 4; ++i) {
    p.in_first[i] = (1 - s) * a.in_first[i] + s * b.in_first[i];
    p.in_second[i] = (1 - s) * a.in_second[i] + s * b.in_second[i];
  }
  (p.*cutting)[k] = 0;
  return p;
}

/// One tet and one face of the cutting tet, corners sorted so that the `inside` first ones are on its inner
/// side.
class Cut {
 public:
  Cut(OverlapPiece tet, Cutting cutting, std::size_t k, std::vector<OverlapPiece>& pieces)
      : tet_(tet), cutting_(cutting), k_(k), pieces_(pieces) {
    auto& c = tet_.corners;
    inside_ = static_cast<std::size_t>(
        std::partition(c.begin(), c.end(), [&](const Corner& x) { return (x.*cutting)[k] > 0; }) - c.begin());
  }

  void keep_inner_part() const {
    if (inside_ == 1) keep_corner();
    if (inside_ == 2) keep_edge();
    if (inside_ == 3) keep_face();
    if (inside_ == 4) pieces_.push_back(tet_);
  }

 private:
  double at(std::size_t i) const { return (tet_.corners[i].*cutting_)[k_]; }
  /// How far along edge a-b, from its inner end a, the face is; and the rest of the way, without
  /// cancellation.
  double way(std::size_t a, std::size_t b) const { return at(a) / (at(a) - at(b)); }
  double rest(std::size_t a, std::size_t b) const { return -at(b) / (at(a) - at(b)); }
  Corner point(std::size_t a, std::size_t b) const {
    return cut_point(tet_.corners[a], tet_.corners[b], way(a, b), cutting_, k_);
  }
  void add(const Corner& a, const Corner& b, const Corner& c, const Corner& d, double share) const {
    if (share > 0) pieces_.push_back({{a, b, c, d}, share * tet_.volume});
  }

  void keep_corner() const {
    add(tet_.corners[0], point(0, 1), point(0, 2), point(0, 3), way(0, 1) * way(0, 2) * way(0, 3));
  }
  /// The prism between the cuts at both inner corners.
  void keep_edge() const {
    const Corner &p = tet_.corners[0], &q = tet_.corners[1];
    const Corner pr = point(0, 2), ps = point(0, 3), qr = point(1, 2), qs = point(1, 3);
    add(p, pr, ps, q, way(0, 2) * way(0, 3));
    add(pr, ps, q, qr, way(1, 2) * rest(0, 2) * way(0, 3));
    add(ps, q, qr, qs, way(1, 2) * way(1, 3) * rest(0, 3));
  }
  /// The prism between the inner face and the cut below the outer corner.
  void keep_face() const {
    const auto& [p, q, r, s] = tet_.corners;
    const Corner ps = point(0, 3), qs = point(1, 3), rs = point(2, 3);
    add(p, q, r, ps, way(0, 3));
    add(q, r, ps, qs, way(1, 3) * rest(0, 3));
    add(r, ps, qs, rs, way(2, 3) * rest(0, 3) * rest(1, 3));
  }

  OverlapPiece tet_;
  Cutting cutting_;
  std::size_t k_, inside_;
  std::vector<OverlapPiece>& pieces_;
};

Coordinates barycentric(const std::array<Point, 4>& tet, double inverse_six_volume, const Point& p) {
  const Vec u = tet[1] - tet[0], v = tet[2] - tet[0], w = tet[3] - tet[0], q = p - tet[0];
  const Vec uq = cross(u, q);
  Coordinates l;
  l[1] = dot(q, cross(v, w)) * inverse_six_volume;
  l[2] = dot(uq, w) * inverse_six_volume;
  l[3] = -dot(uq, v) * inverse_six_volume;
  l[0] = 1 - l[1] - l[2] - l[3];
  return l;
}

bool beyond_a_face(const std::array<Coordinates, 4>& corners) {
  for (std::size_t k = 0; k < 4; ++k)
    if (std::ranges::all_of(corners, [k](const Coordinates& c) { return c[k] <= 0; })) return true;
  return false;
}

/// Clips `tet` by all faces of `cutter`; `own` and `cutting` say which coordinates are whose.
void clip(const std::array<Point, 4>& tet, double volume, const std::array<Point, 4>& cutter,
          double cutter_volume, Cutting own, Cutting cutting, std::vector<OverlapPiece>& pieces) {
  std::array<Coordinates, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = barycentric(cutter, 1 / (6 * cutter_volume), tet[i]);
  if (beyond_a_face(corners)) return;
  OverlapPiece whole;
  for (std::size_t i = 0; i < 4; ++i) {
    whole.corners[i].*own = {};
    (whole.corners[i].*own)[i] = 1;
    whole.corners[i].*cutting = corners[i];
  }
  whole.volume = volume;
  const std::size_t first = pieces.size();
  pieces.push_back(whole);
  for (std::size_t k = 0; k < 4; ++k) {
    // A face that has all of the tet on its inner side cuts none of its parts, which are convex combinations.
    if (std::ranges::all_of(corners, [k](const Coordinates& c) { return c[k] > 0; })) continue;
    // The pieces of the last cut move to the end, cut again, and then take their places.
    const std::size_t last = pieces.size();
    for (std::size_t i = first; i < last; ++i) Cut(pieces[i], cutting, k, pieces).keep_inner_part();
    pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(first),
                 pieces.begin() + static_cast<std::ptrdiff_t>(last));
  }
}

}  // namespace

void overlap(const std::array<Point, 4>& first, const std::array<Point, 4>& second,
             std::vector<OverlapPiece>& pieces) {
  const double v1 = six_volume(first[0], first[1], first[2], first[3]) / 6,
               v2 = six_volume(second[0], second[1], second[2], second[3]) / 6;
  // Seen from the larger one the smaller one's coordinates are moderate, and often it lies wholly inside.
  if (v1 <= v2)
    clip(first, v1, second, v2, &Corner::in_first, &Corner::in_second, pieces);
  else
    clip(second, v2, first, v1, &Corner::in_second, &Corner::in_first, pieces);
}

}  // namespace weft::meshing
