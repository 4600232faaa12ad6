// Tets sent to the home ranks of their subdomains, and the holders of their vertices.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "partition/subdomain/global_id.h"

namespace weft::partition {

/// The rank on which a subdomain starts: contiguous and even.
inline int home_rank(SubdomainId subdomain, std::uint32_t num_subdomains, int ranks) {
  return static_cast<int>(std::uint64_t{subdomain.value} * static_cast<std::uint64_t>(ranks) /
                          num_subdomains);
}

/// A tet of the input; vertices are numbered as in the whole input.
struct TetRecord {
  std::uint64_t number;
  std::array<std::uint32_t, 4> vertices;
  std::int32_t ref;
  SubdomainId subdomain;
};

/// Sends each tet of the slice to the home rank of its subdomain; returns those of this rank's subdomains, by
/// subdomain and number. Empties the slice of tets. All ranks call together.
std::vector<TetRecord> send_tets_home(Peers& peers, MeshSlice& slice, std::span<const SubdomainId> subdomains,
                                      std::uint32_t num_subdomains);

/// Each vertex of the tets once, ascending.
std::vector<std::uint32_t> vertices_of(std::span<const TetRecord> tets);

/// That a subdomain has a tet at a vertex of the input.
struct InputHolder {
  std::uint32_t vertex;
  SubdomainId subdomain;
  friend auto operator<=>(const InputHolder&, const InputHolder&) = default;
};

/// Who holds the vertices of this rank's subdomains.
struct Holders {
  std::vector<InputHolder>
      shared;              ///< all holders, on whatever rank, of each vertex that has several; sorted
  std::uint64_t used = 0;  ///< vertices of the whole mesh that any tet has

  /// Those of one vertex; empty where one subdomain alone has it.
  std::span<const InputHolder> of(std::uint32_t vertex) const;
};

/// From this rank's tets, sorted by subdomain. Holders of a vertex meet at a rank that its number decides.
/// All ranks call together.
Holders find_holders(Peers& peers, std::span<const TetRecord> tets, std::uint32_t num_subdomains);

}  // namespace weft::partition
