// The chains of sides after many splits against those of a mesh looked at for the first time.
#include "partition/refine/interface_faces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "meshing/kernel/kernel.h"
#include "meshing/operators/split_edge.h"
#include "tests/partition/scenes.h"

namespace weft::partition::interface_faces_test {
namespace {

using namespace weft::support;
using meshing::TetFace;
using meshing::TetId;
using meshing::VertexId;
using ::testing::IsEmpty;

using EdgeIndex = InterfaceFaces::EdgeIndex;
/// The faces at each edge that has any, sorted, by the edge's ends.
using Table = std::map<std::pair<VertexId, VertexId>, std::vector<std::uint32_t>>;

std::vector<TetFace> faces_at(const InterfaceFaces& faces, EdgeIndex e) {
  std::vector<TetFace> list;
  faces.append_faces(e, list);
  return list;
}

Table table_of(const InterfaceFaces& faces) {
  Table table;
  for (EdgeIndex e = 0; e < faces.num_edges(); ++e) {
    std::vector<std::uint32_t> codes;
    for (const TetFace face : faces_at(faces, e)) codes.push_back(face.code);
    if (codes.empty()) continue;
    std::sort(codes.begin(), codes.end());
    const auto [a, b] = faces.ends(e);
    EXPECT_TRUE(table.emplace(std::minmax({a, b}), codes).second) << "two edges " << a << ' ' << b;
  }
  return table;
}

/// What the faces' definition says.
Table expected_table(const meshing::TetMesh& mesh, const Geometry& geometry) {
  Table table;
  for (std::uint32_t i = 0; i < 4 * mesh.tet_slots(); ++i) {
    const TetFace face(i);
    if (!mesh.alive(face.tet()) || mesh.neighbour(face.tet(), face.face()).valid()) continue;
    const meshing::PatchId patch = mesh.patch(face.tet(), face.face());
    if (patch.valid() && !geometry.patch_inner[patch.value]) continue;
    for (int k = 0; k < 3; ++k) {
      const auto& places = meshing::kTetFaces[face.face()];
      const VertexId a = mesh.vertex(face.tet(), places[k]), b = mesh.vertex(face.tet(), places[(k + 1) % 3]);
      table[std::minmax({a, b})].push_back(i);
    }
  }
  return table;
}

/// A subdomain whose interface is split at random.
class Splitting {
 public:
  Splitting(const Cut& cut, const SubdomainStart& start)
      : geometry_(cut.geometry),
        subdomain_(start, 100 * start.tets.size() + 100000),
        kernel_{*subdomain_.mesh, subdomain_.background.background(), geometry_.surface, {}},
        worker_(kernel_, 1, true),
        faces_(*subdomain_.mesh, geometry_.patch_inner) {}

  const InterfaceFaces& faces() const { return faces_; }
  Table expected() const { return expected_table(*subdomain_.mesh, geometry_); }

  /// Returns whether the mesh would have it.
  bool split(EdgeIndex e, bool from_other_end) {
    meshing::TetMesh& mesh = *subdomain_.mesh;
    auto [a, b] = faces_.ends(e);
    if (from_other_end) std::swap(a, b);
    std::vector<TetId> fans, tets;
    look_around(e, a, b, fans, tets);
    meshing::VertexOnEdge at;
    at.x = mesh.point(a) + 0.5 * (mesh.point(b) - mesh.point(a));
    at.log_metric = mesh.log_metric(a);
    for (const TetId t : fans) worker_.claims.claim_tet(t);
    const VertexId m = split_edge_at(worker_, a, b, fans, at);
    worker_.claims.release();
    if (m.valid()) faces_.split(e, a, m, tets);
    return m.valid();
  }

 private:
  void look_around(EdgeIndex e, VertexId a, VertexId b, std::vector<TetId>& fans, std::vector<TetId>& tets) {
    for (const TetFace face : faces_at(faces_, e)) {
      if (std::find(tets.begin(), tets.end(), face.tet()) != tets.end()) continue;
      worker_.claims.claim_tet(face.tet());
      ASSERT_EQ(gather_shell(*subdomain_.mesh, worker_.claims, face.tet(), a, b, worker_.shell),
                meshing::Verdict::accepted);
      worker_.claims.release();
      fans.push_back(face.tet());
      for (int i = 0; i < worker_.shell.size; ++i) tets.push_back(worker_.shell.tets[i].tet);
    }
  }

  const Geometry& geometry_;
  Subdomain subdomain_;
  meshing::Kernel kernel_;
  meshing::Worker worker_;
  InterfaceFaces faces_;
};

TEST(InterfaceFaces, StayTrueThroughManySplits) {
  std::size_t splits = 0, at_several_fans = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const Scene scene = random_scene(seed, 1);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name);
    const Cut cut = scene.cut();
    std::mt19937 random(seed);
    for (const SubdomainStart& start : cut.starts) {
      Splitting splitting(cut, start);
      const InterfaceFaces& faces = splitting.faces();
      ASSERT_EQ(table_of(faces), splitting.expected());
      for (int i = 0; i < 200 && faces.num_edges() > 0; ++i) {
        const auto e = static_cast<EdgeIndex>(random() % faces.num_edges());
        const std::size_t at_edge = faces_at(faces, e).size();
        if (at_edge == 0) continue;  // has been split
        const EdgeIndex first = faces.num_edges();
        if (!splitting.split(e, random() % 2)) continue;
        ++splits;
        at_several_fans += at_edge > 2;
        EXPECT_THAT(faces_at(faces, e), IsEmpty());
        EXPECT_EQ(faces.num_edges(), first + 2 + at_edge);  // two halves, one in each face
      }
      ASSERT_EQ(table_of(faces), splitting.expected());
    }
  }
  EXPECT_GT(splits, 2000u);
  EXPECT_GT(at_several_fans, 50u);
}

TEST(InterfaceFaces, AWholeMeshHasNone) {
  Scene scene;
  scene.mesh = unit_cube(3);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.3, 1);
  scene.part.assign(scene.mesh.tets.size(), SubdomainId(0));
  const Cut cut = scene.cut();
  EXPECT_EQ(Splitting(cut, cut.starts[0]).faces().num_edges(), 0u);
}

}  // namespace
}  // namespace weft::partition::interface_faces_test
