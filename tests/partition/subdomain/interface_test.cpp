// The table of shared vertices answers as a plain map of sets does.
#include "partition/subdomain/interface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace weft::partition::interface_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

using Table = std::map<GlobalId, std::set<SubdomainId>>;

/// Lines in no order, many of them repeated.
GlobalId random_id(std::mt19937_64& random, std::uint64_t vertices) {
  const std::uint64_t local = random() % vertices;
  return {SubdomainId(static_cast<std::uint32_t>(random() % 5)), local};
}

std::vector<Holder> random_lines(unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<Holder> lines;
  const std::size_t count = random() % 200, vertices = 1 + random() % 60;
  for (std::size_t i = 0; i < count; ++i) {
    const GlobalId counted = random_id(random, vertices);
    const GlobalId id = random() % 4 ? counted : GlobalId::derived_from(counted, GlobalId(SubdomainId(1), 1));
    lines.push_back({id, SubdomainId(static_cast<std::uint32_t>(random() % 7))});
  }
  return lines;
}

Table table_of(const std::vector<Holder>& lines) {
  Table table;
  for (const Holder& h : lines) table[h.vertex].insert(h.subdomain);
  return table;
}

TEST(Holders, MergedListsAreAllTheirLinesSorted) {
  EXPECT_THAT(merge_unique({}), IsEmpty());
  for (unsigned lists = 1; lists < 12; ++lists) {
    std::vector<std::vector<Holder>> sorted;
    std::vector<Holder> all;
    for (unsigned i = 0; i < lists; ++i) {
      std::vector<Holder> lines = random_lines(100 * lists + i);
      all.insert(all.end(), lines.begin(), lines.end());
      sort_unique(lines);
      sorted.push_back(std::move(lines));
    }
    sort_unique(all);
    EXPECT_EQ(merge_unique(std::move(sorted)), all) << lists << " lists";
  }
}

TEST(Interface, EmptyHasNothing) {
  for (const Interface& interface : {Interface(), Interface(std::vector<Holder>{})}) {
    EXPECT_EQ(interface.size(), 0u);
    EXPECT_THAT(interface.neighbours(), IsEmpty());
    EXPECT_THAT(interface.lines(), IsEmpty());
    EXPECT_EQ(interface.find(GlobalId(SubdomainId(0), 0)), Interface::kNone);
  }
}

TEST(Interface, AnswersAsAMapOfSets) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<Holder> lines = random_lines(seed);
    const Table table = table_of(lines);
    const Interface interface(lines);
    ASSERT_EQ(interface.size(), table.size());
    std::uint32_t i = 0;
    std::set<SubdomainId> neighbours;
    for (const auto& [id, holders] : table) {
      EXPECT_EQ(interface.id(i), id);  // ascending
      EXPECT_EQ(interface.find(id), i);
      std::vector<SubdomainId> others;
      for (const Holder& h : interface.others(i)) {
        EXPECT_EQ(h.vertex, id);
        others.push_back(h.subdomain);
      }
      EXPECT_EQ(others, std::vector(holders.begin(), holders.end()));
      for (SubdomainId s(0); s.value < 8; ++s.value) EXPECT_EQ(interface.held_by(i, s), holders.contains(s));
      neighbours.insert(holders.begin(), holders.end());
      ++i;
    }
    EXPECT_EQ(std::vector(interface.neighbours().begin(), interface.neighbours().end()),
              std::vector(neighbours.begin(), neighbours.end()));
  }
}

TEST(Interface, FindsNothingElse) {
  const Interface interface(random_lines(3));
  for (std::uint64_t local = 0; local < 100; ++local)
    EXPECT_EQ(interface.find(GlobalId(SubdomainId(9), local)), Interface::kNone);
  EXPECT_EQ(interface.find(GlobalId()), Interface::kNone);
}

TEST(Interface, ItsLinesMakeItAgain) {
  const Interface interface(random_lines(5));
  const Interface again(std::vector<Holder>(interface.lines().begin(), interface.lines().end()));
  ASSERT_EQ(again.size(), interface.size());
  EXPECT_TRUE(std::ranges::equal(again.lines(), interface.lines()));
}

TEST(Interface, PlacesAreUnknownUntilSet) {
  Interface interface(std::vector<Holder>{{GlobalId(SubdomainId(0), 4), SubdomainId(1)},
                                          {GlobalId(SubdomainId(0), 2), SubdomainId(1)}});
  EXPECT_FALSE(interface.local(0).valid());
  interface.set_local(1, meshing::VertexId(17));
  EXPECT_FALSE(interface.local(0).valid());
  EXPECT_EQ(interface.local(1), meshing::VertexId(17));
}

TEST(SortUnique, SortsByVertexThenSubdomain) {
  std::vector<Holder> lines{{GlobalId(SubdomainId(1), 0), SubdomainId(3)},
                            {GlobalId(SubdomainId(0), 9), SubdomainId(5)},
                            {GlobalId(SubdomainId(1), 0), SubdomainId(2)},
                            {GlobalId(SubdomainId(0), 9), SubdomainId(5)}};
  sort_unique(lines);
  EXPECT_THAT(lines, ElementsAre(Holder{GlobalId(SubdomainId(0), 9), SubdomainId(5)},
                                 Holder{GlobalId(SubdomainId(1), 0), SubdomainId(2)},
                                 Holder{GlobalId(SubdomainId(1), 0), SubdomainId(3)}));
}

TEST(GlobalIds, DerivedNamesAreApartFromCountedOnes) {
  std::set<GlobalId> names;
  for (std::uint64_t a = 0; a < 60; ++a)
    for (std::uint64_t b = 0; b < 60; ++b) {
      const GlobalId derived =
          GlobalId::derived_from(GlobalId(SubdomainId(2), a), GlobalId(SubdomainId(3), b));
      EXPECT_TRUE(derived.derived());
      EXPECT_TRUE(names.insert(derived).second) << a << ' ' << b;
      EXPECT_EQ(derived, GlobalId::derived_from(GlobalId(SubdomainId(2), a), GlobalId(SubdomainId(3), b)));
    }
  EXPECT_FALSE(
      GlobalId(SubdomainId((1u << 23) - 3), (std::uint64_t{1} << GlobalId::kLocalBits) - 1).derived());
}

}  // namespace
}  // namespace weft::partition::interface_test
