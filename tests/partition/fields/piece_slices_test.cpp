// Slices refuse what their 32 bits cannot number; that what they hold is right, transfers of results show.
#include "partition/fields/piece_slices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "meshing/base/error.h"
#include "partition/communication/point_limit.h"

namespace weft::partition::piece_slices_test {
namespace {

TEST(PointLimit, IsTheLargestNumberOf32BitsButOneThatStandsForNone) {
  EXPECT_EQ(too_many_points(0xFFFFFFFE), "");
  EXPECT_EQ(too_many_points(0xFFFFFFFF), "4294967295 vertices exceed the limit of 4294967294");
}

TEST(SliceOfPieces, OfMoreVerticesThanSlicesCanNumberIsRefused) {
  SelfPeers alone;
  Numbering numbering;
  numbering.totals.points = std::uint64_t{1} << 32;
  EXPECT_THAT([&] { slice_of_pieces(alone, {}, numbering); },
              testing::ThrowsMessage<meshing::InputError>(testing::HasSubstr("4294967296 vertices exceed")));
}

}  // namespace
}  // namespace weft::partition::piece_slices_test
