// Sound pieces pass on any ranks; what is wrong with others is named on all.
#include "partition/verify/check_result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <mutex>
#include <string>

#include "partition/verify/check_subdomains.h"
#include "tests/partition/output/piece_support.h"

namespace weft::partition::check_result_test {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

/// What each rank hears; empty: all is well.
std::vector<std::string> told_on(int ranks, const std::vector<MeshPiece>& pieces) {
  const auto hands = deal(pieces, ranks, static_cast<unsigned>(ranks));
  std::mutex mutex;
  std::vector<std::string> told;
  run_on_ranks(ranks, [&](Peers& peers) {
    std::string problem;
    try {
      check_result(peers, hands[peers.rank()]);
    } catch (const InvariantViolation& violation) {
      problem = violation.what();
    }
    const std::lock_guard lock(mutex);
    told.push_back(problem);
  });
  return told;
}

TEST(CheckResult, SoundPiecesPass) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const CutMesh cut = random_cut(seed);
    for (const int ranks : kRankCounts) EXPECT_THAT(told_on(ranks, cut.pieces), Each(std::string()));
  }
}

std::vector<std::string> told_after(const std::function<void(MeshPiece&)>& damage) {
  std::vector<MeshPiece> pieces = random_cut(3).pieces;
  damage(pieces[1]);
  std::vector<std::string> told = told_on(1, pieces);
  for (const int ranks : kRankCounts) EXPECT_THAT(told_on(ranks, pieces), Each(told[0]));
  return told;
}

TEST(CheckResult, NamesWhatIsWrong) {
  EXPECT_THAT(told_after([](MeshPiece& piece) {
                piece.mesh.tets.pop_back();
                piece.mesh.tet_refs.pop_back();
              }),
              Each(AllOf(HasSubstr("in the result"), HasSubstr("face"))));
  EXPECT_THAT(told_after([](MeshPiece& piece) { std::swap(piece.mesh.tets[0][0], piece.mesh.tets[0][1]); }),
              Each(HasSubstr("inverted")));
  EXPECT_THAT(told_after([](MeshPiece& piece) {
                piece.mesh.triangles.pop_back();
                piece.mesh.triangle_refs.pop_back();
              }),
              Each(HasSubstr("triangle")));
}

}  // namespace
}  // namespace weft::partition::check_result_test
