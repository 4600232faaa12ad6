// Names of partitioners.
#include "partition/decompose/partitioner.h"

#include <gmock/gmock.h>

#include <stdexcept>

namespace weft::partition::partitioner_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Kind = Partitioner::Kind;

std::string refusal(const std::string& text, std::uint32_t num_subdomains = 0) {
  try {
    parse_partitioner(text, num_subdomains);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

TEST(Partitioner, ReadsNames) {
  EXPECT_EQ(parse_partitioner("bisection").kind, Kind::bisection);
  EXPECT_EQ(parse_partitioner("graph", 7).kind, Kind::graph);
  EXPECT_EQ(parse_partitioner("pqr", 7).kind, Kind::pqr);
  EXPECT_THAT(parse_partitioner("pqr", 7).slabs, ElementsAre(0, 0, 0));
}

TEST(Partitioner, ReadsSlabsAndAxes) {
  const Partitioner p = parse_partitioner("pqr:128x1x1", 128);
  EXPECT_EQ(p.kind, Kind::pqr);
  EXPECT_THAT(p.slabs, ElementsAre(128, 1, 1));
  EXPECT_FALSE(p.principal_axes);
  EXPECT_THAT(parse_partitioner("pqr:2x3x4:principal").slabs, ElementsAre(2, 3, 4));
  EXPECT_TRUE(parse_partitioner("pqr:2x3x4:principal").principal_axes);
  EXPECT_TRUE(parse_partitioner("pqr:principal").principal_axes);
  EXPECT_FALSE(parse_partitioner("pqr:principal").fewer);
  for (const char* text : {"pqr:fewer", "pqr:2x3x4:fewer", "pqr:2x3x4:principal:fewer"})
    EXPECT_TRUE(parse_partitioner(text).fewer) << text;
  EXPECT_FALSE(parse_partitioner("pqr:2x3x4:fewer").principal_axes);
  EXPECT_TRUE(parse_partitioner("pqr:2x3x4:principal:fewer").principal_axes);
}

TEST(Partitioner, ReadsCoordinates) {
  const Partitioner p = parse_partitioner("pqr:8x2x1:harmonic=3,-5:principal:fewer", 16);
  EXPECT_EQ(p.coordinate.kind, BoundaryCoordinate::Kind::harmonic);
  EXPECT_THAT(p.coordinate.refs, ElementsAre(3, -5));
  EXPECT_THAT(p.slabs, ElementsAre(8, 2, 1));
  EXPECT_TRUE(p.principal_axes && p.fewer);
  EXPECT_EQ(parse_partitioner("pqr:wall=7").coordinate.kind, BoundaryCoordinate::Kind::wall);
  EXPECT_THAT(parse_partitioner("pqr:4x1x1:wall=7,1,2").coordinate.refs, ElementsAre(7, 1, 2));
  EXPECT_FALSE(parse_partitioner("pqr:4x1x1").coordinate.asked());
  for (const char* text : {"harmonic=3,-5", "wall=7,1,2", "wall=0"})
    EXPECT_EQ(text_of(parse_coordinate(text)), text);
}

TEST(Partitioner, SaysWhatIsWrongWithACoordinate) {
  EXPECT_THAT(refusal("pqr:4x1x1:wall="),
              AllOf(HasSubstr("'' is not a reference"), HasSubstr(":wall=A,...")));
  EXPECT_THAT(refusal("pqr:4x1x1:wall=1,two"), HasSubstr("'two' is not a reference"));
  EXPECT_THAT(refusal("pqr:4x1x1:wall=99999999999"), HasSubstr("is not a reference"));
  for (const char* text : {"pqr:harmonic=3", "pqr:harmonic=3,3", "pqr:4x1x1:harmonic=1,2,3"})
    EXPECT_THAT(refusal(text), HasSubstr("does not name two different references")) << text;
  EXPECT_THAT(refusal("pqr:wall=1:4x1x1"), HasSubstr("'4x1x1' is not known"));
  EXPECT_THAT(refusal("graph:wall=1"), HasSubstr("graph takes no options"));
}

TEST(Partitioner, SaysWhatIsWrongAndWhatIsAllowed) {
  EXPECT_THAT(refusal("metis"),
              AllOf(HasSubstr("'metis' is not known"), HasSubstr("allowed: bisection, graph")));
  EXPECT_THAT(refusal("pqr:4x2x2", 17), HasSubstr("4x2x2 makes 16 subdomains, not 17"));
  EXPECT_THAT(refusal("pqr:4x2"), HasSubstr("'4x2' is not of the form PxQxR"));
  for (const char* text : {"pqr:4x0x1", "pqr:4x-1x1", "pqr:4xax1", "pqr:4xx1", "pqr:99999999999x1x1"})
    EXPECT_THAT(refusal(text), HasSubstr("is not a number of slabs")) << text;
  EXPECT_THAT(refusal("pqr:65536x65536x1"), HasSubstr("too many subdomains"));
  EXPECT_THAT(refusal("pqr:2x2x2:crosswise"), HasSubstr("'crosswise' is not known"));
  EXPECT_THAT(refusal("bisection:2"), HasSubstr("bisection takes no options"));
  EXPECT_THAT(refusal(""), HasSubstr("'' is not known"));
}

}  // namespace
}  // namespace weft::partition::partitioner_test
