// Counts of what does not conform: beside the reports' measures, and by flags.
#include "meshing/kernel/nonconforming.h"

#include <gtest/gtest.h>

#include <cmath>

#include "meshing/metric/measures.h"
#include "tests/support/kernel.h"
#include "tests/support/meshes.h"

namespace weft::meshing::nonconforming_test {
namespace {

using support::KernelRig;

std::uint64_t rounded(double x) { return static_cast<std::uint64_t>(std::llround(x)); }

TEST(Nonconforming, AgreesWithTheMeasuresWhereTheMetricIsUniform) {
  for (const double size : {0.2, 0.3, 0.45, 0.8}) {
    const KernelRig rig(support::unit_cube(3), size);
    const Measures m = measure(rig.input, rig.log_metrics);
    const Nonconforming found = count_nonconforming(rig.mesh, kFrozen).plain;
    const auto edges = static_cast<double>(m.num_edges);
    EXPECT_EQ(found.tets, m.num_tets) << size;
    EXPECT_EQ(found.long_edges, rounded(m.edges_long * edges)) << size;
    EXPECT_EQ(found.short_edges, rounded(m.edges_short * edges)) << size;
  }
}

TEST(Nonconforming, PoorTetsAreThoseBelowTheLimit) {
  KernelRig rig(support::unit_cube(2));
  EXPECT_EQ(count_nonconforming(rig.mesh, 0).plain.poor_tets, 0u);
  rig.mesh.set_quality(TetId(0), 0.39f), rig.mesh.set_quality(TetId(1), 0.41f);
  EXPECT_EQ(count_nonconforming(rig.mesh, 0).plain.poor_tets, 1u);
}

TEST(Nonconforming, WhatTouchesAFlaggedVertexIsApart) {
  KernelRig rig(support::unit_cube(2), 0.1);  // all edges are too long
  const Nonconforming all = count_nonconforming(rig.mesh, kFrozen).plain;
  const VertexId corner = rig.vertex_at({0, 0, 0});
  rig.mesh.freeze(corner);
  std::uint64_t ball = 0;
  for (const TetId t : rig.live_tets()) ball += rig.mesh.local_index(t, corner) >= 0;
  NonconformingParts parts = count_nonconforming(rig.mesh, kFrozen);
  EXPECT_EQ(parts.flagged.tets, ball);
  EXPECT_EQ(parts.flagged.long_edges, rig.neighbours_of(corner).size());
  parts.plain += parts.flagged;
  EXPECT_EQ(parts.plain, all);
}

TEST(Nonconforming, ASampleOfTheEdgesIsScaledUp) {
  const KernelRig rig(support::unit_cube(16), 0.072);  // some are too long, some are not
  const Nonconforming exact = count_nonconforming(rig.mesh, 0).plain;
  const Nonconforming sample = count_nonconforming(rig.mesh, 0, 8).plain;
  ASSERT_GT(exact.long_edges, 1000u);
  EXPECT_EQ(sample.tets, exact.tets);
  EXPECT_EQ(sample.long_edges % 8, 0u);
  EXPECT_NEAR(static_cast<double>(sample.long_edges), static_cast<double>(exact.long_edges),
              0.1 * static_cast<double>(exact.long_edges));
}

}  // namespace
}  // namespace weft::meshing::nonconforming_test
