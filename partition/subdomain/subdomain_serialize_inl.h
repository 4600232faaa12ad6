// Packing of subdomains for any archive.
#pragma once

#include "meshing/kernel/tet_mesh_arrays.h"
#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// Vertices are a fifth of the tets; boundaries of thin parts need more.
inline std::size_t vertex_capacity(std::size_t tet_capacity) { return tet_capacity / 2 + 1000; }

template <class Archive>
void Subdomain::serialize(Archive& archive) {
  meshing::TetMeshArrays arrays;
  std::vector<meshing::SurfacePieces::Piece> surface_pieces;
  std::uint64_t room_vertices = 0, room_tets = 0;
  if constexpr (Archive::kPacks) {
    room_vertices = mesh->vertex_capacity();
    room_tets = mesh->tet_capacity();
    arrays = meshing::to_arrays(*mesh);
    surface_pieces.assign(surface.all().begin(), surface.all().end());
  }
  archive(id, room_vertices, room_tets, next_local, interface, phase, departures, frozen_since, arrays);
  if constexpr (Archive::kPacks) {
    serialize_pieces(archive, background.all_pieces());
  } else {
    std::vector<BackgroundStore::SharedPiece> pieces;
    serialize_pieces(archive, pieces);
    background.add(pieces);
  }
  meshing::serialize_pieces(archive, surface_pieces);
  if constexpr (!Archive::kPacks) {
    mesh = meshing::from_arrays(arrays, room_vertices, room_tets, meshing::Pages::small);
    surface.add(surface_pieces);
  }
}

}  // namespace weft::partition
