// The parcel for one neighbour.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "partition/shift/departures.h"

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

  /// `pieces`: of the background, those that the receiver has already; ascending. `surface`: the same of the
  /// surface.
  Parcel finish(const Chosen& chosen, const std::vector<Departure>& departures,
                std::span<const std::uint64_t> pieces, std::span<const std::uint32_t> surface);

 private:
  static constexpr std::uint32_t kNoPlace = 0xFFFFFFFFu;

  std::uint32_t place_of(meshing::VertexId v);
  void add_features(const meshing::TetVertices& v);
  std::uint32_t slot_of(std::uint64_t piece);
  void add_background(std::size_t tet);
  /// A tet by its corners, each with the place in covered_ of the piece that it is in.
  struct Probe {
    std::array<meshing::Point, 4> corners;
    std::array<std::uint32_t, 4> slots;
  };
  std::uint32_t look_up(const meshing::Point& p);
  void look_within(const Probe& probe, int depth);
  void name_neighbours(const Chosen& chosen);
  bool concerns_receiver(std::uint32_t vertex) const;
  void add_previous_holders(std::uint32_t vertex);
  void add_pieces(std::span<const std::uint64_t> there);
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
  struct Covered {
    std::uint64_t piece;
    std::uint32_t vertices;  ///< of the parcel, in this piece
  };
  std::vector<Covered> covered_;
  std::unordered_map<std::uint64_t, std::uint32_t> slots_;  ///< piece -> its place in covered_
  std::vector<std::uint32_t> slot_of_vertex_;               ///< by place in the parcel
  std::uint32_t last_found_ = 0;  ///< a tet of the background: the next walk of look_up() starts there
};

}  // namespace weft::partition
