// Corners and holders of vertices made between others, against plain sets.
#include "partition/refine/refined_vertices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace weft::partition::refined_vertices_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr RefinedVertices::Index kNone = RefinedVertices::kNone;

GlobalId name(std::uint64_t i) { return {SubdomainId(0), i}; }

/// Holders by vertex, 0 and up.
Interface interface_of(const std::vector<std::set<std::uint32_t>>& holders) {
  std::vector<Holder> lines;
  for (std::size_t v = 0; v < holders.size(); ++v)
    for (const std::uint32_t s : holders[v]) lines.push_back({name(v), SubdomainId(s)});
  return Interface(std::move(lines));
}

TEST(RefinedVertices, ThoseOfTheInterfaceAreTheirOwnCorners) {
  const RefinedVertices vertices(interface_of({{4, 7}, {7}}));
  EXPECT_EQ(vertices.size(), 2u);
  EXPECT_EQ(vertices.first_new(), 2u);
  EXPECT_EQ(vertices.id(1), name(1));
  EXPECT_THAT(vertices.corners(1), ElementsAre(1, kNone, kNone));
  EXPECT_THAT(vertices.holders(0), ElementsAre(SubdomainId(4), SubdomainId(7)));
  EXPECT_THAT(vertices.holders(1), ElementsAre(SubdomainId(7)));
  EXPECT_EQ(vertices.find(name(1)), 1u);
  EXPECT_EQ(vertices.find(name(2)), kNone);
  EXPECT_EQ(vertices.find(GlobalId::derived_from(name(0), name(1))), kNone);
}

TEST(RefinedVertices, ANewOneIsHeldByThoseWhoHoldBothEnds) {
  RefinedVertices vertices(interface_of({{1, 2, 3}, {2, 3, 4}, {5}}));
  const auto side = vertices.add_between(1, 0);
  EXPECT_EQ(vertices.id(side), GlobalId::derived_from(name(1), name(0)));
  EXPECT_THAT(vertices.corners(side), ElementsAre(1, 0, kNone));
  EXPECT_THAT(vertices.holders(side), ElementsAre(SubdomainId(2), SubdomainId(3)));
  const auto inside = vertices.add_between(side, 2);
  EXPECT_THAT(vertices.corners(inside), ElementsAre(1, 0, 2));
  EXPECT_THAT(vertices.holders(inside), IsEmpty());
  EXPECT_THAT(vertices.corners(vertices.add_between(inside, side)), ElementsAre(1, 0, 2));
}

/// The interface of a later phase has vertices that were made in an earlier one.
TEST(RefinedVertices, NamesOfAnEarlierPhaseAreNotGivenAgain) {
  const GlobalId middle = GlobalId::derived_from(name(0), name(1));
  RefinedVertices vertices(
      Interface({{name(0), SubdomainId(1)}, {name(1), SubdomainId(1)}, {middle, SubdomainId(1)}}), 1);
  const auto old = vertices.find(middle);
  ASSERT_LT(old, vertices.first_new());
  const GlobalId made = vertices.id(vertices.add_between(0, 1)),
                 deep = vertices.id(vertices.add_between(0, old));
  vertices.sort_new();
  EXPECT_NE(made, middle);
  EXPECT_TRUE(made.derived());
  EXPECT_EQ(vertices.find(middle), old);
  EXPECT_EQ(vertices.id(vertices.find(made)), made);
  EXPECT_EQ(vertices.id(vertices.find(deep)), deep);
  RefinedVertices later(Interface({{name(0), SubdomainId(1)}, {name(1), SubdomainId(1)}}), 2);
  EXPECT_NE(later.id(later.add_between(0, 1)), made);
}

/// Vertices within one face, made between any two that are there.
TEST(RefinedVertices, HoldersAreThoseOfAllCornersHoweverDeep) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<std::set<std::uint32_t>> holders(3);
    for (auto& set : holders)
      for (std::uint32_t s = 1; s < 8; ++s)
        if (random() % 3 > 0 || s == 1) set.insert(s);
    RefinedVertices vertices(interface_of(holders));
    std::set<GlobalId> names;
    for (int i = 0; i < 30; ++i) {
      const auto x = static_cast<RefinedVertices::Index>(random() % vertices.size());
      const auto y = static_cast<RefinedVertices::Index>(random() % vertices.size());
      if (x == y || names.contains(GlobalId::derived_from(vertices.id(x), vertices.id(y)))) continue;
      names.insert(vertices.id(vertices.add_between(x, y)));
    }
    vertices.sort_new();
    EXPECT_EQ(vertices.size(), 3 + names.size());
    for (const GlobalId id : names) EXPECT_EQ(vertices.id(vertices.find(id)), id);
    for (auto i = vertices.first_new(); i < vertices.size(); ++i) {
      std::vector<SubdomainId> all;
      for (SubdomainId s(1); s.value < 8; ++s.value)
        if (std::ranges::all_of(vertices.corners(i),
                                [&](auto c) { return c == kNone || holders[c].contains(s.value); }))
          all.push_back(s);
      EXPECT_EQ(vertices.holders(i), all);
    }
  }
}

}  // namespace
}  // namespace weft::partition::refined_vertices_test
