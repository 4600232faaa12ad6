// Shifts on random bodies cut at random: with nothing adapted between, so that every tet can be followed; and
// with.
#include "partition/shift/shift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include "meshing/adapt/adapt.h"
#include "meshing/fields/tet_locator.h"
#include "meshing/metric/measures.h"
#include "partition/output/merge_pieces.h"
#include "tests/partition/shift/shift_checks.h"
#include "tests/support/kernel.h"
#include "tests/support/repetitions.h"

namespace weft::partition::shift_test {
namespace {

using namespace weft::support;
using ::testing::ElementsAre;

/// What an adaptation leaves of the vertices that it could change.
void mark_as_free(std::vector<Subdomain>& subdomains) {
  for (Subdomain& s : subdomains)
    for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i)
      if (const meshing::VertexId v(i); s.mesh->alive(v) && !s.mesh->frozen(v))
        s.mesh->set_flags(v, s.mesh->flags(v) | kHasBeenFree);
}

std::uint64_t count(const Rounds::ForEach<GlobalId>& wants) {
  std::uint64_t n = 0;
  for (const auto& list : wants) n += list.size();
  return n;
}

/// The holder of highest priority of each wanted vertex.
std::map<GlobalId, Priority> winners_of(std::vector<Subdomain>& subdomains,
                                        const Rounds::ForEach<GlobalId>& wants,
                                        const std::vector<Priority>& priorities) {
  std::map<GlobalId, Priority> winners;
  for (const auto& list : wants)
    for (const GlobalId id : list) winners.try_emplace(id, Priority{0, SubdomainId(0)});
  for (auto& [id, winner] : winners)
    for (const Subdomain& s : subdomains)
      if (s.interface.find(id) != Interface::kNone) winner = std::max(winner, priorities[s.id.value]);
  return winners;
}

/// Tets at wanted vertices have gone to the highest of these vertices' winners; without layers no others have
/// moved.
void expect_winners_are_respected(const std::map<TetName, SubdomainId>& before,
                                  const std::map<TetName, SubdomainId>& after,
                                  const std::map<GlobalId, Priority>& winners, int layers) {
  ASSERT_EQ(before.size(), after.size());
  std::size_t lost = 0, wrong = 0;
  for (const auto& [tet, old_place] : before) {
    const auto now = after.find(tet);
    if (now == after.end()) {
      ++lost;
      continue;
    }
    const Priority* first = nullptr;
    for (const GlobalId v : tet)
      if (const auto at = winners.find(v); at != winners.end() && (!first || *first < at->second))
        first = &at->second;
    if (first || layers == 0) wrong += now->second != (first ? first->id : old_place);
  }
  EXPECT_EQ(lost, 0u);
  EXPECT_EQ(wrong, 0u);
}

/// A tet that has moved is at most so many layers of points away from a wanted vertex that its new subdomain
/// has won.
void expect_moves_are_near(const std::map<TetName, SubdomainId>& before,
                           const std::map<TetName, SubdomainId>& after,
                           const std::map<GlobalId, Priority>& winners, int layers) {
  std::map<std::pair<GlobalId, SubdomainId>, int> reached;  // vertex and who comes near -> layer
  for (const auto& [id, winner] : winners) reached[{id, winner.id}] = 0;
  std::map<SubdomainId, std::vector<const TetName*>> moved;
  for (const auto& [tet, place] : after)
    if (before.at(tet) != place) moved[place].push_back(&tet);
  for (auto& [receiver, tets] : moved) {
    for (int layer = 0; layer <= layers; ++layer)
      for (const auto& [tet, place] : before) {
        const bool near = std::any_of(tet.begin(), tet.end(), [&](GlobalId v) {
          const auto at = reached.find({v, receiver});
          return at != reached.end() && at->second <= layer;
        });
        if (near)
          for (const GlobalId v : tet) reached.try_emplace({v, receiver}, layer + 1);
      }
    for (const TetName* tet : tets)
      EXPECT_TRUE(std::all_of(tet->begin(), tet->end(), [&](GlobalId v) {
        return reached.contains({v, receiver});
      }));
  }
}

/// Those that receive from all their neighbours, by the order that Choice goes by: an independent set of the
/// graph of neighbours, not empty.
std::set<SubdomainId> receivers_from_all(std::vector<Subdomain>& subdomains,
                                         const std::vector<Priority>& priorities) {
  std::set<SubdomainId> receivers;
  for (const Subdomain& s : subdomains) {
    std::vector<Priority> neighbours;
    for (const SubdomainId n : s.interface.neighbours()) neighbours.push_back(priorities[n.value]);
    if (ReceiverOrder(priorities[s.id.value], neighbours).above_self() == 0) receivers.insert(s.id);
  }
  EXPECT_FALSE(receivers.empty());
  for (const Subdomain& s : subdomains)
    for (const SubdomainId n : s.interface.neighbours())
      EXPECT_FALSE(receivers.contains(s.id) && receivers.contains(n)) << s.id << " and " << n;
  return receivers;
}

/// They have given nothing away.
void expect_to_have_all(const std::set<SubdomainId>& receivers, const std::map<TetName, SubdomainId>& before,
                        const std::map<TetName, SubdomainId>& after) {
  for (const auto& [tet, place] : before)
    if (receivers.contains(place)) {
      EXPECT_EQ(after.at(tet), place);
    }
}

/// Shifts until nothing is wanted; every step is checked.
void shift_until_free(const Scene& scene, const ShiftOptions& options, unsigned seed) {
  const Cut cut = scene.cut();
  const ExpectedTotals totals = totals_of(scene.mesh);
  Rounds rounds(cut, scene.hausd(), options);
  std::mt19937 random(seed);
  expect_sound(rounds, totals);
  mark_as_free(rounds.subdomains());
  constexpr int kMostRounds = 100;
  int round = 0;
  for (; count(rounds.wants()) > 0 && round < kMostRounds; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const auto before = tets_of(rounds.subdomains());
    const auto wants = rounds.wants();
    const auto priorities = random_priorities(scene.subdomains, random);
    const auto winners = winners_of(rounds.subdomains(), wants, priorities);
    const std::set<SubdomainId> receivers = receivers_from_all(rounds.subdomains(), priorities);
    const std::uint64_t moved = rounds.shift(priorities);
    const auto after = tets_of(rounds.subdomains());
    EXPECT_GT(moved, 0u);
    expect_winners_are_respected(before, after, winners, options.layers);
    expect_to_have_all(receivers, before, after);
    if (!options.by_faces && options.layers < 4)
      expect_moves_are_near(before, after, winners, options.layers);
    mark_as_free(rounds.subdomains());
    EXPECT_EQ(rounds.update(), 0);
    expect_sound(rounds, totals);
    if (random() % 2) mark_as_free(rounds.subdomains());
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_LT(round, kMostRounds);
  EXPECT_EQ(count(rounds.wants()), 0u);
}

TEST(Shift, LosesNothingAndFreesEverything) {
  constexpr int kLayers[] = {0, 1, 3, 10};
  for (unsigned seed = 0; seed < 48; ++seed) {
    const Scene scene = random_scene(seed, 1);
    const ShiftOptions options{kLayers[seed % 4], seed / 4 % 2 == 1};
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name + ", layers " +
                 std::to_string(options.layers) + (options.by_faces ? " by faces" : " by points"));
    EXPECT_NO_THROW(shift_until_free(scene, options, seed));
    if (HasFailure()) return;
  }
}

TEST(Shift, LayersAreAsGivenAlsoLaterWhereTheyAreGiven) {
  for (const int layers : {0, 1, 5}) {
    const ShiftOptions by_default{layers, true}, as_given{layers, true, false};
    EXPECT_EQ(by_default.in_round(0).layers, layers);
    EXPECT_EQ(by_default.in_round(3).layers, std::min(layers, 1));
    for (const std::uint64_t round : {0, 3}) {
      EXPECT_EQ(as_given.in_round(round).layers, layers);
      EXPECT_TRUE(as_given.in_round(round).by_faces);
    }
  }
}

TEST(Shift, NothingMovesWhereNothingIsWanted) {
  Scene scene = random_scene(12, 1);
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  for (Subdomain& s : rounds.subdomains())
    for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
      const meshing::VertexId v = s.interface.local(i);
      s.mesh->set_flags(v, s.mesh->flags(v) | kHasBeenFree);
    }
  const auto before = tets_of(rounds.subdomains());
  std::mt19937 random(1);
  EXPECT_EQ(count(rounds.wants()), 0u);
  EXPECT_EQ(rounds.shift(random_priorities(scene.subdomains, random)), 0u);
  EXPECT_EQ(rounds.update(), 0);
  EXPECT_EQ(tets_of(rounds.subdomains()), before);
  expect_sound(rounds, totals_of(scene.mesh));
}

TEST(Shift, ProposesToEachNeighbourWhatItShares) {
  const Scene scene = random_scene(12, 1);
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  for (const Subdomain& s : rounds.subdomains()) {
    const std::vector<GlobalId> wants = wanted(s, 0);
    EXPECT_EQ(wants.size(), s.interface.size());  // nothing has been free
    EXPECT_TRUE(std::is_sorted(wants.begin(), wants.end()));
    const Priority mine{7, s.id};
    const auto proposals = propose(s, mine, wants);
    ASSERT_EQ(proposals.size(), s.interface.neighbours().size());
    for (std::size_t n = 0; n < proposals.size(); ++n) {
      EXPECT_EQ(proposals[n].priority, mine);
      std::vector<GlobalId> shared;
      for (std::uint32_t i = 0; i < s.interface.size(); ++i)
        if (s.interface.held_by(i, s.interface.neighbours()[n])) shared.push_back(s.interface.id(i));
      EXPECT_EQ(proposals[n].wants, shared);
    }
  }
}

TEST(Shift, HoldersKnowBeforeItWhichWantedVerticesTheyReceive) {
  for (unsigned seed = 10; seed < 14; ++seed) {
    const Scene scene = random_scene(seed, 1);
    const Cut cut = scene.cut();
    Rounds rounds(cut, scene.hausd(), {});
    std::mt19937 random(seed);
    const std::vector<Priority> priorities = random_priorities(rounds.subdomains().size(), random);
    auto wants = rounds.wants();
    for (std::size_t i = 0; i < wants.size(); i += 2)
      wants[i].clear();  // so that some is wanted by one holder
    std::map<SubdomainId, std::size_t> expected;
    for (const auto& [id, winner] : winners_of(rounds.subdomains(), wants, priorities)) ++expected[winner.id];
    for (const Subdomain& s : rounds.subdomains()) {
      std::vector<Proposal> arrived;
      for (const SubdomainId from : s.interface.neighbours()) {
        const Subdomain& other = rounds.subdomains()[from.value];
        const auto others = other.interface.neighbours();
        const auto place = std::ranges::find(others, s.id) - others.begin();
        arrived.push_back(
            propose(other, priorities[from.value], wants[from.value])[static_cast<std::size_t>(place)]);
      }
      const ReceiverOrder order(priorities[s.id.value], priorities_of(arrived));
      EXPECT_EQ(vertices_received(s, order, wants[s.id.value], arrived), expected[s.id]);
    }
  }
}

TEST(Shift, WantsWhatIsInThePoorTetsWay) {
  const Scene scene = random_scene(9, 1);
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  for (Subdomain& s : rounds.subdomains()) {
    meshing::TetMesh& mesh = *s.mesh;
    for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
      mesh.set_flags(meshing::VertexId(i), mesh.flags(meshing::VertexId(i)) | kHasBeenFree);
    for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) mesh.set_quality(meshing::TetId(i), 0.9f);
    EXPECT_TRUE(wanted(s, 0).empty());
    for (std::uint32_t poor = 0; poor < mesh.tet_slots(); poor += 7) {
      mesh.set_quality(meshing::TetId(poor), 0.3f);
      const meshing::TetVertices at = mesh.vertices(meshing::TetId(poor));
      std::set<GlobalId> near;
      for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
        const meshing::TetVertices v = mesh.vertices(meshing::TetId(i));
        if (std::find_first_of(v.begin(), v.end(), at.begin(), at.end()) == v.end()) continue;
        for (std::uint32_t k = 0; k < s.interface.size(); ++k)
          if (std::count(v.begin(), v.end(), s.interface.local(k))) near.insert(s.interface.id(k));
      }
      const std::vector<GlobalId> wants = wanted(s, kRoundsForQuality - 1);
      EXPECT_EQ(wants, std::vector<GlobalId>(near.begin(), near.end()));
      EXPECT_TRUE(wanted(s, kRoundsForQuality).empty());
      mesh.set_quality(meshing::TetId(poor), 0.9f);
    }
  }
}

/// Every third vertex counts as never free, every seventh tet as poor, and what is wanted is the same.
void mark_some(std::vector<Subdomain>& subdomains) {
  for (Subdomain& s : subdomains) {
    meshing::TetMesh& mesh = *s.mesh;
    for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
      if (s.global_id(meshing::VertexId(i)).value() % 3 != 0)
        mesh.set_flags(meshing::VertexId(i), mesh.flags(meshing::VertexId(i)) | kHasBeenFree);
    for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i)
      mesh.set_quality(meshing::TetId(i), i % 7 == 0 ? 0.55f : 0.9f);
  }
}

TEST(Shift, FreshIsWhatHasNeverBeenFreeAndWhatIsPoor) {
  std::size_t fresh = 0, poor = 0, spared = 0;
  for (unsigned seed = 9; seed < 13; ++seed) {
    const Scene scene = random_scene(seed, 1);
    const Cut cut = scene.cut();
    Rounds rounds(cut, scene.hausd(), {});
    mark_some(rounds.subdomains());
    std::vector<std::set<GlobalId>> frozen;
    for (const Subdomain& s : rounds.subdomains()) {
      auto& ids = frozen.emplace_back();
      for (std::uint32_t i = 0; i < s.interface.size(); ++i) ids.insert(s.interface.id(i));
    }
    std::mt19937 random(seed);
    rounds.shift(random_priorities(scene.subdomains, random));
    for (std::size_t k = 0; k < frozen.size(); ++k) {
      const Subdomain& s = rounds.subdomains()[k];
      const meshing::TetMesh& mesh = *s.mesh;
      for (std::uint32_t i = 0; i < mesh.tet_slots(); ++i) {
        const meshing::TetId t(i);
        if (!mesh.alive(t)) continue;
        bool thawed = false, never_free = false;
        for (const meshing::VertexId v : mesh.vertices(t)) {
          if (mesh.frozen(v) || !frozen[k].contains(s.global_id(v))) continue;
          thawed = true;
          never_free |= !(mesh.flags(v) & kHasBeenFree);
        }
        const bool is_poor = mesh.quality(t) < 0.6f;
        EXPECT_EQ((mesh.marks(t) & meshing::kFresh) != 0, thawed && (never_free || is_poor));
        fresh += never_free;
        poor += thawed && !never_free && is_poor;
        spared += thawed && !never_free && !is_poor;
      }
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(std::min({fresh, poor, spared}), 0u) << fresh << ' ' << poor << ' ' << spared;
}

/// Sums of coordinates, which tell tets of a mesh apart.
std::array<double, 3> key_of(std::array<meshing::Point, 4> corners) {
  std::ranges::sort(corners, {}, [](const meshing::Point& p) { return std::tuple(p.x, p.y, p.z); });
  meshing::Point sum;
  for (const meshing::Point& p : corners) sum += p;
  return {sum.x, sum.y, sum.z};
}

/// A fine cube that has become a few tets, each of which covers thousands of the input's; they are handed
/// over around one corner.
TEST(Shift, BackgroundTravelsWithTetsThatCoverThousandsOfTheInput) {
  Scene scene;
  scene.mesh = unit_cube(26);
  scene.log_metrics = uniform_metric(scene.mesh, 3);
  scene.part.assign(scene.mesh.tets.size(), SubdomainId(0));
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {0, false});
  rounds.options().coarsen = true;
  rounds.adapt(meshing::Extent::everything);
  Subdomain& s = rounds.subdomains()[0];
  ASSERT_LT(count_tets(s), 40u);
  const meshing::TetLocator input(scene.mesh,
                                  meshing::build_adjacency(scene.mesh.tets, scene.mesh.points.size()));
  const auto corners_of = [](const auto& points, const std::array<std::uint32_t, 4>& tet) {
    return std::array<meshing::Point, 4>{points[tet[0]], points[tet[1]], points[tet[2]], points[tet[3]]};
  };
  std::size_t moved = 0, without = 0;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> weight(0.02, 1);
  for (std::uint32_t i = 0; i < s.mesh->vertex_slots() && moved == 0; ++i) {
    if (!s.mesh->alive(meshing::VertexId(i))) continue;
    const GlobalId shared = s.global_id(meshing::VertexId(i));
    s.interface = Interface(std::vector<Holder>{{shared, SubdomainId(1)}});
    s.interface.set_local(0, meshing::VertexId(i));
    s.mesh->freeze(meshing::VertexId(i));
    const std::vector<Proposal> proposals{{{1, SubdomainId(1)}, {shared}, {}, {}}};
    const std::vector<Parcel> parcels = gather(s, {0, SubdomainId(0)}, {}, proposals, {0, false});
    std::set<std::array<double, 3>> there;
    for (const auto& piece : parcels[0].pieces)
      for (const auto& tet : piece->tets) there.insert(key_of(corners_of(piece->points, tet)));
    for (const Parcel::Tet& tet : parcels[0].tets)
      for (int k = 0; k < 4000; ++k) {
        double sum = 0;
        meshing::Point p;
        for (const std::uint32_t v : tet.vertices) {
          const double w = weight(random);
          p += w * parcels[0].vertices[v].point;
          sum += w;
        }
        const std::uint32_t at = input.locate((1 / sum) * p, meshing::TetLocator::kNoHint).tet;
        without += !there.contains(key_of(corners_of(scene.mesh.points, scene.mesh.tets[at])));
      }
    moved = parcels[0].tets.size();
  }
  EXPECT_GE(moved, 1u);
  EXPECT_EQ(without, 0u) << "of " << 4000 * moved << " points in " << moved << " tets";
}

/// Equal ids at different places: another arithmetic, or two vertices of one name.
TEST(Shift, CopiesOfAVertexThatDifferByTheLastBitAreRefused) {
  Scene scene;
  scene.mesh = unit_cube(4);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.3, 1);
  cut_at_random(scene, 2, 1, 1);
  const Cut cut = scene.cut();
  const std::vector<Priority> priorities{{0, SubdomainId(0)}, {1, SubdomainId(1)}};
  Rounds sound(cut, scene.hausd(), {2, false}), damaged(cut, scene.hausd(), {2, false});
  EXPECT_GT(sound.shift(priorities), 0u);
  Subdomain& s = damaged.subdomains()[0];
  const meshing::VertexId v = s.interface.local(3);
  meshing::Point p = s.mesh->point(v);
  p.x = std::nextafter(p.x, 2);
  s.mesh->set_point(v, p);
  try {
    damaged.shift(priorities);
    FAIL() << "nothing was noticed";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("subdomain 1: copies of vertex 0:"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("differ in their coordinates"));
  }
}

TEST(Shift, EqualPrioritiesAreOrderedBySubdomain) {
  EXPECT_LT((Priority{1, SubdomainId(5)}), (Priority{2, SubdomainId(0)}));
  EXPECT_LT((Priority{2, SubdomainId(0)}), (Priority{2, SubdomainId(5)}));
}

std::size_t count_interfaces(const std::vector<Subdomain>& subdomains) {
  std::size_t vertices = 0;
  for (const Subdomain& s : subdomains) vertices += s.interface.size();
  return vertices;
}

/// Where everything is that an adaptation must leave alone.
std::map<std::pair<SubdomainId, GlobalId>, std::array<double, 9>> frozen_places(
    const std::vector<Subdomain>& subdomains) {
  std::map<std::pair<SubdomainId, GlobalId>, std::array<double, 9>> places;
  for (const Subdomain& s : subdomains)
    for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
      const meshing::VertexId v = s.interface.local(i);
      if (!v.valid() || !s.mesh->alive(v)) continue;  // vanished: the table is too short
      const meshing::Point& p = s.mesh->point(v);
      const meshing::LogMetric& l = s.mesh->log_metric(v);
      places[{s.id, s.interface.id(i)}] = {p.x, p.y, p.z, l.xx, l.xy, l.yy, l.xz, l.yz, l.zz};
    }
  return places;
}

/// Conforming, and the same domain: exactly where the boundary is planar.
void expect_result(const MergedMesh& merged, const Scene& scene) {
  if (!scene.curved) return expect_same_domain(merged.mesh, scene.mesh);
  const meshing::CheckReport now = check_mesh(merged.mesh), before = check_mesh(scene.mesh);
  EXPECT_THAT(now.problems, ElementsAre());
  EXPECT_NEAR(now.volume, before.volume, 0.2 * before.volume);  // of a coarse polyhedron in a ball
}

/// Two phases to coarser metrics, everything checked after each step.
void adapt_coarsely(Rounds& rounds, const Scene& scene, const std::optional<ExpectedTotals>& totals,
                    std::mt19937& random) {
  const meshing::Limits wanted = rounds.limits();
  for (const double coarseness : {3.0, 1.5}) {
    SCOPED_TRACE("coarse by " + std::to_string(coarseness));
    rounds.limits() = wanted.coarser(coarseness);
    if (coarseness > 2)
      rounds.adapt(meshing::Extent::everything);
    else
      rounds.adapt_interiors();
    expect_sound(rounds, totals);
    for (int shift = 0; shift < 2; ++shift) {
      SCOPED_TRACE("shift " + std::to_string(shift));
      rounds.shift(random_priorities(scene.subdomains, random));
      if (shift == 0) rounds.adapt(meshing::Extent::fresh);
      EXPECT_EQ(rounds.update(), 0);
      expect_sound(rounds, totals);
    }
    rounds.begin_next_phase();
    EXPECT_EQ(count(rounds.wants()), count_interfaces(rounds.subdomains()));
  }
  rounds.limits() = wanted;
}

/// The whole method on one scene, everything checked after each step.
void adapt_until_free(const Scene& scene, const ShiftOptions& options, bool refine, unsigned seed,
                      bool coarse_first = false) {
  const Cut cut = scene.cut();
  std::optional<ExpectedTotals> totals;
  if (!scene.curved) totals = totals_of(scene.mesh);
  Rounds rounds(cut, scene.hausd(), options);
  std::mt19937 random(seed);
  const auto adapt = [&](meshing::Extent extent) {
    const auto before = frozen_places(rounds.subdomains());
    rounds.adapt(extent);
    EXPECT_EQ(frozen_places(rounds.subdomains()), before);
  };
  if (coarse_first) adapt_coarsely(rounds, scene, totals, random);
  if (refine)
    rounds.adapt_interiors();
  else
    adapt(meshing::Extent::everything);
  expect_sound(rounds, totals);
  constexpr int kMostRounds = 60;
  int round = 0;
  for (; count(rounds.wants()) > 0 && round < kMostRounds; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    rounds.shift(random_priorities(scene.subdomains, random));
    adapt(meshing::Extent::fresh);
    EXPECT_EQ(rounds.update(), 0);
    expect_sound(rounds, totals);
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_LT(round, kMostRounds);
  expect_result(merge_pieces(rounds.pieces()), scene);
}

TEST(AdaptedShifts, KeepTheDomainAndFreeEverything) {
  constexpr int kLayers[] = {3, 1, 0, 10};
  for (unsigned seed = 0; seed < repetitions(12, 24); ++seed) {
    const Scene scene = random_scene(seed, 1.5);
    const ShiftOptions options{kLayers[seed % 4], seed / 4 % 2 == 1};
    const bool refine = seed % 3 != 2;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name + ", layers " +
                 std::to_string(options.layers) + (options.by_faces ? " by faces" : " by points") +
                 (refine ? ", refined" : ""));
    EXPECT_NO_THROW(adapt_until_free(scene, options, refine, seed));
    if (HasFailure()) return;
  }
}

TEST(AdaptedShifts, AfterCoarsePhasesToo) {
  for (unsigned seed = 0; seed < repetitions(12, 24); ++seed) {
    const Scene scene = random_scene(seed, 1);
    const bool refine = seed % 3 != 2;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name + (refine ? ", refined" : ""));
    EXPECT_NO_THROW(adapt_until_free(scene, {2, seed / 4 % 2 == 1}, refine, seed, true));
    if (HasFailure()) return;
  }
}

/// All rounds that it takes. Poor tets at frozen vertices are left to the next as long as one can follow.
MergedMesh adapt_in_parts(const Scene& scene) {
  constexpr int kMostRounds = 8;
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {3, false});
  std::mt19937 random(1);
  rounds.options().repair_at_frozen = false;
  rounds.adapt_interiors();
  for (int round = 0; count(rounds.wants()) > 0 && round < kMostRounds; ++round) {
    rounds.options().repair_at_frozen = round + 1 == kMostRounds;
    rounds.shift(random_priorities(scene.subdomains, random));
    rounds.adapt(meshing::Extent::fresh);
    EXPECT_EQ(rounds.update(), 0);
  }
  EXPECT_EQ(count(rounds.wants()), 0u);
  return merge_pieces(rounds.pieces());
}

Scene polar_scene() {
  Scene scene;
  scene.mesh = unit_cube(5);
  shuffle(scene.mesh, 3);
  scene.log_metrics = meshing::sample(meshing::AnalyticMetric("polar-2"), scene.mesh);
  meshing::scale_to_complexity(scene.mesh, 1500, scene.log_metrics);
  cut_at_random(scene, 8, 0, 3);
  return scene;
}

TEST(AdaptedShifts, AreAsGoodAsOnePiece) {
  const Scene scene = polar_scene();
  const MergedMesh parts = adapt_in_parts(scene);
  meshing::AdaptOptions options;
  options.hausd = scene.hausd();
  const meshing::AdaptResult whole = meshing::adapt(scene.mesh, {&scene.mesh, &scene.log_metrics}, options);
  const meshing::Measures in_parts = measure(parts.mesh, parts.log_metrics);
  const meshing::Measures in_one = measure(whole.mesh, whole.log_metrics);
  EXPECT_GT(in_parts.quality_mean, 0.97 * in_one.quality_mean);
  EXPECT_GT(in_parts.edges_unit, 0.97 * in_one.edges_unit);
  EXPECT_GT(in_parts.quality_q01, 0.9 * in_one.quality_q01);
  // Cuts differ: eight of them lie between 1.03 and 1.07.
  EXPECT_NEAR(static_cast<double>(in_parts.num_tets) / static_cast<double>(in_one.num_tets), 1, 0.09);
}

int poor_tets_at_frozen(const Cut& cut, double hausd, bool repair) {
  Rounds rounds(cut, hausd, {});
  rounds.options().repair_at_frozen = repair;
  rounds.adapt(meshing::Extent::everything);
  int poor = 0;
  for (const Subdomain& s : rounds.subdomains())
    for (std::uint32_t t = 0; t < s.mesh->tet_slots(); ++t) {
      const meshing::TetId tet(t);
      if (!s.mesh->alive(tet) || s.mesh->quality(tet) >= 0.4) continue;
      poor += std::ranges::any_of(s.mesh->vertices(tet), [&](auto v) { return s.mesh->frozen(v); });
    }
  return poor;
}

TEST(AdaptedShifts, PoorTetsAtFrozenVerticesAreRepairedWhereAskedFor) {
  const Scene scene = polar_scene();
  const Cut cut = scene.cut();
  EXPECT_LT(poor_tets_at_frozen(cut, scene.hausd(), true),
            0.9 * poor_tets_at_frozen(cut, scene.hausd(), false));
}

}  // namespace
}  // namespace weft::partition::shift_test
