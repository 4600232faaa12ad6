// Cuts the smaller tet at the faces of the larger one, and the rest into tets from one corner.
#include "meshing/fields/tet_overlap.h"

#include <algorithm>
#include <bit>

namespace weft::meshing {
namespace {

using BarycentricCorners = std::array<std::array<double, 4>, 4>;

std::array<double, 4> barycentric(const std::array<Point, 4>& tet, double inverse_six_volume,
                                  const Point& p) {
  const Vec u = tet[1] - tet[0], v = tet[2] - tet[0], w = tet[3] - tet[0], q = p - tet[0];
  const Vec uq = cross(u, q);
  const double l1 = dot(q, cross(v, w)) * inverse_six_volume, l2 = dot(uq, w) * inverse_six_volume,
               l3 = -dot(uq, v) * inverse_six_volume;
  return {1 - l1 - l2 - l3, l1, l2, l3};
}

bool beyond_a_face(const BarycentricCorners& corners) {
  for (std::size_t k = 0; k < 4; ++k)
    if (std::ranges::all_of(corners, [k](const auto& c) { return c[k] <= 0; })) return true;
  return false;
}

/// The volume of a tet by that of the tet whose coordinates its corners have.
double share_of_volume(const std::array<double, 4>& a, const std::array<double, 4>& b,
                       const std::array<double, 4>& c, const std::array<double, 4>& d) {
  const auto from_a = [&](const std::array<double, 4>& x) {
    return Vec{x[1] - a[1], x[2] - a[2], x[3] - a[3]};
  };
  return dot(from_a(b), cross(from_a(c), from_a(d)));
}

}  // namespace

bool TetOverlap::find(const std::array<Point, 4>& first, const std::array<Point, 4>& second) {
  const double v1 = six_volume(first[0], first[1], first[2], first[3]) / 6,
               v2 = six_volume(second[0], second[1], second[2], second[3]) / 6;
  // Seen from the larger one the smaller one's coordinates are moderate, and often it lies wholly inside.
  const bool first_is_cut = v1 <= v2;
  const auto &tet = first_is_cut ? first : second, &cutter = first_is_cut ? second : first;
  const Coordinates own = first_is_cut ? &Corner::in_first : &Corner::in_second;
  const Coordinates cutting = first_is_cut ? &Corner::in_second : &Corner::in_first;
  BarycentricCorners corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = barycentric(cutter, 1 / (6 * std::max(v1, v2)), tet[i]);
  size_ = num_pieces_ = 0;
  volume_ = 0;
  if (beyond_a_face(corners)) return false;
  start(own, cutting, corners);
  for (std::size_t k = 0; k < 4 && size_ > 0; ++k) cut(cutting, k);
  divide(own, std::min(v1, v2));
  return volume_ > 0;
}

bool TetOverlap::reaches_face_of_second(std::size_t k) const {
  // Where a face is cut, and at corners of the second tet, coordinates are exactly 0 on it.
  return std::ranges::count_if(corners(), [k](const Corner& c) { return c.in_second[k] == 0; }) >= 3;
}

void TetOverlap::start(Coordinates own, Coordinates cutting, const BarycentricCorners& corners) {
  size_ = 4;
  for (std::size_t i = 0; i < 4; ++i) {
    corners_[i].*own = {};
    (corners_[i].*own)[i] = 1;
    corners_[i].*cutting = corners[i];
  }
  neighbours_[0] = {1, 2, 3};
  neighbours_[1] = {0, 3, 2};
  neighbours_[2] = {0, 1, 3};
  neighbours_[3] = {0, 2, 1};
}

/// Keeps what is on the inner side of face k of the cutting tet.
void TetOverlap::cut(Coordinates cutting, std::size_t k) {
  std::uint64_t kept = 0;
  for (std::size_t i = 0; i < size_; ++i) kept |= std::uint64_t{(corners_[i].*cutting)[k] > 0} << i;
  const std::uint64_t all = (std::uint64_t{1} << size_) - 1;
  if (kept == all) return;
  const std::size_t first_new = size_;
  cut_edges(cutting, k, kept);
  if (close_faces(first_new))
    drop(all & ~kept);
  else
    size_ = 0;
}

/// A corner on each edge between one that is kept and one that is not, where the face cuts it; its first
/// neighbour is the kept one.
void TetOverlap::cut_edges(Coordinates cutting, std::size_t k, std::uint64_t kept) {
  std::size_t end = size_;
  for (std::uint64_t rest = kept; rest != 0; rest &= rest - 1) {
    const auto a = static_cast<std::size_t>(std::countr_zero(rest));
    for (std::uint8_t& b : neighbours_[a]) {
      if ((kept >> b & 1) != 0) continue;
      const Corner &from = corners_[a], &to = corners_[b];
      const double s = (from.*cutting)[k] / ((from.*cutting)[k] - (to.*cutting)[k]);
      Corner& corner = corners_[end];
      for (std::size_t i = 0; i < 4; ++i) {
        corner.in_first[i] = (1 - s) * from.in_first[i] + s * to.in_first[i];
        corner.in_second[i] = (1 - s) * from.in_second[i] + s * to.in_second[i];
      }
      (corner.*cutting)[k] = 0;
      neighbours_[end] = {static_cast<std::uint8_t>(a), 0, 0};
      b = static_cast<std::uint8_t>(end++);
    }
  }
  size_ = end;
}

/// Which neighbour of `at` is `from`. The next one is the next corner of the face on that side of the way.
std::size_t TetOverlap::side_of(std::size_t from, std::size_t at) const {
  const auto& n = neighbours_[at];
  return n[0] == from ? 0 : n[1] == from ? 1 : 2;
}

/// Joins the two new corners of each face that was cut. False where there are none, as rounding has left no
/// polytope.
bool TetOverlap::close_faces(std::size_t first_new) {
  for (std::size_t i = first_new; i < size_; ++i) {
    std::size_t before = i, at = neighbours_[i][0], steps = 0;
    while (at < first_new && ++steps < kMostCorners) {
      const std::size_t next = neighbours_[at][(side_of(before, at) + 1) % 3];
      before = at;
      at = next;
    }
    if (at < first_new) return false;
    neighbours_[i][2] = static_cast<std::uint8_t>(at);
    neighbours_[at][1] = static_cast<std::uint8_t>(i);
  }
  return true;
}

void TetOverlap::drop(std::uint64_t dropped) {
  std::array<std::uint8_t, 2 * kMostCorners> to;
  std::size_t end = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    if (i < 64 && (dropped >> i & 1) != 0) continue;
    to[i] = static_cast<std::uint8_t>(end);
    corners_[end] = corners_[i];
    neighbours_[end++] = neighbours_[i];
  }
  size_ = end;
  for (std::size_t i = 0; i < size_; ++i)
    for (std::uint8_t& n : neighbours_[i]) n = to[n];
}

/// Faces that do not have corner 0 are cut into triangles, which make tets with it.
void TetOverlap::divide(Coordinates own, double volume) {
  std::array<std::uint8_t, kMostCorners> seen{};  // bit j of a corner: a face came from its neighbour j
  std::array<std::uint8_t, 3 * kMostCorners> face;
  for (std::size_t i = 1; i < size_; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      std::size_t length = 0, at = i, side = j;
      bool has_apex = false;
      while ((seen[at] >> side & 1) == 0) {
        seen[at] |= static_cast<std::uint8_t>(1u << side);
        has_apex |= at == 0;
        face[length++] = static_cast<std::uint8_t>(at);
        const std::size_t next = neighbours_[at][(side + 1) % 3];
        side = side_of(at, next);
        at = next;
      }
      for (std::size_t m = 2; m < length && !has_apex; ++m)
        add_piece({0, face[0], face[m - 1], face[m]}, own, volume);
    }
}

void TetOverlap::add_piece(const std::array<std::uint8_t, 4>& corners, Coordinates own, double volume) {
  const auto at = [&](std::size_t i) -> const auto& { return corners_[corners[i]].*own; };
  const double part = volume * share_of_volume(at(0), at(1), at(2), at(3));
  pieces_[num_pieces_++] = {corners, part};
  volume_ += part;
}

}  // namespace weft::meshing
