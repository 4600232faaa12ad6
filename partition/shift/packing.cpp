// Copies of tets and of what belongs to them.
#include "partition/shift/packing.h"

#include <algorithm>

#include "partition/subdomain/surface_cover.h"

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::TetVertices;
using meshing::VertexId;

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

}  // namespace

Packing::Packing(const Subdomain& s, SubdomainId to, const std::vector<std::uint32_t>& interface_index,
                 std::vector<std::uint32_t>& place_of_tet)
    : s_(s), mesh_(*s.mesh), to_(to), interface_index_(interface_index), place_of_tet_(place_of_tet) {
  parcel_.from = s.id;
}

void Packing::reserve(std::size_t tets) {
  if (tets == 0) return;
  places_.assign(mesh_.vertex_slots(), kNoPlace);
  parcel_.tets.reserve(tets);
  tets_.reserve(tets);
  const std::size_t vertices = tets / 3;  // a few layers of tets have fewer
  parcel_.vertices.reserve(vertices);
  vertices_.reserve(vertices);
  slot_of_vertex_.reserve(vertices);
}

void Packing::add(TetId t) {
  Parcel::Tet packed;
  const TetVertices v = mesh_.vertices(t);
  for (int i = 0; i < 4; ++i) {
    packed.vertices[i] = place_of(v[i]);
    packed.patches[i] = mesh_.patch(t, i);
  }
  packed.ref = mesh_.ref(t);
  packed.quality = mesh_.quality(t);
  place_of_tet_[t.value] = static_cast<std::uint32_t>(parcel_.tets.size());
  parcel_.tets.push_back(packed);
  tets_.push_back(t);
  add_features(v);
}

Parcel Packing::finish(const Chosen& chosen, const std::vector<Departure>& departures,
                       std::span<const std::uint64_t> pieces, std::span<const std::uint32_t> surface) {
  name_neighbours(chosen);
  for (const Departure& d : departures)
    if (concerns_receiver(d.vertex)) parcel_.now.push_back({d.id, d.to});
  for (const std::uint32_t v : vertices_) add_previous_holders(v);
  for (std::size_t i = 0; i < tets_.size(); ++i) add_background(i);
  add_pieces(pieces);
  add_surface(surface);
  return std::move(parcel_);
}

std::uint32_t Packing::place_of(VertexId v) {
  std::uint32_t& place = places_[v.value];
  if (place != kNoPlace) return place;
  place = static_cast<std::uint32_t>(parcel_.vertices.size());
  const BackgroundTet background = s_.background.name_of(mesh_.background_hint(v));
  slot_of_vertex_.push_back(slot_of(background.piece));
  ++covered_[slot_of_vertex_.back()].vertices;
  vertices_.push_back(v.value);
  parcel_.vertices.push_back({s_.global_id(v), mesh_.point(v), mesh_.log_metric(v), background,
                              mesh_.surface_hint(v), mesh_.ref(v), mesh_.kind(v),
                              static_cast<std::uint8_t>(mesh_.flags(v) & ~meshing::kFrozen)});
  return place;
}

void Packing::add_features(const TetVertices& v) {
  for (const auto& e : meshing::kTetEdges) {
    const VertexId a = v[e[0]], b = v[e[1]];
    const meshing::CurveId curve = mesh_.curve(a, b);
    if (!curve.valid()) continue;
    const std::uint64_t key = std::uint64_t{std::min(a, b).value} << 32 | std::max(a, b).value;
    if (features_.insert(key).second) parcel_.feature_edges.push_back({{place_of(a), place_of(b)}, curve});
  }
}

std::uint32_t Packing::slot_of(std::uint64_t piece) {
  if (!slot_of_vertex_.empty() && covered_[slot_of_vertex_.back()].piece == piece)
    return slot_of_vertex_.back();
  const auto [at, is_new] = slots_.try_emplace(piece, static_cast<std::uint32_t>(covered_.size()));
  if (is_new) covered_.push_back({piece, 0});
  return at->second;
}

/// A tet that is larger than the pieces may cover some that none of its vertices is in. Not one between
/// pieces that have many vertices each.
void Packing::add_background(std::size_t tet) {
  constexpr std::uint32_t kMany = 8;  // a piece has about a hundred of its own
  const std::array<std::uint32_t, 4>& places = parcel_.tets[tet].vertices;
  Probe probe;
  for (std::size_t i = 0; i < 4; ++i) probe.slots[i] = slot_of_vertex_[places[i]];
  const auto& slot = probe.slots;
  const auto differs = std::find_if(slot.begin(), slot.end(), [&](std::uint32_t s) { return s != slot[0]; });
  if (differs == slot.end()) return;
  if (std::all_of(slot.begin(), slot.end(), [&](std::uint32_t s) { return covered_[s].vertices >= kMany; }))
    return;
  const TetVertices v = mesh_.vertices(tets_[tet]);
  for (std::size_t i = 0; i < 4; ++i) probe.corners[i] = mesh_.point(v[i]);
  last_found_ = mesh_.background_hint(v[0]);
  look_within(probe, 0);
}

/// Looks up the centre and, between three pieces and more, the middles of the edges. A tet that is much
/// larger than pieces meets many of them there; then, as long as that finds a piece that no corner is in,
/// goes on with the eight tets between corners and middles. (Tets where a few pieces meet are many, and
/// covered by this.)
void Packing::look_within(const Probe& probe, int depth) {
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
std::uint32_t Packing::look_up(const meshing::Point& p) {
  last_found_ = s_.background.background().walk_towards(p, last_found_).tet;
  return slot_of(s_.background.name_of(last_found_).piece);
}

void Packing::name_neighbours(const Chosen& chosen) {
  for (std::size_t i = 0; i < tets_.size(); ++i)
    for (int f = 0; f < 4; ++f) {
      const TetFace n = mesh_.neighbour(tets_[i], f);
      parcel_.tets[i].neighbours[f] =
          n.valid() && chosen.to[n.tet().value] == chosen.to[tets_[i].value]
              ? 4 * place_of_tet_[n.tet().value] + static_cast<std::uint32_t>(n.face())
              : meshing::kNoNeighbour;
    }
}

bool Packing::concerns_receiver(std::uint32_t vertex) const {
  if (!places_.empty() && places_[vertex] != kNoPlace) return true;
  const std::uint32_t i = interface_index_[vertex];
  return i != Interface::kNone && s_.interface.held_by(i, to_);
}

void Packing::add_previous_holders(std::uint32_t vertex) {
  const std::uint32_t i = interface_index_[vertex];
  if (i == Interface::kNone || s_.interface.held_by(i, to_)) return;
  parcel_.before.push_back({s_.interface.id(i), s_.id});
  for (const Holder& h : s_.interface.others(i)) parcel_.before.push_back(h);
}

void Packing::add_pieces(std::span<const std::uint64_t> there) {
  std::vector<std::uint64_t> pieces;
  for (const Covered& c : covered_) pieces.push_back(c.piece);
  std::sort(pieces.begin(), pieces.end());
  std::vector<std::uint64_t> missing;
  std::set_difference(pieces.begin(), pieces.end(), there.begin(), there.end(), std::back_inserter(missing));
  parcel_.pieces = s_.background.pieces(missing);
}

void Packing::add_surface(std::span<const std::uint32_t> there) {
  if (s_.surface.all().empty()) return;
  SurfaceCover cover;
  const auto at = [&](std::uint32_t v) {
    return SurfaceCover::Vertex{parcel_.vertices[v].point, parcel_.vertices[v].surface_hint};
  };
  for (std::uint32_t v = 0; v < parcel_.vertices.size(); ++v) cover.add(at(v));
  for (const Parcel::Tet& t : parcel_.tets)
    for (std::size_t f = 0; f < 4; ++f) {
      if (!t.patches[f].valid()) continue;
      const auto& face = meshing::kTetFaces[f];
      cover.add_face(at(t.vertices[face[0]]), at(t.vertices[face[1]]), at(t.vertices[face[2]]));
    }
  cover.finish();
  for (auto& piece : cover.pieces(s_.surface))
    if (!std::ranges::binary_search(there, piece->id)) parcel_.surface.push_back(std::move(piece));
}

}  // namespace weft::partition
