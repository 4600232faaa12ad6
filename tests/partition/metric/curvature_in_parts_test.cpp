// The metric of curvature of a mesh in parts has the bits of the whole mesh's.
#include "partition/metric/curvature_in_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <exception>
#include <memory>
#include <string>

#include "meshing/base/error.h"
#include "meshing/geometry/model/analytic_model.h"
#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/support/meshes.h"

namespace weft::partition::curvature_in_parts_test {
namespace {

using meshing::CurvatureOptions;
using meshing::LogMetricField;
using meshing::MeshData;

/// A ball with bumps, or a cylinder whose side meets planes, in no order, with references, edges and marks.
MeshData body(unsigned seed) {
  MeshData mesh = seed % 2 ? support::cylinder(40, 3, 12, 2) : support::ball(3, 2);
  if (seed % 2 == 0)
    for (meshing::Point& p : mesh.points) p = (1 + 0.04 * std::sin(5 * p.x + seed) * std::cos(4 * p.y)) * p;
  support::shuffle(mesh, seed);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    mesh.triangle_refs[t] = mesh.points[mesh.triangles[t][0]].x > 0.3 ? 7 : 3;
    if (t % 50 != 7) continue;
    if (t % 4) mesh.required_edges.push_back(static_cast<std::uint32_t>(mesh.edges.size()));
    mesh.edges.push_back({mesh.triangles[t][1], mesh.triangles[t][0]});
    mesh.edge_refs.push_back(2);
    if (t % 3) mesh.required_triangles.push_back(t);
  }
  return mesh;
}

LogMetricField in_parts(Peers& peers, const MeshSlice& slice, const CurvatureOptions& options,
                        const std::shared_ptr<const meshing::Model>& model = nullptr) {
  const PartDomain domain(peers, slice, 1);
  return domain.to_slices(curvature_in_parts(peers, slice, domain, options, model));
}

void expect_that_of_the_whole(const MeshData& mesh, const CurvatureOptions& options,
                              const std::shared_ptr<const meshing::Model>& model = nullptr) {
  const LogMetricField expected = meshing::curvature_metric(mesh, options, model);
  for (const int ranks : support::kNumbersOfRanks)
    for (const unsigned seed : {0u, 5u}) {
      SCOPED_TRACE(std::to_string(ranks) + " ranks, shares " + std::to_string(seed));
      support::run_ranks(ranks, [&](Peers& peers) {
        const MeshSlice slice = support::slice_of({mesh, {}}, peers.rank(), ranks, seed);
        const LogMetricField found = in_parts(peers, slice, options, model);
        const auto first = expected.begin() + static_cast<std::ptrdiff_t>(slice.first_point);
        EXPECT_EQ(found, LogMetricField(first, first + static_cast<std::ptrdiff_t>(found.size())));
      });
    }
}

TEST(CurvatureInParts, HasTheBitsOfTheWholeMesh) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE(seed);
    expect_that_of_the_whole(body(seed), {30, 1e-3, 45});
  }
}

TEST(CurvatureInParts, OfAModelToo) {
  expect_that_of_the_whole(support::ball(2, 2), {20, 0, 45},
                           std::make_shared<const meshing::Model>(meshing::ball_model({0, 0, 0}, 1)));
}

template <class Work>
std::string refusal_of(const Work& work) {
  try {
    work();
  } catch (const meshing::InputError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(CurvatureInParts, RefusesATriangleWithAVertexTwiceAsTheWholeDoes) {
  MeshData mesh = support::ball(2, 2);
  for (const std::size_t t : {mesh.triangles.size() - 1, mesh.triangles.size() / 2})
    mesh.triangles[t][2] = mesh.triangles[t][0];
  const CurvatureOptions options{20, 0, 45};
  for (const bool on_model : {false, true}) {
    const auto model =
        on_model ? std::make_shared<const meshing::Model>(meshing::ball_model({0, 0, 0}, 1)) : nullptr;
    const std::string expected = refusal_of([&] { meshing::curvature_metric(mesh, options, model); });
    EXPECT_NE(expected.find("has a vertex twice"), std::string::npos) << expected;
    for (const int ranks : support::kNumbersOfRanks) {
      SCOPED_TRACE(ranks);
      const auto thrown = support::run_ranks_caught(ranks, [&](Peers& peers) {
        in_parts(peers, support::slice_of({mesh, {}}, peers.rank(), ranks, 5), options, model);
      });
      for (const std::exception_ptr& of_rank : thrown)
        EXPECT_EQ(refusal_of([&] {
                    if (of_rank) std::rethrow_exception(of_rank);
                  }),
                  expected);
    }
  }
}

TEST(MayCurve, IsTheSameForAnySharesAndTellsRoundFromPlanar) {
  MeshData box = support::unit_cube(4);
  support::shuffle(box, 3);
  for (const bool round : {false, true})
    for (const int ranks : support::kNumbersOfRanks)
      support::run_ranks(ranks, [&](Peers& peers) {
        const MeshSlice slice = support::slice_of({round ? body(0) : box, {}}, peers.rank(), ranks, 5);
        EXPECT_EQ(may_curve(peers, slice, 45), round);
      });
}

TEST(CurvatureInParts, OfNoTrianglesAsksForNothing) {
  MeshData mesh = support::unit_cube(3);
  mesh.triangles.clear();
  mesh.triangle_refs.clear();
  mesh.edges.clear();
  mesh.edge_refs.clear();
  mesh.ridges.clear();
  expect_that_of_the_whole(mesh, {20, 0, 45});
}

}  // namespace
}  // namespace weft::partition::curvature_in_parts_test
