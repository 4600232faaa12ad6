// Pieces by hints first; what is left is compared with the faces' boxes.
#include "partition/subdomain/surface_cover.h"

#include <algorithm>
#include <span>

#include "meshing/mesh/tet_tables.h"

namespace weft::partition {

using meshing::Box;
using meshing::Point;

namespace {

bool meet(const Box& a, const Box& b) {
  for (int i = 0; i < 3; ++i)
    if (a.lo[i] > b.hi[i] || b.lo[i] > a.hi[i]) return false;
  return true;
}

/// A piece's box may be large where the curve that pieces follow jumps: what is in it is looked at.
bool has_any_near(const meshing::SurfacePiece& piece, std::span<const Box> near) {
  std::vector<Box> boxes;
  for (const Box& box : near)
    if (meet(piece.box, box)) boxes.push_back(box);
  if (boxes.empty()) return false;
  const auto is_near = [&](const auto& thing) {
    const Box its = thing.box();
    return std::ranges::any_of(boxes, [&](const Box& box) { return meet(its, box); });
  };
  return std::ranges::any_of(piece.triangles, is_near) || std::ranges::any_of(piece.features, is_near);
}

}  // namespace

void SurfaceCover::add(const Vertex& v) {
  if (v.hint == meshing::kNoName) return;
  if (const std::uint32_t id = meshing::piece_of_name(v.hint); ids_.empty() || ids_.back() != id)
    ids_.push_back(id);
}

void SurfaceCover::add_face(const Vertex& a, const Vertex& b, const Vertex& c) {
  Box box;
  for (const Vertex* v : {&a, &b, &c}) {
    if (v->hint == meshing::kNoName) return;
    box.include(v->x);
  }
  const double radius = 0.5 * norm(box.size());
  const Point around{radius, radius, radius};
  near_.push_back({box.lo - around, box.hi + around});
}

std::vector<meshing::SurfacePieces::Piece> SurfaceCover::pieces() const {
  std::vector<std::uint32_t> ids = ids_;
  std::ranges::sort(ids);
  Box all;
  for (const Box& box : near_) {
    all.include(box.lo);
    all.include(box.hi);
  }
  std::vector<meshing::SurfacePieces::Piece> pieces;
  for (const auto& piece : there_.all())
    if (std::ranges::binary_search(ids, piece->id) || (meet(piece->box, all) && has_any_near(*piece, near_)))
      pieces.push_back(piece);
  return pieces;
}

void drop_far_surface(Subdomain& s) {
  if (s.surface.all().empty()) return;
  const meshing::TetMesh& mesh = *s.mesh;
  SurfaceCover cover(s.surface);
  const auto at = [&](meshing::VertexId v) {
    return SurfaceCover::Vertex{mesh.point(v), mesh.surface_hint(v)};
  };
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (const meshing::VertexId v(i); mesh.alive(v)) cover.add(at(v));
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const meshing::TetId t(i);
    if (!mesh.alive(t)) continue;
    for (int f = 0; f < 4; ++f) {
      if (!mesh.patch(t, f).valid()) continue;
      const auto& face = meshing::kTetFaces[f];
      cover.add_face(at(mesh.vertex(t, face[0])), at(mesh.vertex(t, face[1])), at(mesh.vertex(t, face[2])));
    }
  }
  meshing::SurfacePieces near;
  near.add(cover.pieces());
  s.surface = std::move(near);
}

void SharedSurface::share(meshing::SurfacePieces& pieces) {
  std::vector<meshing::SurfacePieces::Piece> shared(pieces.all().begin(), pieces.all().end());
  {
    const std::lock_guard lock(mutex_);
    for (meshing::SurfacePieces::Piece& piece : shared) {
      std::weak_ptr<const meshing::SurfacePiece>& known = known_[piece->id];
      if (auto there = known.lock())
        piece = std::move(there);
      else
        known = piece;
    }
  }
  pieces = {};
  pieces.add(shared);
}

void cover_surface(SubdomainStart& start, const meshing::SurfacePieces& whole) {
  if (whole.all().empty()) return;
  SurfaceCover cover(whole);
  const auto at = [&](std::uint32_t v) {
    return SurfaceCover::Vertex{start.points[v], start.surface_hints[v]};
  };
  for (std::uint32_t v = 0; v < start.points.size(); ++v) cover.add(at(v));
  for (const auto& b : start.boundary_faces) {
    const auto& tet = start.tets[b.tet];
    const auto& face = meshing::kTetFaces[b.face];
    cover.add_face(at(tet[face[0]]), at(tet[face[1]]), at(tet[face[2]]));
  }
  start.surface = cover.pieces();
}

}  // namespace weft::partition
