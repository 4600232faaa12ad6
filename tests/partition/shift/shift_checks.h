// What must be true of all subdomains between two steps.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "meshing/mesh/check_mesh.h"
#include "partition/verify/check_subdomains.h"
#include "tests/partition/scenes.h"
#include "tests/partition/shift/rounds.h"

namespace weft::support {

using TetName = std::array<partition::GlobalId, 4>;

/// Which subdomain has each tet.
inline std::map<TetName, partition::SubdomainId> tets_of(
    const std::vector<partition::Subdomain>& subdomains) {
  std::map<TetName, partition::SubdomainId> tets;
  for (const auto& s : subdomains)
    for (std::uint32_t i = 0; i < s.mesh->tet_slots(); ++i) {
      const meshing::TetId t(i);
      if (!s.mesh->alive(t)) continue;
      TetName name;
      for (int k = 0; k < 4; ++k) name[k] = s.global_id(s.mesh->vertex(t, k));
      std::sort(name.begin(), name.end());
      EXPECT_TRUE(tets.emplace(name, s.id).second) << "a tet is in two subdomains";
    }
  return tets;
}

inline partition::ExpectedTotals totals_of(const meshing::MeshData& mesh) {
  const meshing::CheckReport report = check_mesh(mesh);
  EXPECT_TRUE(report.ok());
  return {report.volume, report.area_by_ref};
}

/// The invariants of distributed data.
inline void expect_conforming(const Rounds& rounds, const std::optional<partition::ExpectedTotals>& totals) {
  partition::SelfPeers alone;
  const auto pieces = rounds.pieces();
  EXPECT_THAT(check_pieces(alone, pieces, totals).problems, ::testing::ElementsAre());
}

/// The interface's table fits the mesh, and whatever others may have on their side is frozen.
inline void expect_sound_interface(const partition::Subdomain& s, const partition::Geometry& geometry) {
  meshing::Problems problems(20);
  check_interface(s, geometry, problems);
  EXPECT_THAT(problems.take(), ::testing::ElementsAre());
}

/// What a vertex is on the boundary is the same in all copies. (A subdomain in which all is right around a
/// vertex does not want it freed; another may.)
inline void expect_copies_agree(const std::vector<partition::Subdomain>& subdomains) {
  constexpr int kOwn = partition::kWasInterface | partition::kHasBeenFree | meshing::kFrozen;
  std::map<partition::GlobalId, std::pair<meshing::VertexKind, int>> seen;
  std::size_t differ = 0;
  for (const auto& s : subdomains)
    for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
      const meshing::VertexId v = s.interface.local(i);
      const std::pair mine(s.mesh->kind(v), s.mesh->flags(v) & ~kOwn);
      differ += seen.emplace(s.interface.id(i), mine).first->second != mine;
    }
  EXPECT_EQ(differ, 0u) << "copies of vertices";
}

inline void expect_sound(Rounds& rounds, const std::optional<partition::ExpectedTotals>& totals) {
  for (const auto& s : rounds.subdomains()) expect_sound_interface(s, rounds.geometry());
  expect_copies_agree(rounds.subdomains());
  expect_conforming(rounds, totals);
}

}  // namespace weft::support
