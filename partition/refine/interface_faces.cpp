// Sides in chains, one for each edge.
#include "partition/refine/interface_faces.h"

#include <algorithm>

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::VertexId;

InterfaceFaces::InterfaceFaces(const meshing::TetMesh& mesh, const std::vector<bool>& patch_inner)
    : mesh_(mesh), patch_inner_(patch_inner), index_of_(std::size_t{4} * mesh.tet_slots(), kNone) {
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
    for (int f = 0; f < 4; ++f)
      if (const TetFace face(TetId(i), f); mesh.alive(TetId(i)) && is_interface(face)) add_face(face);
  find_edges();
}

/// Somebody else has the tet on the other side.
bool InterfaceFaces::is_interface(TetFace face) const {
  if (mesh_.neighbour(face.tet(), face.face()).valid()) return false;
  const meshing::PatchId patch = mesh_.patch(face.tet(), face.face());
  return !patch.valid() || patch_inner_[patch.value];
}

VertexId InterfaceFaces::vertex(FaceIndex f, int place) const {
  return mesh_.vertex(faces_[f].tet(), meshing::kTetFaces[faces_[f].face()][place]);
}

InterfaceFaces::FaceIndex InterfaceFaces::index_of(TetFace face) const {
  return face.code < index_of_.size() ? index_of_[face.code] : kNone;  // new tets may be beyond
}

void InterfaceFaces::set_index(TetFace face, FaceIndex f) {
  if (face.code >= index_of_.size()) index_of_.resize(std::size_t{4} * mesh_.tet_slots(), kNone);
  index_of_[face.code] = f;
}

InterfaceFaces::FaceIndex InterfaceFaces::add_face(TetFace face) {
  const auto index = static_cast<FaceIndex>(faces_.size());
  faces_.push_back(face);
  set_index(face, index);
  edge_of_.resize(edge_of_.size() + 3, kNone);
  next_.resize(next_.size() + 3, kNone);
  return index;
}

InterfaceFaces::EdgeIndex InterfaceFaces::add_edge(VertexId a, VertexId b) {
  edges_.push_back({{a, b}});
  return num_edges() - 1;
}

/// Sides are met at the lower one of their ends, where there are few.
void InterfaceFaces::find_edges() {
  std::vector<EdgeIndex> newest(mesh_.vertex_slots(), kNone), older;  // chains of edges by their lower end
  for (FaceIndex f = 0; f < faces_.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax({vertex(f, i), vertex(f, (i + 1) % 3)});
      EdgeIndex e = newest[low.value];
      while (e != kNone && edges_[e].ends[1] != high) e = older[e];
      if (e == kNone) {
        e = add_edge(low, high);
        older.push_back(newest[low.value]);
        newest[low.value] = e;
      }
      append(3 * f + static_cast<Side>(i), e);
    }
}

void InterfaceFaces::append(Side side, EdgeIndex e) {
  Edge& edge = edges_[e];
  edge_of_[side] = e;
  next_[side] = kNone;
  (edge.first == kNone ? edge.first : next_[edge.last]) = side;
  edge.last = side;
}

/// In the chain of its edge.
void InterfaceFaces::replace(Side old, Side by) {
  Edge& edge = edges_[edge_of_[old]];
  edge_of_[by] = edge_of_[old];
  next_[by] = next_[old];
  Side* link = &edge.first;
  while (*link != old) link = &next_[*link];
  *link = by;
  if (edge.last == old) edge.last = by;
}

void InterfaceFaces::append_faces(EdgeIndex e, std::vector<TetFace>& faces) const {
  for (Side side = edges_[e].first; side != kNone; side = next_[side]) faces.push_back(faces_[side / 3]);
}

void InterfaceFaces::split(EdgeIndex e, VertexId kept, VertexId m, std::span<const TetId> tets) {
  const auto [a, b] = ends(e);
  const EdgeIndex with_kept = add_edge(kept, m), with_other = add_edge(m, kept == a ? b : a);
  for (const TetId t : tets) follow_face_beyond(t, kept);
  for (Side side = edges_[e].first, next = kNone; side != kNone; side = next) {
    next = next_[side];
    split_face(side, kept, m, {with_kept, with_other});
  }
  edges_[e].first = edges_[e].last = kNone;
}

/// The face of a halved tet opposite the end that it has kept belongs to the other half.
void InterfaceFaces::follow_face_beyond(TetId t, VertexId kept) {
  const int place = mesh_.local_index(t, kept);
  const FaceIndex f = index_of(TetFace(t, place));
  if (f == kNone) return;
  const TetFace now(mesh_.neighbour(t, place).tet(), place);
  set_index(faces_[f], kNone);
  set_index(now, f);
  faces_[f] = now;
}

/// The face (a, b, c) has become (a, m, c), where it was, and (m, b, c), of the tet's other half, whose
/// vertices have the same places.
void InterfaceFaces::split_face(Side side, VertexId kept, VertexId m, std::array<EdgeIndex, 2> halves) {
  const FaceIndex lower = side / 3;
  const int first = static_cast<int>(side % 3), second = (first + 1) % 3;
  const bool forward = vertex(lower, first) == kept;
  const int a = forward ? first : second, b = forward ? second : first, c = 3 - a - b;
  const VertexId tip = vertex(lower, c);
  const TetFace face = faces_[lower];
  const TetId other = mesh_.neighbour(face.tet(), mesh_.local_index(face.tet(), kept)).tet();
  const FaceIndex upper = add_face(TetFace(other, face.face()));
  const auto opposite = [](FaceIndex f, int place) { return 3 * f + static_cast<Side>((place + 1) % 3); };
  replace(opposite(lower, a), opposite(upper, a));  // (b, c)
  append(opposite(lower, c), halves[0]);
  append(opposite(upper, c), halves[1]);
  const EdgeIndex between = add_edge(m, tip);
  append(opposite(lower, a), between);
  append(opposite(upper, b), between);
}

}  // namespace weft::partition
