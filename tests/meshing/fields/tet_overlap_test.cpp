// Tests of the common part of two tets.
#include "meshing/fields/tet_overlap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

namespace weft::meshing::tet_overlap_test {
namespace {

using Tet = std::array<Point, 4>;
constexpr Tet kUnit = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

double volume(const Tet& t) { return six_volume(t[0], t[1], t[2], t[3]) / 6; }

Point at(const Tet& t, std::span<const double, 4> l) {
  return l[0] * t[0] + l[1] * t[1] + (l[2] * t[2] + l[3] * t[3]);
}

double common_volume(const Tet& a, const Tet& b) {
  TetOverlap overlap;
  return overlap.find(a, b) ? overlap.volume() : 0;
}

Tet shifted(Tet t, const Vec& by, double scale = 1) {
  for (Point& p : t) p = scale * p + by;
  return t;
}

Tet random_tet(std::mt19937& random, double thin = 1) {
  std::uniform_real_distribution<double> x(0, 1);
  Tet t;
  do {
    for (Point& p : t) p = {x(random), x(random), thin * x(random)};
    if (volume(t) < 0) std::swap(t[0], t[1]);
  } while (volume(t) < 1e-3 * thin);
  return t;
}

TEST(TetOverlap, OfATetWithItselfIsTheTet) { EXPECT_NEAR(common_volume(kUnit, kUnit), 1.0 / 6, 1e-15); }

TEST(TetOverlap, OfTetsThatOnlyTouchIsNothing) {
  EXPECT_EQ(common_volume(kUnit, shifted(kUnit, {1, 0, 0})), 0);
  EXPECT_EQ(common_volume(kUnit, shifted(kUnit, {5, 5, 5})), 0);
  Tet mirrored = kUnit;
  for (Point& p : mirrored) p.z = -p.z;
  std::swap(mirrored[0], mirrored[1]);
  EXPECT_EQ(common_volume(kUnit, mirrored), 0);
}

TEST(TetOverlap, OfNestedTetsIsTheInnerOneEitherWayRound) {
  const Tet inner = shifted(kUnit, {0.1, 0.2, 0.1}, 1e-4);
  EXPECT_NEAR(common_volume(kUnit, inner) / volume(inner), 1, 1e-14);
  EXPECT_NEAR(common_volume(inner, kUnit) / volume(inner), 1, 1e-14);
}

TEST(TetOverlap, OfShiftedTetsIsASmallerTet) {
  EXPECT_NEAR(common_volume(kUnit, shifted(kUnit, {0.5, 0, 0})), std::pow(0.5, 3) / 6, 1e-15);
  EXPECT_NEAR(common_volume(kUnit, shifted(kUnit, {0.25, 0.25, 0.25})), std::pow(0.25, 3) / 6, 1e-15);
}

TEST(TetOverlap, PiecesLieInBothTetsAndKnowTheirPlace) {
  std::mt19937 random(3);
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    const Tet a = random_tet(random, i % 2 == 0 ? 1 : 1e-3), b = random_tet(random, i % 2 == 0 ? 1 : 1e-3);
    TetOverlap overlap;
    if (!overlap.find(a, b)) continue;
    ++found;
    for (const TetOverlap::Piece& piece : overlap.pieces()) {
      Tet corners;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto& corner = overlap.corner(piece.corners[k]);
        corners[k] = at(a, corner.in_first());
        EXPECT_LT(norm(corners[k] - at(b, corner.in_second())), 1e-11);
        for (std::size_t j = 0; j < 4; ++j) {
          EXPECT_GE(corner.in_first()[j], -1e-11);
          EXPECT_GE(corner.in_second()[j], -1e-11);
        }
      }
      EXPECT_NEAR(volume(corners), piece.volume, 1e-11 * volume(a));
    }
  }
  EXPECT_GT(found, 150);
}

TEST(TetOverlap, FacesThatBoundItLeadToAllPartsThatATetOverlaps) {
  std::mt19937 random(7);
  int several = 0;
  for (int i = 0; i < 300; ++i) {
    const Tet a = random_tet(random), whole = random_tet(random);
    // Part k has the middle for corner k; part j lies beyond its face opposite to corner j.
    std::array<TetOverlap, 4> overlaps;
    std::array<bool, 4> found{}, reached{};
    for (std::size_t k = 0; k < 4; ++k) {
      Tet part = whole;
      part[k] = at(whole, std::array{0.4, 0.3, 0.2, 0.1});
      found[k] = overlaps[k].find(a, part) && overlaps[k].volume() > 1e-12;
    }
    const auto first = static_cast<std::size_t>(std::ranges::find(found, true) - found.begin());
    if (first == 4) continue;
    reached[first] = true;
    for (int round = 0; round < 4; ++round)
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t j = 0; j < 4; ++j)
          if (j != k && found[k] && reached[k] && (overlaps[k].faces_of_second() >> j & 1) != 0)
            reached[j] = true;
    for (std::size_t k = 0; k < 4; ++k) EXPECT_TRUE(reached[k] || !found[k]);
    several += std::ranges::count(found, true) > 2;
  }
  EXPECT_GT(several, 50);
}

TEST(TetOverlap, OfTetsThatShareCornersIsFound) {
  std::mt19937 random(9);
  for (int i = 0; i < 300; ++i) {
    Tet a = random_tet(random), b = random_tet(random);
    for (std::size_t k = 0; k < static_cast<std::size_t>(i % 4); ++k) b[k] = a[k];
    if (volume(b) < 0) std::swap(b[2], b[3]);
    if (volume(b) < 1e-3) continue;
    EXPECT_NEAR(common_volume(a, b), common_volume(b, a), 1e-14);
    EXPECT_NEAR(common_volume(a, a), volume(a), 1e-15);
  }
}

TEST(TetOverlap, WithThePartsOfATetAddsUp) {
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    const Tet a = random_tet(random), whole = random_tet(random);
    const Point middle = at(whole, std::array{0.4, 0.3, 0.2, 0.1});
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      Tet part = whole;
      part[k] = middle;
      sum += common_volume(a, part);
    }
    EXPECT_NEAR(sum, common_volume(a, whole), 1e-13);
  }
}

}  // namespace
}  // namespace weft::meshing::tet_overlap_test
