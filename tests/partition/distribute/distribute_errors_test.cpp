// Damaged input: every rank reports what the kernel's import of the whole mesh would.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "meshing/base/error.h"
#include "meshing/kernel/import_mesh.h"
#include "partition/distribute/distribute.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/metric_meshes.h"

namespace weft::partition::distribute_errors_test {
namespace {

using meshing::InputError;
using meshing::MeshData;
using support::MetricMesh;
using Damage = std::function<void(MeshData&, std::mt19937&)>;

std::string text_of(const std::exception_ptr& e) {
  if (!e) return "";
  try {
    std::rethrow_exception(e);
  } catch (const InputError& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("no InputError: ") + error.what();
  }
}

std::string import_error(const MeshData& mesh) {
  try {
    meshing::import_mesh(mesh, 45, mesh.points.size() + 1, mesh.tets.size() + 1);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::vector<std::string> distribute_errors(int ranks, const MetricMesh& whole, unsigned seed) {
  std::vector<std::string> texts;
  for (const auto& e : support::run_ranks_caught(ranks, [&](Peers& peers) {
         distribute(peers, support::slice_of(whole, peers.rank(), ranks, seed),
                    {4, parse_partitioner("bisection"), 45});
       }))
    texts.push_back(text_of(e));
  return texts;
}

template <class List>
auto& any(List& list, std::mt19937& random) {
  return list[random() % list.size()];
}

void add_tet(MeshData& m, const std::array<std::uint32_t, 4>& tet) {
  m.tets.push_back(tet);
  m.tet_refs.push_back(1);
}

const std::vector<std::pair<const char*, Damage>>& damages() {
  static const std::vector<std::pair<const char*, Damage>> list{
      {"inverted",
       [](MeshData& m, std::mt19937& r) {
         auto& t = any(m.tets, r);
         std::swap(t[0], t[1]);
       }},
      {"flat",
       [](MeshData& m, std::mt19937& r) {
         auto& t = any(m.tets, r);
         t[0] = t[1];
       }},
      {"vertex out of range", [](MeshData& m, std::mt19937& r) { any(m.tets, r)[2] = 100000; }},
      {"not finite", [](MeshData& m, std::mt19937& r) { any(m.points, r).y = std::nan(""); }},
      {"infinite",
       [](MeshData& m, std::mt19937& r) { any(m.points, r).z = std::numeric_limits<double>::infinity(); }},
      {"duplicate", [](MeshData& m, std::mt19937& r) { add_tet(m, any(m.tets, r)); }},
      {"turned duplicate",
       [](MeshData& m, std::mt19937& r) {
         auto tet = any(m.tets, r);
         std::rotate(tet.begin(), tet.begin() + 1, tet.begin() + 3);
         add_tet(m, tet);
       }},
      {"overlap",
       [](MeshData& m, std::mt19937& r) {
         // A tet of its own on the inner side of a boundary face: found by its face, as its top is a new
         // point.
         const auto tet = any(m.tets, r);
         meshing::Point top;
         for (const std::uint32_t v : tet) top += 0.25 * m.points[v];
         m.points.push_back(top);
         m.point_refs.push_back(0);
         for (int skipped = 0; skipped < 4; ++skipped) {
           auto mine = tet;
           mine[skipped] = static_cast<std::uint32_t>(m.points.size() - 1);
           add_tet(m, mine);
         }
       }},
      {"no face",
       [](MeshData& m, std::mt19937& r) {
         m.triangles.push_back({any(m.tets, r)[0], any(m.tets, r)[1], any(m.tets, r)[2]});
         m.triangle_refs.push_back(1);
       }},
      {"triangle with a vertex twice",
       [](MeshData& m, std::mt19937& r) {
         auto& t = any(m.triangles, r);
         t[2] = t[0];
       }},
      {"triangle out of range", [](MeshData& m, std::mt19937& r) { any(m.triangles, r)[1] = 0xFFFFFFFFu; }},
      {"edge out of range",
       [](MeshData& m, std::mt19937& r) {
         m.edges.insert(m.edges.begin(), {any(m.triangles, r)[0], 55555});
         m.edge_refs.insert(m.edge_refs.begin(), 1);
       }},
      {"corner", [](MeshData& m, std::mt19937&) { m.corners.push_back(99999); }},
      {"required vertex", [](MeshData& m, std::mt19937&) { m.required_points.push_back(99999); }},
      {"ridge", [](MeshData& m, std::mt19937&) { m.ridges.push_back(99999); }},
      {"required edge", [](MeshData& m, std::mt19937&) { m.required_edges.push_back(99999); }},
      {"required triangle", [](MeshData& m, std::mt19937&) { m.required_triangles.push_back(99999); }},
      {"triangle references", [](MeshData& m, std::mt19937&) { m.triangle_refs.pop_back(); }},
      {"edge references", [](MeshData& m, std::mt19937&) { m.edge_refs.push_back(1); }},
  };
  return list;
}

void expect_the_import_error(const MeshData& mesh, unsigned seed) {
  const std::string expected = import_error(mesh);
  ASSERT_NE(expected, "");
  const MetricMesh whole{mesh, meshing::LogMetricField(mesh.points.size())};
  for (const int ranks : support::kNumbersOfRanks)
    for (const std::string& found : distribute_errors(ranks, whole, seed))
      ASSERT_EQ(found, expected) << ranks << " ranks";
}

TEST(DistributeErrors, EveryDamageIsReportedAsTheImportDoes) {
  unsigned seed = 0;
  for (const auto& [name, damage] : damages()) {
    SCOPED_TRACE(name);
    for (int repeat = 0; repeat < 3; ++repeat) {
      std::mt19937 random(++seed);
      MeshData mesh = support::random_metric_mesh(seed).mesh;
      damage(mesh, random);
      expect_the_import_error(mesh, seed);
    }
  }
}

TEST(DistributeErrors, OfSeveralDamagesTheSameOneIsReported) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    MeshData mesh = support::random_metric_mesh(seed).mesh;
    const std::size_t kind = random() % damages().size();
    for (int i = 0; i < 3; ++i)
      damages()[random() % 2 ? kind : random() % damages().size()].second(mesh, random);
    expect_the_import_error(mesh, seed);
  }
}

TEST(DistributeErrors, FacesOfThreeTetsAreNamed) {
  // Three tets on the face (0 1 2), of which no two have another face in common.
  MeshData mesh = support::two_tets();
  mesh.points.push_back({0.2, 0.2, 3});
  mesh.point_refs.push_back(0);
  add_tet(mesh, {0, 1, 2, 5});
  expect_the_import_error(mesh, 1);
  EXPECT_THAT(import_error(mesh), ::testing::HasSubstr("tets 1, 2 and 3: share the face (1 2 3)"));
}

TEST(DistributeErrors, AMeshWithoutTetsIsRefused) {
  MeshData mesh = support::two_tets();
  mesh.tets.clear();
  mesh.tet_refs.clear();
  expect_the_import_error(mesh, 0);
}

TEST(DistributeErrors, MetricsThatAreNotFiniteAreNamed) {
  MetricMesh whole = support::random_metric_mesh(1);
  whole.log_metrics[17].xx = 1e5;
  for (const std::string& found : distribute_errors(3, whole, 0))
    EXPECT_EQ(found, "vertex 18: has a metric that is not finite");
}

TEST(DistributeErrors, SharesMustMakeUpTheMesh) {
  const MetricMesh whole = support::random_metric_mesh(1);
  for (int wrong = 0; wrong < 3; ++wrong)
    for (const auto& e : support::run_ranks_caught(3, [&](Peers& peers) {
           MeshSlice slice = support::slice_of(whole, peers.rank(), 3);
           if (peers.rank() == 1)
             (wrong == 0 ? slice.first_tet : wrong == 1 ? slice.num_points : slice.first_point) += 1;
           distribute(peers, std::move(slice), {});
         }))
      EXPECT_THROW(std::rethrow_exception(e), std::invalid_argument) << wrong;
}

}  // namespace
}  // namespace weft::partition::distribute_errors_test
