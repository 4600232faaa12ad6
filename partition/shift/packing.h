// The parcel for one neighbour.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include "partition/shift/departures.h"
#include "partition/shift/hand_over.h"
#include "partition/subdomain/background_cover.h"

namespace weft::partition {

/// Packs tets, and with them all that belongs to them: vertices, feature edges, the background that they
/// cover, the surface near their boundary faces.
class Packing {
 public:
  /// Where tets and vertices are in their parcel, by slot. One parcel is packed after the other, so that all
  /// share these.
  struct Places {
    explicit Places(const meshing::TetMesh& mesh)
        : of_tet(mesh.tet_slots()), of_vertex(mesh.vertex_slots(), kNoPlace) {}
    std::vector<std::uint32_t> of_tet;
    std::vector<std::uint32_t> of_vertex;  ///< kNoPlace for all between two parcels
  };

  /// `is_of_interface` as in Departures.
  Packing(const Subdomain& subdomain, const std::vector<std::uint8_t>& is_of_interface, Places& places);

  /// The tets that go to `receiver`, ascending; without what holders of vertices are told.
  Parcel pack(const Chosen& chosen, std::span<const meshing::TetId> tets, const Receiver& receiver);

 private:
  static constexpr std::uint32_t kNoPlace = 0xFFFFFFFFu;

  void reserve(std::size_t tets);
  void add(meshing::TetId t);

  std::uint32_t place_of(meshing::VertexId v);
  void add_features(const meshing::TetVertices& v);
  void name_neighbours(const Chosen& chosen);
  void add_pieces(const Receiver& receiver);
  void add_surface(std::span<const std::uint32_t> there);

  const Subdomain& s_;
  const meshing::TetMesh& mesh_;
  const std::vector<std::uint8_t>& is_of_interface_;
  Places& places_;
  Parcel parcel_;
  std::span<const meshing::TetId> tets_;  ///< of the parcel
  std::vector<std::uint32_t> vertices_;   ///< of the parcel
  std::unordered_set<std::uint64_t> features_;
  BackgroundCover background_;
};

}  // namespace weft::partition
