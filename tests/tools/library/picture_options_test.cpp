// Sizes, boxes and planes as text.
#include "tools/library/pictures/picture_options.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "weft/weft.h"

namespace weft::tools::picture_options_test {
namespace {

TEST(PictureOptions, SizesHaveBounds) {
  EXPECT_EQ(picture_size("640x480"), (std::pair{640, 480}));
  for (const char* bad :
       {"640", "640x", "x480", "640x480x", "640x48.5", "15x100", "100x15", "16001x100", "-640x480", ""})
    EXPECT_THROW(picture_size(bad), std::invalid_argument) << bad;
}

TEST(PictureOptions, BoxesTakeAnyTwoCorners) {
  const meshing::Box box = box_in("1,-2,3,-1,2,5e0");
  EXPECT_EQ(box.lo, (meshing::Point{-1, -2, 3}));
  EXPECT_EQ(box.hi, (meshing::Point{1, 2, 5}));
  for (const char* bad :
       {"", "1,2,3", "1,2,3,4,5,6,7", "1,2,3,4,5,", "1,2,3,4,5,x", "1,2,3,4,5,nan", "1,2,3,4,5,inf"})
    EXPECT_THROW(box_in(bad), std::invalid_argument) << bad;
}

TEST(PictureOptions, TheEyesSideOfAnAxisPlaneIsInFront) {
  EXPECT_GT(plane_in("y=0.5", {1, 1, 1}).distance({0, 1, 0}), 0);
  EXPECT_GT(plane_in("y=0.5", {1, -1, 1}).distance({0, 0, 0}), 0);
  EXPECT_GT(plane_in("z=-2", {1, 0, 0}).distance({0, 0, 0}), 0);
  EXPECT_EQ(plane_in("z=-2", {0, 0, -1}).distance({7, 7, -2}), 0);
}

TEST(PictureOptions, ANormalPointsToTheFront) {
  const picture::Plane plane = plane_in("1,1,1,0,0,-5", {0, 0, 1});
  EXPECT_DOUBLE_EQ(plane.distance({3, 4, 0}), 1);
  EXPECT_DOUBLE_EQ(plane.distance({3, 4, 3}), -2);
}

TEST(PictureOptions, PlanesThatAreNone) {
  for (const char* bad :
       {"", "x", "x=", "x=a", "w=1", "x=1,2", "1,2,3", "0,0,0,0,0,0", "x=nan", "0,0,0,1,0,inf"})
    EXPECT_THROW(plane_in(bad, {0, 0, 1}), std::invalid_argument) << bad;
}

TEST(PictureOptions, TheExtensionNamesTheFormat) {
  EXPECT_EQ(picture_format("a/b.pdf"), picture::Canvas::Format::pdf);
  EXPECT_EQ(picture_format("b.c.svg"), picture::Canvas::Format::svg);
  EXPECT_TRUE(is_picture_name("b.png"));
  EXPECT_FALSE(is_picture_name("b.jpg"));
  EXPECT_FALSE(is_picture_name("png"));
}

}  // namespace
}  // namespace weft::tools::picture_options_test
