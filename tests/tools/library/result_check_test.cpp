// The final check of a mesh that is given away.
#include "tools/library/jobs/result_check.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace weft::tools::result_check_test {
namespace {

std::string problem_of(const Mesh& mesh) {
  try {
    check_conforms(mesh);
  } catch (const RunError& error) {
    return error.what();
  }
  return {};
}

TEST(ResultCheck, SaysWhatIsWrong) {
  const Mesh good = box({{2, 2, 2}});
  EXPECT_EQ(problem_of(good), "");
  Mesh turned = good;
  std::swap(turned.tets[5][0], turned.tets[5][1]);
  EXPECT_NE(problem_of(turned).find("the result does not conform\n  tet 6"), std::string::npos)
      << problem_of(turned);
  Mesh hole = good;
  hole.tets.erase(hole.tets.begin() + 7);
  hole.tet_refs.pop_back();
  EXPECT_NE(problem_of(hole), "");
  Mesh open = good;
  open.triangles.pop_back();
  open.triangle_refs.pop_back();
  EXPECT_NE(problem_of(open), "");
}

}  // namespace
}  // namespace weft::tools::result_check_test
