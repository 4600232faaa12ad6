// Interfaces refined on all sides without a word between them: the sides agree, and what must stay stays.
#include "partition/refine/refine_interface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>
#include <string>

#include "meshing/kernel/kernel.h"
#include "meshing/kernel/quality.h"
#include "partition/output/merge_pieces.h"
#include "tests/partition/shift/shift_checks.h"
#include "tests/support/kernel.h"
#include "tests/support/repetitions.h"

namespace weft::partition::refine_interface_test {
namespace {

using namespace weft::support;
using meshing::TetId;
using meshing::VertexId;

using EdgeName = std::pair<GlobalId, GlobalId>;
using Edges = std::map<EdgeName, std::pair<VertexId, VertexId>>;

EdgeName name_of(const Subdomain& s, VertexId a, VertexId b) {
  return std::minmax(s.global_id(a), s.global_id(b));
}

/// The edges of the faces beyond which others have their tets.
Edges interface_edges(const Subdomain& s, const Geometry& geometry) {
  Edges edges;
  for (std::uint32_t i = 0; i < s.mesh->tet_slots(); ++i)
    for (int f = 0; f < 4; ++f) {
      const TetId t(i);
      if (!s.mesh->alive(t) || s.mesh->neighbour(t, f).valid()) continue;
      const meshing::PatchId patch = s.mesh->patch(t, f);
      if (patch.valid() && !geometry.patch_inner[patch.value]) continue;
      for (int k = 0; k < 3; ++k) {
        const VertexId a = s.mesh->vertex(t, meshing::kTetFaces[f][k]);
        const VertexId b = s.mesh->vertex(t, meshing::kTetFaces[f][(k + 1) % 3]);
        edges.emplace(name_of(s, a, b), std::pair(a, b));
      }
    }
  return edges;
}

bool must_stay(const Subdomain& s, const Geometry& geometry, VertexId a, VertexId b) {
  const meshing::TetMesh& mesh = *s.mesh;
  const meshing::CurveId curve = mesh.curve(a, b);
  return (mesh.flags(a) & mesh.flags(b) & (meshing::kOnCurved | meshing::kFixed)) != 0 ||
         ((mesh.flags(a) | mesh.flags(b)) & kDelicate) != 0 ||
         (curve.valid() && geometry.surface.curves()[curve.value].required);
}

/// From a vertex whose long edges may have to stay to a new one: the one kind of long edge that may be left
/// besides.
bool may_near_what_stays(const Subdomain& s, VertexId a, VertexId b) {
  constexpr int kKept = meshing::kOnCurved | meshing::kFixed;
  const auto leads = [&](VertexId from, VertexId to) {
    return (s.mesh->flags(from) & kKept) && !s.global_id(from).derived() && s.global_id(to).derived();
  };
  return leads(a, b) || leads(b, a);
}

/// As import_mesh sets up a random scene, refined and told to the neighbours.
Rounds refined(const Scene& scene, const Cut& cut) {
  Rounds rounds(cut, scene.hausd(), {});
  rounds.refine_interfaces();
  return rounds;
}

template <class Check>
void for_random_scenes(double finer, Check check) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const Scene scene = random_scene(seed, finer);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name);
    const Cut cut = scene.cut();
    EXPECT_NO_THROW(check(scene, cut));
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(RefineInterface, AllSidesAgree) {
  std::uint64_t new_vertices = 0;
  for_random_scenes(4, [&](const Scene& scene, const Cut& cut) {
    Rounds rounds = refined(scene, cut);
    expect_sound(rounds, totals_of(scene.mesh));
    for (const Subdomain& s : rounds.subdomains())
      for (std::uint32_t i = 0; i < s.interface.size(); ++i) new_vertices += s.interface.id(i).derived();
  });
  EXPECT_GT(new_vertices, 10000u);
}

/// Equal lengths everywhere, and vertices numbered differently in every subdomain.
TEST(RefineInterface, TiesAreBrokenAlike) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    Scene scene;
    scene.mesh = unit_cube_of_fives(4);  // has faces whose sides are all equal
    shuffle(scene.mesh, seed);
    scene.log_metrics = uniform_metric(scene.mesh, 0.07);
    cut_at_random(scene, 6, seed % 3, seed);
    const Cut cut = scene.cut();
    Rounds rounds = refined(scene, cut);
    expect_sound(rounds, totals_of(scene.mesh));
  }
}

TEST(RefineInterface, LeavesNoLongEdgeThatMayBeSplit) {
  const meshing::Limits limits;
  for_random_scenes(4, [&](const Scene& scene, const Cut& cut) {
    Rounds rounds = refined(scene, cut);
    std::size_t edges = 0, left = 0;
    for (const Subdomain& s : rounds.subdomains())
      for (const auto& [name, edge] : interface_edges(s, cut.geometry)) {
        const auto [a, b] = edge;
        ++edges;
        if (must_stay(s, cut.geometry, a, b) || length_between(*s.mesh, a, b) <= limits.long_edge) continue;
        ++left;
        EXPECT_TRUE(may_near_what_stays(s, a, b)) << name.first << ' ' << name.second;
      }
    EXPECT_LE(left, edges / 2);
  });
}

TEST(RefineInterface, SplitsNoEdgeThatMustStay) {
  for_random_scenes(4, [&](const Scene& scene, const Cut& cut) {
    Rounds rounds(cut, scene.hausd(), {});
    std::vector<std::set<EdgeName>> kept(scene.subdomains);
    for (const Subdomain& s : rounds.subdomains())
      for (const auto& [name, edge] : interface_edges(s, cut.geometry))
        if (must_stay(s, cut.geometry, edge.first, edge.second)) kept[s.id.value].insert(name);
    rounds.refine_interfaces();
    for (const Subdomain& s : rounds.subdomains()) {
      const Edges now = interface_edges(s, cut.geometry);
      for (const EdgeName& name : kept[s.id.value])
        EXPECT_TRUE(now.contains(name)) << name.first << ' ' << name.second;
    }
  });
}

TEST(RefineInterface, NamesAreUniqueWithinASubdomainAndAPlaceEverywhere) {
  for_random_scenes(3, [&](const Scene& scene, const Cut& cut) {
    Rounds rounds = refined(scene, cut);
    std::map<GlobalId, meshing::Point> places;
    for (const Subdomain& s : rounds.subdomains()) {
      std::set<GlobalId> names;
      for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i) {
        if (!s.mesh->alive(VertexId(i))) continue;
        const GlobalId id = s.global_id(VertexId(i));
        EXPECT_TRUE(id.valid());
        EXPECT_TRUE(names.insert(id).second) << id;
        const auto [at, is_new] = places.emplace(id, s.mesh->point(VertexId(i)));
        EXPECT_EQ(norm(at->second - s.mesh->point(VertexId(i))), 0) << id;
      }
    }
  });
}

/// What the rest of the method makes of it: vertices on patches and curves must have been classified rightly.
TEST(RefineInterface, AdaptationKeepsTheDomainAfterwards) {
  for (unsigned seed = 0; seed < repetitions(8, 24); ++seed) {
    const Scene scene = random_scene(seed, 3);
    if (scene.curved) continue;
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name);
    const Cut cut = scene.cut();
    Rounds rounds = refined(scene, cut);
    rounds.adapt(meshing::Extent::everything);
    expect_sound(rounds, totals_of(scene.mesh));
    expect_same_lengths(merge_pieces(rounds.pieces()).mesh, scene.mesh);
  }
}

/// The places and names of the interface's vertices, subdomain by subdomain.
using Places = std::vector<std::map<GlobalId, std::tuple<double, double, double>>>;
Places interface_places(Rounds& rounds) {
  Places places;
  for (const Subdomain& s : rounds.subdomains()) {
    auto& mine = places.emplace_back();
    for (std::uint32_t i = 0; i < s.mesh->vertex_slots(); ++i) {
      const VertexId v(i);
      if (!s.mesh->alive(v) || !s.mesh->frozen(v)) continue;
      const meshing::Point& p = s.mesh->point(v);
      mine.emplace(s.global_id(v), std::tuple(p[0], p[1], p[2]));
    }
  }
  return places;
}

/// Neighbours have other levels, and one may be interrupted: the interface is the same.
TEST(RefineInterface, IsTheSameWhateverIsAdaptedBetweenLevels) {
  std::size_t vertices = 0;
  const unsigned seeds = repetitions(8, 24);
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const Scene scene = random_scene(seed, seed % 2 == 0 ? 1.5 : 3);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + scene.name);
    const Cut cut = scene.cut();
    Rounds at_once = refined(scene, cut), by_levels(cut, scene.hausd(), {}),
           interrupted(cut, scene.hausd(), {});
    std::atomic<bool> interrupt{true};
    interrupted.options().interrupt = &interrupt;
    by_levels.adapt_interiors();
    interrupted.adapt_interiors();
    const Places expected = interface_places(at_once);
    EXPECT_EQ(interface_places(by_levels), expected);
    EXPECT_EQ(interface_places(interrupted), expected);
    for (const auto& places : expected) vertices += places.size();
    const std::optional<ExpectedTotals> totals =
        scene.curved ? std::optional<ExpectedTotals>() : totals_of(scene.mesh);
    expect_sound(by_levels, totals);
    expect_sound(interrupted, totals);
    if (HasFailure()) return;
  }
  EXPECT_GT(vertices, 400u * seeds);
}

/// Interfaces of subdomains on those of materials: an open face with a patch.
TEST(RefineInterface, RefinesMaterialInterfacesBetweenSubdomains) {
  Scene scene;
  scene.mesh = layered_box(3, 2, 3);
  shuffle(scene.mesh, 4);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.1, 4);
  for (const std::int32_t ref : scene.mesh.tet_refs)
    scene.part.push_back(SubdomainId(static_cast<std::uint32_t>(ref - 1)));
  scene.subdomains = 3;
  const Cut cut = scene.cut();
  Rounds rounds = refined(scene, cut);
  expect_sound(rounds, totals_of(scene.mesh));
  EXPECT_GT(rounds.subdomains()[1].interface.size(), 100u);
  rounds.adapt(meshing::Extent::everything);
  expect_sound(rounds, totals_of(scene.mesh));
  for (const Subdomain& s : rounds.subdomains())
    for (std::uint32_t i = 0; i < s.interface.size(); ++i)
      EXPECT_GE(s.mesh->kind(s.interface.local(i)), meshing::VertexKind::surface);
}

TEST(RefineInterface, DelicateVerticesAreLeftAlone) {
  Scene scene = random_body(1);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.05, 1);
  cut_at_random(scene, 4, 0, 1);
  Cut cut = scene.cut();
  std::set<GlobalId> delicate;
  for (SubdomainStart& s : cut.starts)
    for (std::size_t v = 0; v < s.ids.size(); ++v)
      if (s.ids[v].local() % 3 == 0) {
        s.flags[v] |= kDelicate;
        delicate.insert(s.ids[v]);
      }
  Rounds rounds(cut, scene.hausd(), {});
  std::map<SubdomainId, Edges> before;
  for (const Subdomain& s : rounds.subdomains()) before[s.id] = interface_edges(s, cut.geometry);
  rounds.refine_interfaces();
  expect_sound(rounds, totals_of(scene.mesh));
  for (const Subdomain& s : rounds.subdomains()) {
    const Edges now = interface_edges(s, cut.geometry);
    for (const auto& [name, edge] : before[s.id])
      EXPECT_TRUE(now.contains(name) || (!delicate.contains(name.first) && !delicate.contains(name.second)));
  }
}

TEST(RefineInterface, AMeshThatIsFineEnoughStays) {
  Scene scene = random_scene(0, 0.05);
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  const auto before = tets_of(rounds.subdomains());
  rounds.refine_interfaces();
  EXPECT_EQ(tets_of(rounds.subdomains()), before);
  expect_sound(rounds, totals_of(scene.mesh));
}

/// Two subdomains whose interfaces have been refined after `damage` to the second one; what is thrown.
std::string issue_after(const std::function<void(Subdomain&)>& damage) {
  Scene scene;
  scene.mesh = unit_cube(3);
  scene.log_metrics = wanted_sizes(scene.mesh, 0.1, 1);
  cut_at_random(scene, 2, 1, 1);
  const Cut cut = scene.cut();
  Rounds rounds(cut, scene.hausd(), {});
  damage(rounds.subdomains()[1]);
  try {
    rounds.refine_interfaces();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

double up(double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); }

/// Another C library on another machine would do this.
TEST(RefineInterface, RefusesASideThatComputesAMetricOtherwiseByTheLastBit) {
  EXPECT_EQ(issue_after([](Subdomain&) {}), "");
  for (std::uint32_t i : {0u, 3u, 7u}) {
    const std::string issue = issue_after([i](Subdomain& s) {
      const VertexId v = s.interface.local(i);
      meshing::LogMetric l = s.mesh->log_metric(v);
      l.xx = up(l.xx);
      s.mesh->set_metric(v, l, meshing::exp_fast(l));
    });
    EXPECT_THAT(issue, ::testing::HasSubstr("interface face ("));
    EXPECT_THAT(issue, ::testing::HasSubstr("has other coordinates or metrics in a neighbour; holders"));
  }
}

TEST(RefineInterface, RefusesASideThatSplitsOtherEdges) {
  const std::string issue = issue_after([](Subdomain& s) {
    for (std::uint32_t i = 0; i < s.interface.size(); ++i) {  // coarser by a factor of 2
      const VertexId v = s.interface.local(i);
      meshing::LogMetric l = s.mesh->log_metric(v);
      l.xx -= 1.4, l.yy -= 1.4, l.zz -= 1.4;
      s.mesh->set_metric(v, l, meshing::exp_fast(l));
    }
  });
  EXPECT_THAT(issue, ::testing::HasSubstr("is in no neighbour"));
}

/// An axis of three edges with `tets` around each.
MeshData o_grid(std::uint32_t tets) {
  std::vector<Point> points{{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {0, 0, 3}};
  std::vector<std::array<std::uint32_t, 4>> around;
  for (std::uint32_t i = 0; i < tets; ++i) {
    const double angle = 2 * std::numbers::pi * i / tets;
    points.push_back({std::cos(angle), std::sin(angle), 1.5});
    for (std::uint32_t k = 0; k < 3; ++k) around.push_back({k, k + 1, 4 + i, 4 + (i + 1) % tets});
  }
  return mesh_of(std::move(points), std::move(around));
}

/// The axis of the grid is an edge of the interface with hundreds of tets on each side.
TEST(RefineInterface, SplitsEdgesWithMoreTetsThanAShellCanHave) {
  for (const std::uint32_t tets : {514u, 1100u, 1537u}) {
    SCOPED_TRACE(tets);
    Scene scene;
    scene.mesh = o_grid(tets);
    scene.log_metrics = uniform_metric(scene.mesh, 0.3);
    for (std::uint32_t i = 0; i < 3 * tets; ++i) scene.part.emplace_back(2 * (i / 3) / tets);
    scene.subdomains = 2;
    const Cut cut = scene.cut();
    Rounds rounds(cut, scene.hausd(), {});
    ASSERT_NO_THROW(rounds.refine_interfaces());
    expect_sound(rounds, totals_of(scene.mesh));
    std::uint64_t on_axis = 0;
    const Subdomain& s = rounds.subdomains()[0];
    for (std::uint32_t i = 0; i < s.interface.size(); ++i) {
      const meshing::Point& p = s.mesh->point(s.interface.local(i));
      on_axis += p.x == 0 && p.y == 0;
    }
    EXPECT_GT(on_axis, 8u);
    if (HasFailure()) return;
  }
}

TEST(IsDelicate, TellsThinFromSound) {
  const auto tet = [](double height, double away) {
    const meshing::Point o{away, away, away};
    return std::array<meshing::Point, 4>{o, o + meshing::Point{1, 0, 0}, o + meshing::Point{0, 1, 0},
                                         o + meshing::Point{0.3, 0.3, height}};
  };
  EXPECT_FALSE(is_delicate(tet(1, 0)));
  EXPECT_FALSE(is_delicate(tet(1e-6, 0)));
  EXPECT_TRUE(is_delicate(tet(1e-13, 0)));
  EXPECT_TRUE(is_delicate(tet(1e-6, 1e6)));  // coordinates are known to 1e-10 there
  std::array<meshing::Point, 4> tiny = tet(1, 0);
  for (meshing::Point& p : tiny) p = 1e-9 * p;
  EXPECT_FALSE(is_delicate(tiny));  // no absolute size counts
}

}  // namespace
}  // namespace weft::partition::refine_interface_test
