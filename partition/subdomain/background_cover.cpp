// Vertices by their hints, tets by samples.
#include "partition/subdomain/background_cover.h"

#include <algorithm>

namespace weft::partition {
namespace {

/// The eight tets between the corners of a tet (0 to 3) and the middles of its edges (4 and up, in the order
/// of kTetEdges).
constexpr std::size_t kChildren[8][4] = {{0, 4, 5, 6}, {1, 4, 7, 8}, {2, 5, 7, 9}, {3, 6, 8, 9},
                                         {5, 8, 4, 7}, {5, 8, 7, 9}, {5, 8, 9, 6}, {5, 8, 6, 4}};

bool in_two_pieces(const std::array<std::uint32_t, 4>& slots) {
  const auto other = std::ranges::find_if(slots, [&](std::uint32_t s) { return s != slots[0]; });
  return other == slots.end() ||
         std::ranges::all_of(slots, [&](std::uint32_t s) { return s == slots[0] || s == *other; });
}

/// How many pieces some of the vertices are in: with a hundred vertices to a piece, nearly all that they are.
std::size_t pieces_of_sample(const Subdomain& s) {
  constexpr std::uint32_t kOneIn = 8;
  BackgroundCover cover(s);
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); i += kOneIn)
    if (const meshing::VertexId v(i); s.mesh->alive(v)) cover.add(v);
  return cover.num_pieces();
}

}  // namespace

BackgroundTet BackgroundCover::add(meshing::VertexId v) {
  const BackgroundTet place = background_.name_of(mesh_.background_hint(v));
  slot_of_vertex_.push_back(slot_of(place.piece));
  ++covered_[slot_of_vertex_.back()].vertices;
  return place;
}

std::uint32_t BackgroundCover::slot_of(std::uint64_t piece) {
  if (!slot_of_vertex_.empty() && covered_[slot_of_vertex_.back()].piece == piece)
    return slot_of_vertex_.back();
  const auto [at, is_new] = slots_.try_emplace(piece, static_cast<std::uint32_t>(covered_.size()));
  if (is_new) covered_.push_back({piece, 0});
  return at->second;
}

/// A tet that is larger than the pieces may cover some that none of its vertices is in. Not one between
/// pieces that have many vertices each.
void BackgroundCover::add(meshing::TetId t, const std::array<std::uint32_t, 4>& places) {
  constexpr std::uint32_t kMany = 8;  // a piece has about a hundred of its own
  Probe probe;
  for (std::size_t i = 0; i < 4; ++i) probe.slots[i] = slot_of_vertex_[places[i]];
  const auto& slot = probe.slots;
  const auto differs = std::find_if(slot.begin(), slot.end(), [&](std::uint32_t s) { return s != slot[0]; });
  if (differs == slot.end()) return;
  if (std::all_of(slot.begin(), slot.end(), [&](std::uint32_t s) { return covered_[s].vertices >= kMany; }))
    return;
  const meshing::TetVertices v = mesh_.vertices(t);
  for (std::size_t i = 0; i < 4; ++i) probe.corners[i] = mesh_.point(v[i]);
  last_found_ = mesh_.background_hint(v[0]);
  look_within(probe, 0);
}

/// Looks up the centre and, between three pieces and more, the middles of the edges. A tet that is much
/// larger than pieces meets many of them there; then, as long as that finds a piece that no corner is in,
/// goes on with the eight tets between corners and middles. (Tets where a few pieces meet are many, and
/// covered by this.)
void BackgroundCover::look_within(const Probe& probe, int depth) {
  constexpr int kDeepest = 5;
  constexpr std::ptrdiff_t kManyPieces = 6;
  const auto& x = probe.corners;
  std::array<std::uint32_t, 11> slots;  // of corners, middles of edges, and the centre
  std::copy(probe.slots.begin(), probe.slots.end(), slots.begin());
  meshing::Point centre;
  for (const meshing::Point& p : x) centre += 0.25 * p;
  slots[10] = look_up(centre);
  if (depth == 0 && in_two_pieces(probe.slots)) return;
  std::array<meshing::Point, 6> middle;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto a = static_cast<std::size_t>(meshing::kTetEdges[e][0]);
    const auto b = static_cast<std::size_t>(meshing::kTetEdges[e][1]);
    middle[e] = midpoint(x[a], x[b]);
    slots[4 + e] = slots[a] == slots[b] ? slots[a] : look_up(middle[e]);
  }
  const auto is_new = [&](std::uint32_t s) { return std::ranges::find(probe.slots, s) == probe.slots.end(); };
  if (depth == kDeepest || std::none_of(slots.begin() + 4, slots.end(), is_new)) return;
  if (depth == 0) {
    std::array<std::uint32_t, 11> pieces = slots;
    std::ranges::sort(pieces);
    if (std::unique(pieces.begin(), pieces.end()) - pieces.begin() < kManyPieces) return;
  }
  for (const auto& child : kChildren) {
    Probe part;
    for (std::size_t i = 0; i < 4; ++i) {
      part.corners[i] = child[i] < 4 ? x[child[i]] : middle[child[i] - 4];
      part.slots[i] = slots[child[i]];
    }
    look_within(part, depth + 1);
  }
}

/// Counts as covered the piece where p is.
std::uint32_t BackgroundCover::look_up(const meshing::Point& p) {
  last_found_ = background_.background().walk_towards(p, last_found_).tet;
  return slot_of(background_.name_of(last_found_).piece);
}

std::vector<std::uint64_t> BackgroundCover::pieces() const {
  std::vector<std::uint64_t> ids;
  for (const Covered& c : covered_) ids.push_back(c.piece);
  std::ranges::sort(ids);
  return ids;
}

void drop_far_background(Subdomain& s) {
  constexpr std::size_t kMuch = 2;  // times what the vertices are in; what tets between them cover is little
  meshing::TetMesh& mesh = *s.mesh;
  if (s.background.num_pieces() <= kMuch * pieces_of_sample(s)) return;
  BackgroundCover cover(s);
  std::vector<std::uint32_t> places(mesh.vertex_slots());
  std::vector<BackgroundTet> names;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i) {
    if (!mesh.alive(meshing::VertexId(i))) continue;
    places[i] = static_cast<std::uint32_t>(names.size());
    names.push_back(cover.add(meshing::VertexId(i)));
  }
  if (s.background.num_pieces() <= kMuch * cover.num_pieces()) return;
  for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
    const meshing::TetId t(i);
    if (!mesh.alive(t)) continue;
    const meshing::TetVertices v = mesh.vertices(t);
    cover.add(t, {places[v[0].value], places[v[1].value], places[v[2].value], places[v[3].value]});
  }
  BackgroundStore near;
  near.add(s.background.pieces(cover.pieces()));
  s.background = std::move(near);
  auto name = names.begin();
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (const meshing::VertexId v(i); mesh.alive(v))
      mesh.set_background_hint(v, s.background.tet_of(*name++));
}

}  // namespace weft::partition
