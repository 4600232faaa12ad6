// Copies of tets and of what belongs to them.
#include "partition/shift/packing.h"

#include <algorithm>

#include "partition/subdomain/surface_cover.h"

namespace weft::partition {

using meshing::TetFace;
using meshing::TetId;
using meshing::TetVertices;
using meshing::VertexId;

Packing::Packing(const Subdomain& s, const std::vector<std::uint8_t>& is_of_interface, Places& places)
    : s_(s), mesh_(*s.mesh), is_of_interface_(is_of_interface), places_(places), background_(s) {
  parcel_.from = s.id;
}

Parcel Packing::pack(const Chosen& chosen, std::span<const TetId> tets, const Receiver& receiver) {
  constexpr std::size_t kAhead = 12;  // tets: their vertices were last used when the subdomain was adapted
  tets_ = tets;
  reserve(tets.size());
  for (std::size_t i = 0; i < tets.size(); ++i) {
    if (i + kAhead < tets.size())
      for (const VertexId v : mesh_.vertices(tets[i + kAhead])) mesh_.prefetch(v);
    add(tets[i]);
  }
  name_neighbours(chosen);
  add_pieces(receiver);
  add_surface(receiver.surface);
  for (const std::uint32_t v : vertices_) places_.of_vertex[v] = kNoPlace;
  return std::move(parcel_);
}

void Packing::reserve(std::size_t tets) {
  parcel_.tets.reserve(tets);
  const std::size_t vertices = tets / 3;  // a few layers of tets have fewer
  parcel_.vertices.reserve(vertices);
  vertices_.reserve(vertices);
  background_.reserve(vertices);
}

void Packing::add(TetId t) {
  Parcel::Tet packed;
  const auto place = static_cast<std::uint32_t>(parcel_.tets.size());
  const TetVertices v = mesh_.vertices(t);
  for (int i = 0; i < 4; ++i) {
    packed.vertices[i] = place_of(v[i]);
    if (const meshing::PatchId patch = mesh_.patch(t, i); patch.valid())
      parcel_.boundary_faces.push_back({4 * place + static_cast<std::uint32_t>(i), patch});
  }
  packed.ref = mesh_.ref(t);
  packed.quality = mesh_.quality(t);
  places_.of_tet[t.value] = place;
  parcel_.tets.push_back(packed);
  add_features(v);
}

std::uint32_t Packing::place_of(VertexId v) {
  std::uint32_t& place = places_.of_vertex[v.value];
  if (place != kNoPlace) return place;
  place = static_cast<std::uint32_t>(parcel_.vertices.size());
  vertices_.push_back(v.value);
  parcel_.vertices.push_back({s_.global_id(v), mesh_.point(v), mesh_.log_metric(v), background_.add(v),
                              mesh_.surface_hint(v), mesh_.ref(v), mesh_.kind(v),
                              static_cast<std::uint8_t>(mesh_.flags(v) & ~meshing::kFrozen),
                              is_of_interface_[v.value] != 0});
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
              ? 4 * places_.of_tet[n.tet().value] + static_cast<std::uint32_t>(n.face())
              : meshing::kNoNeighbour;
    }
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
  for (const Parcel::BoundaryFace& b : parcel_.boundary_faces) {
    const auto& v = parcel_.tets[b.face / 4].vertices;
    const auto& face = meshing::kTetFaces[b.face % 4];
    cover.add_face(at(v[face[0]]), at(v[face[1]]), at(v[face[2]]));
  }
  cover.finish();
  for (auto& piece : cover.pieces(s_.surface))
    if (!std::ranges::binary_search(there, piece->id)) parcel_.surface.push_back(std::move(piece));
}

}  // namespace weft::partition
