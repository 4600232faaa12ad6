// The judges of a result that lies on a CAD model.
#include "tools/library/jobs/run_result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace weft::tools::run_result_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

meshing::ModelAccount account(std::uint64_t off, double largest, std::uint64_t turned) {
  meshing::ModelAccount a;
  a.vertices = 1000;
  a.triangles = 2000;
  a.off = off;
  a.largest = largest;
  a.turned = turned;
  meshing::ModelEntityAccount edge, face;
  edge.kind = meshing::ModelEntityAccount::Kind::edge;
  edge.id = 7;
  edge.largest = largest;
  face.id = 4;
  face.turned = turned;
  a.entities = {edge, face};
  return a;
}

TEST(ResultOnModel, ThatHasNoFaultsIsNeitherWarnedOfNorMissed) {
  std::vector<std::string> warnings;
  warn_of_faults(account(0, 1e-12, 0), warnings);
  EXPECT_THAT(warnings, IsEmpty());
  EXPECT_THAT(worse_on_model(account(0, 1e-12, 0)), IsEmpty());
}

TEST(ResultOnModel, ThatIsOffItIsWarnedOfWithNumberDistanceAndEntity) {
  std::vector<std::string> warnings;
  warn_of_faults(account(3, 9.55, 2), warnings);
  EXPECT_THAT(warnings, ElementsAre(AllOf(HasSubstr("3 of 1,000"), HasSubstr("9.55"), HasSubstr("edge 7")),
                                    AllOf(HasSubstr("2 of 2,000"), HasSubstr("face 4"))));
}

TEST(ResultOnModel, MissesItsGoalWhereTheInputWasBetter) {
  meshing::ModelAccount a = account(3, 0.5, 0);
  EXPECT_THAT(worse_on_model(a), ElementsAre(HasSubstr("of the input 0")));
  a.input = {3, 0.5, 0};  // these could not be mended
  EXPECT_THAT(worse_on_model(a), IsEmpty());
  a.input = {3, 0.1, 0};  // farther off than they were
  EXPECT_EQ(worse_on_model(a).size(), 1u);
  a = account(0, 0, 5);
  a.input.turned = 5;
  EXPECT_THAT(worse_on_model(a), IsEmpty());
  a.input.turned = 4;
  EXPECT_THAT(worse_on_model(a), ElementsAre(HasSubstr("turned")));
  EXPECT_THAT(missed_goals(std::nullopt, 0, "", &a), ElementsAre(HasSubstr("turned")));
  EXPECT_THAT(missed_goals(std::nullopt, 0, "", nullptr), IsEmpty());
}

}  // namespace
}  // namespace weft::tools::run_result_test
