// Copies of tets and of what belongs to them.
#include "partition/shift/packing.h"

#include <algorithm>

#include "partition/subdomain/surface_cover.h"

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::TetVertices;
using meshing::VertexId;

Packing::Packing(const Subdomain& s, SubdomainId to, const std::vector<std::uint32_t>& interface_index,
                 std::vector<std::uint32_t>& place_of_tet)
    : s_(s),
      mesh_(*s.mesh),
      to_(to),
      interface_index_(interface_index),
      place_of_tet_(place_of_tet),
      background_(s) {
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
  background_.reserve(vertices);
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
                       const Receiver& receiver) {
  name_neighbours(chosen);
  for (const Departure& d : departures)
    if (concerns_receiver(d.vertex)) parcel_.now.push_back({d.id, d.to});
  for (const std::uint32_t v : vertices_) add_previous_holders(v);
  add_pieces(receiver);
  add_surface(receiver.surface);
  return std::move(parcel_);
}

std::uint32_t Packing::place_of(VertexId v) {
  std::uint32_t& place = places_[v.value];
  if (place != kNoPlace) return place;
  place = static_cast<std::uint32_t>(parcel_.vertices.size());
  vertices_.push_back(v.value);
  parcel_.vertices.push_back({s_.global_id(v), mesh_.point(v), mesh_.log_metric(v), background_.add(v),
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

void Packing::add_pieces(const Receiver& receiver) {
  if (receiver.covered.empty())
    for (std::size_t i = 0; i < tets_.size(); ++i) background_.add(tets_[i], parcel_.tets[i].vertices);
  std::vector<std::uint64_t> pieces, missing;
  std::ranges::set_union(background_.pieces(), receiver.covered, std::back_inserter(pieces));
  std::ranges::set_difference(pieces, receiver.pieces, std::back_inserter(missing));
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
