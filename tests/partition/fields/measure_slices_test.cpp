// Measures of slices are those of the whole mesh, wherever its points and tets are.
#include "partition/fields/measure_slices.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/partition/communication/threads_peers.h"
#include "tests/partition/distribute/slices.h"
#include "tests/partition/metric_meshes.h"

namespace weft::partition::measure_slices_test {
namespace {

using meshing::Measures;

void expect_same(const Measures& m, const Measures& expected) {
  for (const auto member :
       {&Measures::num_vertices, &Measures::num_tets, &Measures::num_edges, &Measures::num_triangles})
    EXPECT_EQ(m.*member, expected.*member);
  for (const auto member :
       {&Measures::quality_min, &Measures::quality_q01, &Measures::quality_q001, &Measures::edges_unit})
    EXPECT_EQ(m.*member, expected.*member);
  for (const auto member : {&Measures::volume, &Measures::complexity, &Measures::quality_mean,
                            &Measures::length_mean, &Measures::length_min, &Measures::length_max})
    EXPECT_NEAR(m.*member, expected.*member, 1e-12 * std::abs(expected.*member));
  EXPECT_EQ(m.quality.counts, expected.quality.counts);
  EXPECT_EQ(m.length.counts, expected.length.counts);
}

TEST(MeasureSlices, GivesTheMeasuresOfTheWholeMesh) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    support::MetricMesh whole = support::random_metric_mesh(seed);
    whole.mesh.points.push_back({7, 7, 7});  // of no tet: counted all the same
    whole.mesh.point_refs.push_back(0);
    whole.log_metrics.push_back(whole.log_metrics.front());
    const Measures expected = meshing::measure(whole.mesh, whole.log_metrics);
    for (const int ranks : support::kNumbersOfRanks)
      support::run_ranks(ranks, [&](Peers& peers) {
        expect_same(measure_slices(peers, support::slice_of(whole, peers.rank(), ranks, seed)), expected);
      });
  }
}

}  // namespace
}  // namespace weft::partition::measure_slices_test
