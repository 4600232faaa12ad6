// The parcel for one neighbour.
#pragma once

#include <cstdint>
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
  /// `interface_index` as for find_departures(); `place_of_tet`, by slot, is shared by all packings: each tet
  /// is in one parcel.
  Packing(const Subdomain& subdomain, SubdomainId to, const std::vector<std::uint32_t>& interface_index,
          std::vector<std::uint32_t>& place_of_tet);

  void reserve(std::size_t tets);
  void add(meshing::TetId t);

  Parcel finish(const Chosen& chosen, const std::vector<Departure>& departures, const Receiver& receiver);

 private:
  static constexpr std::uint32_t kNoPlace = 0xFFFFFFFFu;

  std::uint32_t place_of(meshing::VertexId v);
  void add_features(const meshing::TetVertices& v);
  void name_neighbours(const Chosen& chosen);
  bool concerns_receiver(std::uint32_t vertex) const;
  void add_previous_holders(std::uint32_t vertex);
  void add_pieces(const Receiver& receiver);
  void add_surface(std::span<const std::uint32_t> there);

  const Subdomain& s_;
  const meshing::TetMesh& mesh_;
  SubdomainId to_;
  const std::vector<std::uint32_t>& interface_index_;
  std::vector<std::uint32_t>& place_of_tet_;
  Parcel parcel_;
  std::vector<meshing::TetId> tets_;     ///< of the parcel
  std::vector<std::uint32_t> vertices_;  ///< of the parcel
  std::vector<std::uint32_t> places_;    ///< vertex -> its place in the parcel; empty while that is
  std::unordered_set<std::uint64_t> features_;
  BackgroundCover background_;
};

}  // namespace weft::partition
