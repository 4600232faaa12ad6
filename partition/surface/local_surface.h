// A rank's triangles of the boundary with two rings of others around them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "meshing/base/place_in.h"
#include "meshing/mesh/mesh_data.h"
#include "partition/communication/peers.h"
#include "partition/surface/boundary_share.h"

namespace weft::partition {

/// Vertices and triangles have the order that they have in the boundary.
struct LocalSurface {
  meshing::MeshData mesh;                         ///< numbered by entries of `vertices`
  std::vector<std::uint32_t> triangles;           ///< numbers in the boundary, ascending
  std::vector<std::uint32_t> vertices;            ///< numbers in the whole input, ascending
  std::vector<std::uint8_t> rings;                ///< meshing::SurfaceTopology::rings
  std::vector<std::uint32_t> owners;              ///< ranks that own the triangles
  std::vector<std::vector<std::uint32_t>> asked;  ///< asked_at_home() of the vertices
};

/// All ranks: what the owners of the triangles here know of them. `own`: numbers of the triangles that this
/// rank owns, ascending; `entry(i)`: of the i-th of these.
template <class T, class Entry>
std::vector<T> from_owners(Peers& peers, const LocalSurface& local, std::span<const std::uint32_t> own,
                           const Entry& entry) {
  std::vector<std::vector<std::uint32_t>> asked(static_cast<std::size_t>(peers.ranks()));
  for (std::size_t t = 0; t < local.triangles.size(); ++t)
    asked[local.owners[t]].push_back(local.triangles[t]);
  asked = partition::all_to_all(peers, std::move(asked));
  std::vector<std::vector<T>> answers(asked.size());
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const std::uint32_t t : asked[r]) answers[r].push_back(entry(meshing::place_in(own, t)));
  answers = partition::all_to_all(peers, std::move(answers));
  std::vector<std::size_t> next(answers.size(), 0);
  std::vector<T> result;
  result.reserve(local.owners.size());
  for (const std::uint32_t r : local.owners) result.push_back(answers[r][next[r]++]);
  return result;
}

/// Finds the triangles around others: at the homes of their vertices, which are told of all that are there.
class SurfaceNeighbours {
 public:
  /// Each rank owns the triangles of its share. Refers to its arguments. All ranks call together, also what
  /// follows.
  SurfaceNeighbours(Peers& peers, const BoundaryShare& share, const FetchPoints& points);

  /// With these triangles as its own, each once. Of edges and lists it has what lies between its vertices. On
  /// one rank `own` must be all.
  LocalSurface around(std::vector<BoundaryTriangle> own) const;

 private:
  struct Owned {
    BoundaryTriangle triangle;
    std::uint32_t owner;
  };

  void send_home();
  std::vector<Owned> at(const std::vector<std::uint32_t>& vertices) const;
  void add_listed(LocalSurface& local) const;

  Peers& peers_;
  const BoundaryShare& share_;
  const FetchPoints& points_;
  std::vector<Owned> here_;                                         // with a vertex whose home this is
  std::vector<std::pair<std::uint32_t, std::uint32_t>> at_vertex_;  // (vertex, place in here_), sorted
};

}  // namespace weft::partition
