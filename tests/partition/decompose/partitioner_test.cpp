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
