// Sound pieces pass; every kind of damage is found, in the same words on all ranks.
#include "partition/verify/check_pieces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <mutex>

#include "meshing/mesh/check_mesh.h"
#include "tests/partition/output/piece_support.h"

namespace weft::partition::check_pieces_test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

PiecesReport check_on(int ranks, const std::vector<MeshPiece>& pieces,
                      const std::optional<ExpectedTotals>& expected = {}, int max_problems = 20) {
  const auto hands = deal(pieces, ranks, static_cast<unsigned>(ranks));
  std::mutex mutex;
  std::vector<PiecesReport> reports;
  run_on_ranks(ranks, [&](Peers& peers) {
    const PiecesReport report = check_pieces(peers, hands[peers.rank()], expected, max_problems);
    const std::lock_guard lock(mutex);
    reports.push_back(report);
  });
  for (const PiecesReport& report : reports) {
    EXPECT_EQ(report.problems, reports[0].problems);
    EXPECT_EQ(report.num_problems, reports[0].num_problems);
    EXPECT_EQ(report.volume, reports[0].volume);
    EXPECT_EQ(report.area_by_ref, reports[0].area_by_ref);
  }
  return reports[0];
}

ExpectedTotals totals_of(const MergedMesh& whole) {
  const meshing::CheckReport report = meshing::check_mesh(whole.mesh);
  EXPECT_TRUE(report.ok());
  return {report.volume, report.area_by_ref};
}

TEST(CheckPieces, SoundPiecesPassAndAddUp) {
  for (unsigned seed = 0; seed < 21; ++seed) {
    SCOPED_TRACE(seed);
    const CutMesh cut = random_cut(seed);
    const ExpectedTotals totals = totals_of(cut.whole);
    ASSERT_EQ(totals.area_by_ref.size(), 2u);  // boundary and material interface
    for (const int ranks : kRankCounts) {
      const PiecesReport report = check_on(ranks, cut.pieces, totals);
      EXPECT_THAT(report.problems, ElementsAre());
      EXPECT_TRUE(report.ok());
      EXPECT_NEAR(report.volume, 1, 1e-13);
    }
  }
}

TEST(CheckPieces, NoPiecesPass) { EXPECT_TRUE(check_on(3, {}).ok()); }

/// Two tets that share a face, vertices (0, 1, 2), each in a piece; then the damage. The first has vertex 3,
/// the second vertex 4. Returns the problems, the same for any ranks.
std::vector<std::string> problems_after(const std::function<void(MeshPiece&, MeshPiece&)>& damage,
                                        const std::optional<ExpectedTotals>& expected = {}) {
  MergedMesh whole{support::two_tets(), {}};
  whole.log_metrics.resize(whole.mesh.points.size());
  std::vector<MeshPiece> pieces = Cutter(whole, subdomain_ids({0, 1}), 2).cut();
  damage(pieces[0], pieces[1]);
  const PiecesReport report = check_on(1, pieces, expected);
  EXPECT_EQ(report.num_problems, report.problems.size());
  for (const int ranks : kRankCounts) EXPECT_EQ(check_on(ranks, pieces, expected).problems, report.problems);
  return report.problems;
}

/// The local number of the vertex that the input called `number`.
std::uint32_t local(const MeshPiece& piece, std::uint64_t number) {
  for (std::uint32_t v = 0; v < piece.ids.size(); ++v)
    if (piece.ids[v].local() == number) return v;
  ADD_FAILURE() << "no vertex " << number;
  return 0;
}

TEST(CheckPieces, TwoTetsPass) {
  EXPECT_THAT(problems_after([](auto&, auto&) {}), ElementsAre());
  EXPECT_THAT(problems_after([](auto& a, auto&) { EXPECT_EQ(a.shared.size(), 3u); }), ElementsAre());
}

TEST(CheckPieces, FindsATetInTwoPieces) {
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece& b) {
                const SubdomainId self = b.subdomain;
                b = a;
                b.subdomain = self;
                a.shared.clear();
                b.shared.clear();
                for (std::uint32_t v = 0; v < 4; ++v) {
                  a.shared.push_back({v, SubdomainId(1)});
                  b.shared.push_back({v, SubdomainId(0)});
                }
              }),
              Contains("tet 1 of subdomain 0 and tet 1 of subdomain 1: have the same vertices"));
}

TEST(CheckPieces, FindsATetTwiceInOnePiece) {
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) {
                a.mesh.tets.push_back(a.mesh.tets[0]);
                a.mesh.tet_refs.push_back(a.mesh.tet_refs[0]);
              }),
              Contains("tet 1 of subdomain 0 and tet 2 of subdomain 0: have the same vertices"));
}

TEST(CheckPieces, FindsInvertedAndFlatTets) {
  const auto inverted =
      problems_after([](MeshPiece& a, MeshPiece&) { std::swap(a.mesh.tets[0][0], a.mesh.tets[0][1]); });
  EXPECT_THAT(inverted, Contains("subdomain 0: tet 1: inverted (its orientation is negative)"));
  const auto flat = problems_after([](MeshPiece& a, MeshPiece&) {
    a.mesh.points[local(a, 3)] = midpoint(a.mesh.points[local(a, 0)], a.mesh.points[local(a, 1)]);
  });
  EXPECT_THAT(flat, Contains("subdomain 0: tet 1: flat (its orientation is zero)"));
}

TEST(CheckPieces, FindsTwoTetsOnOneSideOfAFace) {
  // The second tet moves to the side of the first.
  EXPECT_THAT(
      problems_after([](MeshPiece& a, MeshPiece& b) {
        b.mesh.points[local(b, 4)] = a.mesh.points[local(a, 3)];
        std::swap(b.mesh.tets[0][0], b.mesh.tets[0][1]);
      }),
      ElementsAre("face (0:0 0:1 0:2) between subdomains 0 and 1: both tets lie on the same side of it"));
}

TEST(CheckPieces, FindsAFaceWithoutATetOnItsOtherSide) {
  EXPECT_THAT(
      problems_after([](MeshPiece& a, MeshPiece& b) {
        b = MeshPiece{.subdomain = SubdomainId(1), .mesh = {}, .log_metrics = {}, .ids = {}, .shared = {}};
        a.shared.clear();
      }),
      ElementsAre("subdomain 0: face (0:0 0:1 0:2) of tet 1: without a triangle and without a tet on its "
                  "other side"));
}

TEST(CheckPieces, FindsAMissingTriangle) {
  EXPECT_THAT(
      problems_after([](MeshPiece& a, MeshPiece&) {
        a.mesh.triangles.pop_back();
        a.mesh.triangle_refs.pop_back();
      }),
      ElementsAre(AllOf(HasSubstr("subdomain 0: face ("), HasSubstr("without a triangle and without"))));
}

TEST(CheckPieces, FindsTrianglesThatAreNoFacesOrTwice) {
  const auto no_face = problems_after([](MeshPiece& a, MeshPiece&) {
    a.mesh.points.push_back({9, 9, 9});
    a.mesh.point_refs.push_back(0);
    a.log_metrics.emplace_back();
    a.ids.emplace_back(SubdomainId(0), 77);
    a.mesh.triangles.push_back({0, 1, 4});
    a.mesh.triangle_refs.push_back(1);
  });
  EXPECT_THAT(no_face, ElementsAre("subdomain 0: triangle 4: is not a face of any tet"));
  const auto twice = problems_after([](MeshPiece& a, MeshPiece&) {
    a.mesh.triangles.push_back(a.mesh.triangles[2]);
    a.mesh.triangle_refs.push_back(1);
  });
  EXPECT_THAT(twice, ElementsAre(HasSubstr("have the same vertices")));
}

/// Puts a triangle on the face that the two tets share.
void add_interface_triangle(MeshPiece& piece, std::int32_t ref) {
  piece.mesh.triangles.push_back({local(piece, 0), local(piece, 1), local(piece, 2)});
  piece.mesh.triangle_refs.push_back(ref);
}

TEST(CheckPieces, FindsTrianglesThatTheTwoSidesDisagreeAbout) {
  const std::string face = "face (0:0 0:1 0:2) between subdomains 0 and 1: ";
  const auto both = [](MeshPiece& a, MeshPiece& b) {
    add_interface_triangle(a, 5);
    add_interface_triangle(b, 5);
  };
  EXPECT_THAT(problems_after(both), ElementsAre());
  EXPECT_THAT(problems_after([](MeshPiece&, MeshPiece& b) { add_interface_triangle(b, 5); }),
              ElementsAre(face + "only one of them has its triangle"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece& b) {
                add_interface_triangle(a, 4);
                add_interface_triangle(b, 5);
              }),
              ElementsAre(face + "its triangle has two references"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) { a.mesh.tet_refs[0] = 9; }),
              ElementsAre(face + "the tets have different references, but there is no triangle"));
}

TEST(CheckPieces, FindsFacesOfThreeTets) {
  const std::vector<meshing::Point> points = {{0, 0, 0}, {1, 0, 0},  {0, 1, 0},
                                              {0, 0, 1}, {0, 0, -1}, {0, 0, 2}};
  MergedMesh whole{{}, {}};
  whole.mesh.points = points;
  whole.mesh.point_refs.assign(6, 0);
  whole.mesh.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}};
  whole.mesh.tet_refs.assign(3, 1);
  whole.log_metrics.resize(6);
  const std::string face = "(0:0 0:1 0:2): shared by 3 ";
  EXPECT_THAT(check_on(2, Cutter(whole, subdomain_ids({0, 1, 2}), 3).cut()).problems,
              Contains("face " + face + "subdomains"));
  EXPECT_THAT(check_on(2, Cutter(whole, subdomain_ids({0, 0, 0}), 1).cut()).problems,
              Contains("subdomain 0: face " + face + "tets"));
  EXPECT_THAT(check_on(2, Cutter(whole, subdomain_ids({0, 1, 0}), 2).cut()).problems,
              Contains("subdomain 0: face (0:0 0:1 0:2): tets 1 and 2 lie on the same side of it"));
  whole.mesh.tet_refs[1] = 2;
  EXPECT_THAT(
      check_on(2, Cutter(whole, subdomain_ids({0, 0, 1}), 2).cut()).problems,
      Contains("subdomain 0: face (0:0 0:1 0:2): between tets 1 and 2 of different references without a "
               "triangle"));
}

TEST(CheckPieces, FindsCopiesThatDiffer) {
  EXPECT_THAT(problems_after([](MeshPiece&, MeshPiece& b) {
                double& x = b.mesh.points[local(b, 1)].x;
                x = std::nextafter(x, 2);
              }),
              ElementsAre("vertex 0:1: its copies in subdomains 0 and 1 differ in place"));
  EXPECT_THAT(problems_after([](MeshPiece&, MeshPiece& b) { b.log_metrics[local(b, 2)].yz = -0.0; }),
              ElementsAre("vertex 0:2: its copies in subdomains 0 and 1 differ in metric"));
}

TEST(CheckPieces, FindsHoldersThatAreWrong) {
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) {
                std::erase(a.shared, SubdomainStart::Shared{local(a, 1), SubdomainId(1)});
              }),
              ElementsAre("vertex 0:1: subdomain 0 does not name subdomain 1, which has it too"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) {
                a.shared.push_back({local(a, 3), SubdomainId(1)});
                std::ranges::sort(a.shared);
              }),
              ElementsAre("vertex 0:3: subdomain 0 names subdomain 1, which does not have it"));
  EXPECT_THAT(problems_after([](MeshPiece&, MeshPiece& b) {
                b.shared.push_back({local(b, 0), SubdomainId(17)});
                std::ranges::sort(b.shared);
              }),
              ElementsAre("vertex 0:0: subdomain 1 names subdomain 17, which does not have it"));
}

TEST(CheckPieces, FindsTwoPiecesOfOneSubdomain) {
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece& b) {
                b.subdomain = SubdomainId(0);
                a.shared.clear();
                b.shared.clear();
              }),
              Contains("vertex 0:0: two pieces of subdomain 0 have it"));
}

TEST(CheckPieces, FindsArraysThatDoNotFit) {
  EXPECT_THAT(problems_after([](MeshPiece&, MeshPiece& b) { b.ids.pop_back(); }),
              ElementsAre("subdomain 1: 3 global ids and 4 metrics for 4 vertices"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) { a.mesh.tets[0][2] = 4; }),
              ElementsAre("subdomain 0: tet 1: vertex 5 is out of range (4 points)"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) { a.ids[3] = a.ids[2]; }),
              ElementsAre("subdomain 0: two vertices have the global id 0:2"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) { a.ids[3] = GlobalId(); }),
              ElementsAre("subdomain 0: a vertex has no global id"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) { a.shared[2].other = SubdomainId(0); }),
              ElementsAre("subdomain 0: holders of vertices 3: names vertex 3 and subdomain 0"));
  EXPECT_THAT(problems_after([](MeshPiece& a, MeshPiece&) { std::swap(a.shared[0], a.shared[1]); }),
              ElementsAre("subdomain 0: holders of vertices 2: are not sorted"));
}

TEST(CheckPieces, FindsTotalsThatAreOff) {
  MergedMesh whole{support::two_tets(), {}};
  whole.log_metrics.resize(5);
  const ExpectedTotals totals = totals_of(whole);
  EXPECT_THAT(problems_after([](auto&, auto&) {}, totals), ElementsAre());
  ExpectedTotals off = totals;
  off.volume *= 1 + 2e-9;
  EXPECT_THAT(problems_after([](auto&, auto&) {}, off), ElementsAre(HasSubstr("the volume: ")));
  off = totals;
  off.area_by_ref[1] *= 1 - 2e-9;
  off.area_by_ref[7] = 0.5;
  EXPECT_THAT(problems_after([](auto&, auto&) {}, off),
              ElementsAre(HasSubstr("the area of triangles of reference 1: "),
                          "the area of triangles of reference 7: 0 instead of 0.5"));
}

TEST(CheckPieces, CountsMoreProblemsThanItNames) {
  CutMesh cut = random_cut(5);
  for (MeshPiece& piece : cut.pieces) piece.shared.clear();
  for (const int ranks : kRankCounts) {
    const PiecesReport report = check_on(ranks, cut.pieces, {}, 3);
    EXPECT_EQ(report.problems.size(), 3u);
    EXPECT_EQ(report.num_problems, check_on(1, cut.pieces, {}, 1000000).problems.size());
  }
}

/// Damages one entry of one random piece: some problem must be found.
TEST(CheckPieces, FindsRandomDamage) {
  std::mt19937 random(11);
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    CutMesh cut = random_cut(seed % 7 + 7);
    MeshPiece* piece = nullptr;
    while (!piece || piece->mesh.tets.empty()) piece = &cut.pieces[random() % cut.pieces.size()];
    const std::size_t t = random() % piece->mesh.tets.size();
    switch (seed % 3) {
      case 0:
        piece->mesh.tets.erase(piece->mesh.tets.begin() + static_cast<std::ptrdiff_t>(t));
        piece->mesh.tet_refs.pop_back();
        break;
      case 1:
        std::swap(piece->mesh.tets[t][1], piece->mesh.tets[t][2]);
        break;
      default:
        piece->ids[piece->mesh.tets[t][0]] = GlobalId(SubdomainId(99), 1);
    }
    const PiecesReport report = check_on(2, cut.pieces, totals_of(cut.whole));
    // A vertex of one piece alone may have any name.
    const bool renamed_inner = seed % 3 == 2 && std::ranges::none_of(piece->shared, [&](const auto& shared) {
                                 return shared.vertex == piece->mesh.tets[t][0];
                               });
    EXPECT_EQ(report.ok(), renamed_inner);
  }
}

}  // namespace
}  // namespace weft::partition::check_pieces_test
