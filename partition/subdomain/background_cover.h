// Which pieces of the background a part of a mesh is to have.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "partition/subdomain/subdomain.h"

namespace weft::partition {

/// Collects the pieces that vertices are in, and those that tets between them cover.
class BackgroundCover {
 public:
  /// Refers to the subdomain, whose mesh must not change.
  explicit BackgroundCover(const Subdomain& subdomain)
      : mesh_(*subdomain.mesh), background_(subdomain.background) {}

  void reserve(std::size_t vertices) { slot_of_vertex_.reserve(vertices); }
  /// Vertices have places from 0 on, in the order in which they come. Returns where the vertex is.
  BackgroundTet add(meshing::VertexId v);
  /// A tet, with the places of its vertices; once all vertices have come.
  void add(meshing::TetId t, const std::array<std::uint32_t, 4>& places);

  std::size_t num_pieces() const { return covered_.size(); }
  /// Their ids, ascending.
  std::vector<std::uint64_t> pieces() const;

 private:
  /// A tet by its corners, each with the place in covered_ of the piece that it is in.
  struct Probe {
    std::array<meshing::Point, 4> corners;
    std::array<std::uint32_t, 4> slots;
  };
  struct Covered {
    std::uint64_t piece;
    std::uint32_t vertices;  ///< that are in this piece
  };

  std::uint32_t slot_of(std::uint64_t piece);
  std::uint32_t look_up(const meshing::Point& p);
  void look_within(const Probe& probe, int depth);

  const meshing::TetMesh& mesh_;
  const BackgroundStore& background_;
  std::vector<Covered> covered_;
  std::unordered_map<std::uint64_t, std::uint32_t> slots_;  ///< piece -> its place in covered_
  std::vector<std::uint32_t> slot_of_vertex_;
  std::uint32_t last_found_ = 0;  ///< a tet of the background: the next walk of look_up() starts there
};

/// Gives back what the subdomain's mesh does not cover, where that is much of what it has.
void drop_far_background(Subdomain& subdomain);

}  // namespace weft::partition
