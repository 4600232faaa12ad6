// Cuts the smaller tet at the faces of the larger one, and the rest into tets from one corner.
#include "meshing/fields/tet_overlap.h"

#include <algorithm>
#include <bit>

namespace weft::meshing {
namespace {

using BarycentricCorners = std::array<std::array<double, 4>, 4>;

std::size_t lowest(std::uint64_t bits) { return static_cast<std::size_t>(std::countr_zero(bits)); }

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
double share_of_volume(const double* a, const double* b, const double* c, const double* d) {
  const auto from_a = [&](const double* x) { return Vec{x[1] - a[1], x[2] - a[2], x[3] - a[3]}; };
  return dot(from_a(b), cross(from_a(c), from_a(d)));
}

}  // namespace

bool TetOverlap::find(const std::array<Point, 4>& first, const std::array<Point, 4>& second) {
  const double v1 = six_volume(first[0], first[1], first[2], first[3]) / 6,
               v2 = six_volume(second[0], second[1], second[2], second[3]) / 6;
  // Seen from the larger one the smaller one's coordinates are moderate, and often it lies wholly inside.
  const bool first_is_cut = v1 <= v2;
  const auto &tet = first_is_cut ? first : second, &cutter = first_is_cut ? second : first;
  const std::size_t own = first_is_cut ? 0 : 4, cutting = 4 - own;
  BarycentricCorners corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = barycentric(cutter, 1 / (6 * std::max(v1, v2)), tet[i]);
  num_pieces_ = 0;
  volume_ = 0;
  if (beyond_a_face(corners)) return false;
  start(own, cutting, corners);
  for (std::size_t k = 0; k < 4; ++k) cut(cutting, k);
  divide(own, std::min(v1, v2));
  return volume_ > 0;
}

unsigned TetOverlap::faces_of_second() const {
  // Where a face is cut, and at corners of the second tet, coordinates are exactly 0 on it.
  std::array<int, 4> on{};
  for_each_corner([&](std::size_t, const Corner& corner) {
    for (std::size_t k = 0; k < 4; ++k) on[k] += corner.in_second()[k] == 0;
  });
  unsigned faces = 0;
  for (std::size_t k = 0; k < 4; ++k) faces |= unsigned{on[k] >= 3} << k;
  return faces;
}

TetOverlap::HalfEdge TetOverlap::next_on_face(HalfEdge e) const {
  const HalfEdge back = opposite_[e];
  return static_cast<HalfEdge>((back & 3) == 2 ? back - 2 : back + 1);
}

void TetOverlap::join(HalfEdge a, HalfEdge b) {
  opposite_[a] = b;
  opposite_[b] = a;
}

void TetOverlap::start(std::size_t own, std::size_t cutting, const BarycentricCorners& corners) {
  alive_ = 0b1111;
  for (std::size_t i = 0; i < 4; ++i) {
    corners_[i].both = {};
    corners_[i].both[own + i] = 1;
    std::ranges::copy(corners[i], corners_[i].both.begin() + static_cast<std::ptrdiff_t>(cutting));
  }
  // About the corners, in turn: 1 2 3, 0 3 2, 0 1 3, 0 2 1.
  join(half_edge(0, 0), half_edge(1, 0));
  join(half_edge(0, 1), half_edge(2, 0));
  join(half_edge(0, 2), half_edge(3, 0));
  join(half_edge(1, 1), half_edge(3, 2));
  join(half_edge(1, 2), half_edge(2, 1));
  join(half_edge(2, 2), half_edge(3, 1));
}

/// Keeps what is on the inner side of face k of the cutting tet.
void TetOverlap::cut(std::size_t cutting, std::size_t k) {
  std::uint64_t kept = 0;
  for_each_corner([&](std::size_t place, const Corner& corner) {
    kept |= std::uint64_t{corner.both[cutting + k] > 0} << place;
  });
  if (kept == alive_) return;
  const std::uint64_t created = cut_edges(cutting, k, kept);
  close_faces(created);
  alive_ = kept | created;
}

/// Makes a corner on each edge between one that is kept and one that is not, where the face cuts it: its
/// half-edge 0 leads to the one that is kept. Returns the new ones.
std::uint64_t TetOverlap::cut_edges(std::size_t cutting, std::size_t k, std::uint64_t kept) {
  std::uint64_t created = 0;
  for (std::uint64_t rest = kept; rest != 0; rest &= rest - 1) {
    const std::size_t a = lowest(rest);
    for (std::size_t side = 0; side < 3; ++side) {
      const std::size_t b = origin(opposite_[half_edge(a, side)]);
      if (((kept | created) >> b & 1) != 0) continue;
      const Corner from = corners_[a], to = corners_[b];  // copies: all lanes at once
      const double s = from.both[cutting + k] / (from.both[cutting + k] - to.both[cutting + k]);
      const std::size_t place = lowest(~(alive_ | created));
      Corner corner;
      for (std::size_t i = 0; i < 8; ++i) corner.both[i] = (1 - s) * from.both[i] + s * to.both[i];
      corner.both[cutting + k] = 0;
      corners_[place] = corner;
      join(half_edge(place, 0), half_edge(a, side));
      created |= std::uint64_t{1} << place;
    }
  }
  return created;
}

/// Joins the two new corners of each face that was cut.
void TetOverlap::close_faces(std::uint64_t created) {
  for (std::uint64_t rest = created; rest != 0; rest &= rest - 1) {
    const std::size_t i = lowest(rest);
    HalfEdge e = half_edge(i, 0);
    while ((created >> origin(opposite_[e]) & 1) == 0) e = next_on_face(e);
    join(half_edge(i, 2), half_edge(origin(opposite_[e]), 1));
  }
}

/// Faces without the first corner are cut into triangles, which make tets with it.
void TetOverlap::divide(std::size_t own, double volume) {
  if (alive_ == 0) return;
  const auto apex = static_cast<std::uint8_t>(lowest(alive_));
  std::array<std::uint8_t, kPlaces> seen{};  // bit s of a corner: its half-edge s
  std::array<std::uint8_t, 4 * kPlaces> face;
  for (std::uint64_t rest = alive_; rest != 0; rest &= rest - 1)
    for (std::size_t side = 0; side < 3; ++side) {
      std::size_t length = 0;
      bool has_apex = false;
      for (HalfEdge e = half_edge(lowest(rest), side); (seen[origin(e)] >> (e & 3) & 1) == 0;
           e = next_on_face(e)) {
        seen[origin(e)] |= static_cast<std::uint8_t>(1u << (e & 3));
        has_apex |= origin(e) == apex;
        face[length++] = static_cast<std::uint8_t>(origin(e));
      }
      for (std::size_t m = 2; m < length && !has_apex; ++m)
        add_piece({apex, face[0], face[m - 1], face[m]}, own, volume);
    }
}

void TetOverlap::add_piece(const std::array<std::uint8_t, 4>& corners, std::size_t own, double volume) {
  const auto at = [&](std::size_t i) { return &corners_[corners[i]].both[own]; };
  const double part = volume * share_of_volume(at(0), at(1), at(2), at(3));
  pieces_[num_pieces_++] = {corners, part};
  volume_ += part;
}

}  // namespace weft::meshing
