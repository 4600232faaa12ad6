// Pieces by hints first; what is left is compared with the faces' boxes.
#include "partition/subdomain/surface_cover.h"

#include <algorithm>
#include <span>

#include "meshing/base/sort_unique.h"
#include "meshing/mesh/tet_tables.h"

namespace weft::partition {

using meshing::Box;
using meshing::Point;

namespace {

/// A piece's box may be large where the curve that pieces follow jumps: what is in it is looked at.
bool has_any_near(const meshing::SurfacePiece& piece, std::span<const Box> near) {
  std::vector<Box> boxes;
  for (const Box& box : near)
    if (piece.box.meets(box)) boxes.push_back(box);
  if (boxes.empty()) return false;
  const auto is_near = [&](const Box& its) {
    return std::ranges::any_of(boxes, [&](const Box& box) { return its.meets(box); });
  };
  for (std::size_t i = 0; i < piece.triangles.size(); ++i)
    if (is_near(piece.triangle(i).box())) return true;
  return std::ranges::any_of(piece.features, is_near, &meshing::SurfaceFeature::box);
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

void SurfaceCover::finish() {
  meshing::sort_unique(ids_);
  for (const Box& box : near_) all_near_.unite(box);
}

bool SurfaceCover::wants(const meshing::SurfacePiece& piece) const {
  return std::ranges::binary_search(ids_, piece.id) ||
         (piece.box.meets(all_near_) && has_any_near(piece, near_));
}

bool SurfaceCover::may_want(std::uint32_t id, const Box& box) const {
  return std::ranges::binary_search(ids_, id) ||
         (box.meets(all_near_) && std::ranges::any_of(near_, [&](const Box& n) { return n.meets(box); }));
}

std::vector<meshing::SurfacePieces::Piece> SurfaceCover::pieces(const meshing::SurfacePieces& there) const {
  std::vector<meshing::SurfacePieces::Piece> wanted;
  for (const auto& piece : there.all())
    if (wants(*piece)) wanted.push_back(piece);
  return wanted;
}

void drop_far_surface(Subdomain& s) {
  if (s.surface.all().empty()) return;
  const meshing::TetMesh& mesh = *s.mesh;
  SurfaceCover cover;
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
  cover.finish();
  meshing::SurfacePieces near;
  near.add(cover.pieces(s.surface));
  s.surface = std::move(near);
}

void share_surface(meshing::SurfacePieces& pieces, SharedPieces<meshing::SurfacePiece>& of_rank) {
  std::vector<meshing::SurfacePieces::Piece> shared(pieces.all().begin(), pieces.all().end());
  if (!of_rank.share(shared)) return;
  pieces = {};
  pieces.add(shared);
}

SurfaceCover cover_of(const SubdomainStart& start) {
  SurfaceCover cover;
  const auto at = [&](std::uint32_t v) {
    return SurfaceCover::Vertex{start.points[v], start.surface_hints[v]};
  };
  for (std::uint32_t v = 0; v < start.points.size(); ++v) cover.add(at(v));
  for (const auto& b : start.boundary_faces) {
    const auto& tet = start.tets[b.tet];
    const auto& face = meshing::kTetFaces[b.face];
    cover.add_face(at(tet[face[0]]), at(tet[face[1]]), at(tet[face[2]]));
  }
  cover.finish();
  return cover;
}

}  // namespace weft::partition
