// Tests of the background: interpolation, points outside, and walks from anywhere.
#include "meshing/metric/background.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/meshes.h"

namespace weft::meshing::background_test {
namespace {

using support::unit_cube;

/// A log-metric that is linear in space.
LogMetric linear(const Point& p) {
  return {1 + p.x, 0.3 * p.y, 2 - p.z, 0.1 * p.x - 0.2 * p.z, 0.5, p.x + p.y + p.z};
}

template <class F>
std::vector<LogMetric> sampled(const MeshData& mesh, F f) {
  std::vector<LogMetric> field;
  for (const Point& p : mesh.points) field.push_back(f(p));
  return field;
}

double distance(const SymTensor& a, const SymTensor& b) {
  const SymTensor d = a - b;
  return std::max(
      {std::abs(d.xx), std::abs(d.xy), std::abs(d.yy), std::abs(d.xz), std::abs(d.yz), std::abs(d.zz)});
}

MeshData disordered_cube(std::uint32_t n) {
  MeshData mesh = unit_cube(n);
  support::jitter_interior(mesh, 0.2 / n);
  support::shuffle(mesh);
  return mesh;
}

std::vector<Point> random_points(int count, double lo, double hi, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(lo, hi);
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
    points.push_back({x, y, z});
  }
  return points;
}

TEST(Background, ReproducesALinearLogMetricEverywhere) {
  const MeshData mesh = disordered_cube(5);
  const auto field = sampled(mesh, linear);
  const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
  for (const Point& p : random_points(2000, 0, 1, 1))
    EXPECT_LT(distance(background.at(p, Background::kNoHint).log_metric, linear(p)), 1e-12);
}

TEST(Background, KnowsItsVertices) {
  const MeshData mesh = disordered_cube(3);
  const auto field = sampled(mesh, linear);
  const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    EXPECT_EQ(background.log_metric(v), field[v]);
    const auto sample = background.at(mesh.points[v], Background::kNoHint);
    const auto& tet = mesh.tets[sample.tet];
    EXPECT_NE(std::find(tet.begin(), tet.end(), v), tet.end());
    EXPECT_LT(distance(sample.log_metric, field[v]), 1e-12);
  }
}

TEST(Background, TheHintChangesOnlyTheWay) {
  const MeshData mesh = disordered_cube(4);
  // Not linear: only the right tet gives the right value.
  const auto field =
      sampled(mesh, [](const Point& p) { return identity_tensor(std::sin(9 * p.x) * p.y + p.z * p.z); });
  const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
  std::mt19937 random(3);
  for (const Point& p : random_points(300, 0, 1, 2)) {
    const LogMetric expected = background.at(p, Background::kNoHint).log_metric;
    for (int i = 0; i < 10; ++i) {
      const auto hint = static_cast<std::uint32_t>(random() % mesh.tets.size());
      EXPECT_LT(distance(background.at(p, hint).log_metric, expected), 1e-10);
    }
  }
}

TEST(Background, TheReturnedTetHoldsThePoint) {
  const MeshData mesh = disordered_cube(4);
  const auto field = sampled(mesh, linear);
  const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
  for (const Point& p : random_points(300, 0, 1, 5)) {
    const auto& [a, b, c, d] = mesh.tets[background.at(p, 0).tet];
    const auto& x = mesh.points;
    for (const double volume : {six_volume(p, x[b], x[c], x[d]), six_volume(x[a], p, x[c], x[d]),
                                six_volume(x[a], x[b], p, x[d]), six_volume(x[a], x[b], x[c], p)})
      EXPECT_GT(volume, -1e-9);
  }
}

TEST(Background, OutsideItReadsTheClosestPoint) {
  const MeshData mesh = disordered_cube(4);
  // Once in a metric that calls everything near, once in one that calls it far.
  for (const double offset : {0.0, 8.0}) {
    const auto field = sampled(mesh, [&](const Point& p) { return linear(p) + identity_tensor(offset); });
    const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
    for (Point p : random_points(300, -0.2, 1.2, 7)) {
      p.x = -0.05 - std::abs(p.x) * 0.1;  // beyond the face x = 0
      const Point closest{0, std::clamp(p.y, 0.0, 1.0), std::clamp(p.z, 0.0, 1.0)};
      const LogMetric found = background.at(p, Background::kNoHint).log_metric;
      // Near, the closest point of the tet where the walk ended will do.
      EXPECT_LT(distance(found, linear(closest) + identity_tensor(offset)), offset == 0 ? 0.6 : 1e-9);
    }
  }
}

/// Two unit boxes with a gap between them, z from 0 to 1 and from 1 + gap to 2 + gap; not connected.
MeshData two_boxes(double gap) {
  BoxOptions options;
  options.cells = {3, 3, 3};
  MeshData mesh = structured_box(options);
  options.min.z = 1 + gap;
  options.max.z = 2 + gap;
  const MeshData upper = structured_box(options);
  const auto n = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), upper.points.begin(), upper.points.end());
  for (auto tet : upper.tets) {
    for (std::uint32_t& v : tet) v += n;
    mesh.tets.push_back(tet);
  }
  return mesh;
}

TEST(Background, AcrossTheGapOfAThinBodyItReadsItsOwnSide) {
  constexpr double kGap = 0.01;
  const MeshData mesh = two_boxes(kGap);
  // Sizes 0.001 near the gap: it is ten units wide.
  const auto field = sampled(mesh, [](const Point& p) {
    return identity_tensor(-2 * std::log(0.001)) + LogMetric{p.z > 1 ? 1.0 : 0.0, 0, 0, 0, 0, 0};
  });
  const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
  const double base = -2 * std::log(0.001);
  for (std::uint32_t hint = 0; hint < mesh.tets.size(); hint += 7) {
    EXPECT_NEAR(background.at({0.4, 0.3, 0.7}, hint).log_metric.xx, base, 1e-9) << "from tet " << hint;
    EXPECT_NEAR(background.at({0.4, 0.3, 1.4}, hint).log_metric.xx, base + 1, 1e-9) << "from tet " << hint;
    EXPECT_NEAR(background.at({0.4, 0.3, 1 + 0.1 * kGap}, hint).log_metric.xx, base, 1e-9)
        << "from tet " << hint;
    EXPECT_NEAR(background.at({0.4, 0.3, 1 + 0.9 * kGap}, hint).log_metric.xx, base + 1, 1e-9)
        << "from tet " << hint;
  }
}

/// A mesh cut into blocks of tets that follow each other, as a subdomain has them.
class Blocks {
 public:
  Blocks(const MeshData& mesh, std::span<const LogMetric> field, std::size_t tets_of_block)
      : mesh_(mesh), adjacency_(build_adjacency(mesh.tets, mesh.points.size())) {
    for (std::size_t first = 0; first < mesh.tets.size(); first += tets_of_block)
      add(field, first, std::min(first + tets_of_block, mesh.tets.size()), tets_of_block);
  }
  Background background() const {
    std::vector<BackgroundBlock> blocks;
    for (const Data& d : data_) {
      blocks.push_back(d.block);
      blocks.back().neighbours = d.neighbours.data();
      blocks.back().across = d.across.data();
    }
    return Background(std::move(blocks));
  }

 private:
  struct Data {
    BackgroundBlock block;
    std::vector<std::array<std::uint32_t, 4>> neighbours;
    std::vector<std::uint32_t> across;
  };
  void add(std::span<const LogMetric> field, std::size_t first, std::size_t end, std::size_t tets_of_block) {
    Data& d = data_.emplace_back();
    d.block.points = mesh_.points.data();
    d.block.log_metrics = field.data();
    d.block.tets = mesh_.tets.data() + first;
    d.block.num_tets = static_cast<std::uint32_t>(end - first);
    for (std::size_t t = first; t < end; ++t) {
      auto& sides = d.neighbours.emplace_back();
      for (std::size_t f = 0; f < 4; ++f) {
        const std::uint32_t n = adjacency_.neighbours[t][f];
        const std::size_t tet = n >> 2;
        if (n != kNoNeighbour && first <= tet && tet < end) {
          sides[f] = n - static_cast<std::uint32_t>(first << 2);
          continue;
        }
        sides[f] = BackgroundBlock::kOpen | static_cast<std::uint32_t>(d.across.size());
        const std::size_t number = tet / tets_of_block * BackgroundBlock::kMostTets + tet % tets_of_block;
        d.across.push_back(n == kNoNeighbour ? n : static_cast<std::uint32_t>(number << 2) | (n & 3));
      }
    }
  }

  const MeshData& mesh_;
  Adjacency adjacency_;
  std::vector<Data> data_;
};

/// Sizes of .05 ask for a search outside, in whatever block a walk ends.
TEST(Background, InBlocksReadsWhatTheWholeMeshHas) {
  for (const double gap : {0.01, 0.5}) {
    const MeshData mesh = two_boxes(gap);
    const auto field =
        sampled(mesh, [](const Point& p) { return identity_tensor(-2 * std::log(0.05)) + 0.1 * linear(p); });
    const Background whole(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
    for (const std::size_t tets_of_block : {1, 7, 100, 500}) {
      const Blocks cut(mesh, field, tets_of_block);
      const Background blocks = cut.background();
      for (const Point& p : random_points(300, -1, 3, 5))
        EXPECT_LT(distance(blocks.at(p, Background::kNoHint).log_metric,
                           whole.at(p, Background::kNoHint).log_metric),
                  1e-9)
            << tets_of_block << " tets a block, gap " << gap << ", at " << p.x << " " << p.y << " " << p.z;
    }
  }
}

TEST(Background, OfOneTetServesAllSpace) {
  const MeshData mesh = support::regular_tet();
  const auto field = sampled(mesh, linear);
  const Background background(mesh, field, build_adjacency(mesh.tets, mesh.points.size()));
  for (const Point& p : random_points(500, -3, 3, 9)) {
    const LogMetric l = background.at(p, Background::kNoHint).log_metric;
    EXPECT_GE(l.xx, 1 - 1e-12);
    EXPECT_LE(l.xx, 2 + 1e-12);
  }
}

}  // namespace
}  // namespace weft::meshing::background_test
