// Damage that an operator, a message or another machine might do to subdomains is found, and named.
#include "partition/verify/check_subdomains.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tests/partition/shift/shift_checks.h"

namespace weft::partition::check_subdomains_test {
namespace {

using namespace weft::support;
using meshing::TetId;
using meshing::VertexId;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Scene scene_of_four() {
  Scene scene;
  scene.mesh = unit_cube(4);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.2, 1);
  cut_at_random(scene, 4, 0, 1);
  return scene;
}

PiecesReport check(const std::vector<Subdomain>& subdomains, const Geometry& geometry,
                   const std::optional<ExpectedTotals>& totals = {}) {
  std::vector<const Subdomain*> mine;
  for (const Subdomain& s : subdomains) mine.push_back(&s);
  SelfPeers peers;
  return check_subdomains(peers, mine, geometry, totals);
}

/// What is found after damage to the first subdomain, at its first vertex of the interface.
std::vector<std::string> problems_after(const std::function<void(Subdomain&, VertexId)>& damage) {
  const Scene scene = scene_of_four();
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  rounds.refine_interfaces();
  Subdomain& s = rounds.subdomains()[0];
  damage(s, s.interface.local(0));
  return check(rounds.subdomains(), rounds.geometry(), totals_of(scene.mesh)).problems;
}

TEST(CheckSubdomains, FindsNothingBetweenTheStepsOfARun) {
  const Scene scene = scene_of_four();
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  const ExpectedTotals totals = totals_of(scene.mesh);
  const auto sound = [&] { return check(rounds.subdomains(), rounds.geometry(), totals).problems; };
  EXPECT_THAT(sound(), IsEmpty());
  rounds.adapt_interiors();
  EXPECT_THAT(sound(), IsEmpty());
  std::mt19937 random(1);
  rounds.shift(random_priorities(4, random));
  rounds.adapt(meshing::Extent::fresh);
  rounds.update();
  EXPECT_THAT(sound(), IsEmpty());
}

TEST(CheckSubdomains, LeavesTheSubdomainsAsTheyAre) {
  const Scene scene = scene_of_four();
  const Cut cut = scene.cut();
  Rounds checked(cut, scene.hausd(), {}), plain(cut, scene.hausd(), {});
  for (Rounds* rounds : {&checked, &plain}) rounds->adapt_interiors();
  check(checked.subdomains(), checked.geometry());
  for (Rounds* rounds : {&checked, &plain}) {
    std::mt19937 random(3);
    rounds->shift(random_priorities(4, random));
    rounds->adapt(meshing::Extent::fresh);
    rounds->update();
  }
  EXPECT_EQ(tets_of(checked.subdomains()), tets_of(plain.subdomains()));
}

TEST(CheckSubdomains, FindsAnInterfaceVertexThatMovedByTheLastBit) {
  std::ostringstream vertex;
  const auto problems = problems_after([&](Subdomain& s, VertexId v) {
    vertex << "vertex " << s.global_id(v) << ": its copies in subdomains 0 and ";
    meshing::Point p = s.mesh->point(v);
    p.y = std::nextafter(p.y, 2);
    s.mesh->set_point(v, p);
  });
  EXPECT_THAT(problems, ::testing::Contains(::testing::AllOf(
                            HasSubstr(vertex.str()), HasSubstr("differ in place (found on rank 0)"))));
}

TEST(CheckSubdomains, FindsATetThatIsGone) {
  const auto problems = problems_after([](Subdomain& s, VertexId v) {
    const TetId t = s.mesh->tet_of(v);
    for (int f = 0; f < 4; ++f)
      if (const meshing::TetFace n = s.mesh->neighbour(t, f); n.valid())
        s.mesh->set_neighbour(n.tet(), n.face(), {});
    for (const VertexId x : s.mesh->vertices(t))
      for (std::uint32_t i = 0; i < s.mesh->tet_slots(); ++i)
        if (const TetId other(i); other != t && s.mesh->alive(other) && s.mesh->local_index(other, x) >= 0)
          s.mesh->set_tet_of(x, other);
    s.mesh->kill(t);
  });
  EXPECT_THAT(problems, ::testing::Not(IsEmpty()));
}

TEST(CheckSubdomains, FindsANeighbourThatIsNotMutual) {
  const auto problems = problems_after([](Subdomain& s, VertexId v) {
    const TetId t = s.mesh->tet_of(v);
    for (int f = 0; f < 4; ++f)
      if (const meshing::TetFace n = s.mesh->neighbour(t, f); n.valid())
        return s.mesh->set_neighbour(n.tet(), n.face(), {});
  });
  EXPECT_THAT(problems, ::testing::Contains(HasSubstr("does not know it")));
}

TEST(CheckSubdomains, FindsAVertexOfTheInterfaceThatIsNotFrozen) {
  const auto problems = problems_after([](Subdomain& s, VertexId v) { s.mesh->thaw(v); });
  EXPECT_THAT(problems, ::testing::Contains(HasSubstr("of the interface, is not frozen")));
}

TEST(CheckSubdomains, FindsAHolderThatIsNotNamed) {
  const auto problems = problems_after([](Subdomain& s, VertexId) {
    std::vector<Holder> lines(s.interface.lines().begin(), s.interface.lines().end());
    for (const Holder& line : std::vector<Holder>(lines))
      if (s.interface.others(s.interface.find(line.vertex)).size() > 1) {
        std::erase(lines, line);
        break;
      }
    s.interface = Interface(std::move(lines));
    locate_interface(s);
  });
  EXPECT_THAT(problems, ::testing::Contains(HasSubstr("subdomain 0 does not name subdomain")));
}

TEST(CheckSubdomains, TheTotalsToKeepAllowForCurvedBoundary) {
  PiecesReport first;
  first.volume = 4;
  first.area_by_ref = {{1, 10}, {2, 2}};
  const Scene box = scene_of_four();
  const Cut planar = box.cut();
  EXPECT_EQ(totals_to_keep(first, planar.geometry, 0.01).area_by_ref, first.area_by_ref);
  EXPECT_EQ(totals_to_keep(first, planar.geometry, 0.01).volume_tolerance, 0);
  Scene ball = random_body(2);
  ball.log_metrics = wanted_sizes(ball.mesh, 0.3, 1);
  cut_at_random(ball, 2, 0, 1);
  const Cut curved = ball.cut();
  EXPECT_FALSE(totals_to_keep(first, curved.geometry, 0.01).areas_known);
  EXPECT_NEAR(totals_to_keep(first, curved.geometry, 0.01).volume_tolerance, 0.24, 1e-12);
}

TEST(ThrowIfViolated, NamesWhenAndWhat) {
  PiecesReport report;
  EXPECT_NO_THROW(throw_if_violated(report, "after shift 1"));
  report.problems = {"subdomain 3: a"};
  report.num_problems = 5;
  try {
    throw_if_violated(report, "after shift 1");
    FAIL();
  } catch (const InvariantViolation& error) {
    EXPECT_STREQ(error.what(),
                 "an invariant of the subdomains is violated after shift 1\n  subdomain 3: a\n  and 4 more");
  }
}

class InterfaceSnapshots : public ::testing::Test {
 protected:
  InterfaceSnapshots() : scene_(scene_of_four()), cut_(scene_.cut()), rounds_(cut_, scene_.hausd(), {}) {
    rounds_.adapt_interiors();
  }
  Subdomain& subdomain() { return rounds_.subdomains()[1]; }

  std::string issue(const std::function<void(Subdomain&, VertexId)>& during) {
    const InterfaceSnapshot before(subdomain());
    during(subdomain(), subdomain().interface.local(2));
    try {
      before.check(subdomain());
    } catch (const InvariantViolation& error) {
      return error.what();
    }
    return "";
  }

  Scene scene_;
  Cut cut_;
  Rounds rounds_;
};

TEST_F(InterfaceSnapshots, HoldThroughAnAdaptation) {
  EXPECT_EQ(issue([&](Subdomain&, VertexId) { rounds_.adapt(meshing::Extent::everything); }), "");
}

TEST_F(InterfaceSnapshots, SeeAMoveByTheLastBit) {
  EXPECT_THAT(issue([](Subdomain& s, VertexId v) {
                meshing::Point p = s.mesh->point(v);
                p.z = std::nextafter(p.z, -2);
                s.mesh->set_point(v, p);
              }),
              ::testing::AllOf(HasSubstr("subdomain 1: vertex "), HasSubstr("moved during an adaptation")));
}

TEST_F(InterfaceSnapshots, SeeAVertexThatIsGone) {
  EXPECT_THAT(issue([](Subdomain& s, VertexId v) { s.mesh->thaw(v); }), HasSubstr("vanished or was thawed"));
}

}  // namespace
}  // namespace weft::partition::check_subdomains_test
