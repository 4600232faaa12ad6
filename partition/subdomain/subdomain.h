// One subdomain: a mesh of its own, the background that it covers, and the interface that it shares with
// others.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "meshing/adapt/stages.h"
#include "meshing/geometry/surface/surface.h"
#include "meshing/geometry/surface/surface_piece.h"
#include "meshing/kernel/tet_mesh.h"
#include "partition/subdomain/background_store.h"
#include "partition/subdomain/interface.h"
#include "partition/subdomain/mesh_piece.h"
#include "partition/subdomain/subdomain_start.h"

namespace weft::partition {

/// A vertex flag (of those that meshing::VertexFlag reserves for callers): some adaptation could change all
/// around the vertex, or had no need to.
inline constexpr std::uint8_t kHasBeenFree = meshing::kCallerThird;

/// Another one: the vertex has been one of the interface.
inline constexpr std::uint8_t kWasInterface = meshing::kCallerFirst;

/// The data of one subdomain between two steps of the distributed method (DESIGN.md, sections 3 and 5). The
/// steps are functions on it: shift.h, adapt_subdomain.h. Vertices carry their GlobalId as the kernel's
/// label; those of the interface are frozen.
struct Subdomain {
  Subdomain() = default;
  /// `tet_capacity`: address space, not memory, for tets that may come here; the mesh grows beyond it.
  Subdomain(const SubdomainStart& start, std::size_t tet_capacity);

  SubdomainId id;
  std::uint64_t next_local = 0;  ///< of the ids that this subdomain gives to new vertices
  std::unique_ptr<meshing::TetMesh> mesh;
  BackgroundStore background;
  meshing::SurfacePieces surface;  ///< of the boundary's surface, what is near the mesh
  Interface interface;
  /// How often adaptation has begun anew (begin_next_phase). In later phases the interface's edges are longer
  /// than the background's when they are split.
  std::uint32_t phase = 0;
  /// Where the tets around vertices of the old interface have gone from here: between gathering and
  /// scattering.
  std::vector<Holder> departures;
  /// The vertices of these that are or were here, by slot, which gathering has frozen: also those that are
  /// not of the interface until scattering.
  std::vector<meshing::VertexId> frozen_since;

  GlobalId global_id(meshing::VertexId v) const { return GlobalId::from_value(mesh->label(v)); }

  /// Packs or unpacks everything: a subdomain moves between ranks.
  template <class Archive>
  void serialize(Archive& archive);
};

/// New vertices get their ids, in the order of their places.
void name_new_vertices(Subdomain& subdomain);

std::uint64_t count_tets(const Subdomain& subdomain);

/// Begins the next phase: no vertex counts as having been free or as former interface.
void begin_next_phase(Subdomain& subdomain);

/// Finds the interface's vertices in the mesh again, after numbers have changed. Those whose tets have all
/// left have no place (until scattering has found who holds them now).
void locate_interface(Subdomain& subdomain);

/// How the entities of a piece are numbered.
enum class PieceOrder : std::uint8_t {
  anew,          ///< along a curve, and so is the subdomain: numbers change, holes are closed
  kept_if_good,  ///< without holes as in the subdomain, if they are in order (meshing::is_in_order)
};

/// The subdomain as plain arrays. `surface`: any part of the whole mesh's; one of a model is in order anew.
MeshPiece make_piece(Subdomain& subdomain, const meshing::Surface& surface,
                     const std::vector<bool>& patch_required, PieceOrder order = PieceOrder::anew);

}  // namespace weft::partition

#include "partition/subdomain/subdomain_serialize_inl.h"
