// Whole figures: what comes out is a picture, whatever goes in. tests/tools/view_test.py looks at the pixels.
#include "tools/picture/mesh_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "meshing/base/error.h"
#include "meshing/mesh/structured_box.h"
#include "meshing/metric/metric_field.h"
#include "tools/picture/histogram_plot.h"

namespace weft::picture::mesh_picture_test {
namespace {

using meshing::MeshData;
using testing::StartsWith;

constexpr ColourBy kColourings[] = {ColourBy::none,    ColourBy::ref,    ColourBy::subdomain,
                                    ColourBy::quality, ColourBy::length, ColourBy::nonconforming,
                                    ColourBy::field};
constexpr const char* kPngStart = "\x89PNG\r\n";

class MeshPicture : public testing::Test {
 protected:
  MeshPicture() {
    options_.width = 120;
    options_.height = 90;
    for (const meshing::Point& p : mesh_.points) field_.push_back(p.x);
  }

  std::string draw(ColourBy by, Canvas::Format format = Canvas::Format::png) const {
    return mesh_picture({by, mesh_, metric_, field_, "f"}, {}, options_, format);
  }

  MeshData mesh_ = meshing::structured_box({{3, 3, 3}, {0, 0, 0}, {1, 1, 1}});
  meshing::LogMetricField metric_{mesh_.points.size(), meshing::log_of(meshing::identity_tensor(9))};
  std::vector<double> field_;
  PictureOptions options_;
};

/// Width and height in the header of a PNG.
std::pair<int, int> size_of(const std::string& png) {
  const auto number = [&](std::size_t at) {
    int value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = 256 * value + static_cast<unsigned char>(png[i]);
    return value;
  };
  return {number(16), number(20)};
}

TEST_F(MeshPicture, EveryColouringWithEveryCut) {
  for (const ColourBy by : kColourings)
    for (const bool planar : {false, true}) {
      options_.cut.reset();
      const std::string whole = draw(by);
      options_.cut = Plane{{0.6, -0.8, 0}, -0.15};
      options_.planar = planar;
      const std::string half = draw(by);
      EXPECT_THAT(whole, StartsWith(kPngStart));
      EXPECT_THAT(half, StartsWith(kPngStart));
      EXPECT_NE(whole, half);
    }
}

TEST_F(MeshPicture, EveryFormat) {
  EXPECT_EQ(size_of(draw(ColourBy::quality)), (std::pair{120, 90}));
  EXPECT_THAT(draw(ColourBy::quality, Canvas::Format::pdf), StartsWith("%PDF"));
  EXPECT_THAT(draw(ColourBy::quality, Canvas::Format::svg), StartsWith("<?xml"));
}

TEST_F(MeshPicture, ASmallSheetHoldsAnything) {
  options_.width = options_.height = 16;
  options_.title = "a title much longer than the sheet is wide";
  for (std::size_t i = 0; i < mesh_.triangle_refs.size(); ++i)
    mesh_.triangle_refs[i] = static_cast<int>(i) - 20;
  for (const ColourBy by : kColourings) EXPECT_EQ(size_of(draw(by)), (std::pair{16, 16}));
}

TEST_F(MeshPicture, NamesThatAreNoUtf8HaveQuestionMarks) {
  const auto with_title = [&](const std::string& title) {
    options_.title = title;
    return draw(ColourBy::none);
  };
  EXPECT_EQ(with_title("pi\350ce"), with_title("pi?ce"));
}

TEST_F(MeshPicture, MoreReferencesThanTheLegendHasRoomFor) {
  const std::string few = draw(ColourBy::ref);
  for (std::size_t i = 0; i < mesh_.triangle_refs.size(); ++i) mesh_.triangle_refs[i] = static_cast<int>(i);
  EXPECT_NE(draw(ColourBy::ref), few);
}

TEST_F(MeshPicture, AFlatMeshSeenEdgeOnIsEmptyButAPicture) {
  MeshData flat;
  flat.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.point_refs = {0, 0, 0};
  flat.triangles = {{0, 1, 2}};
  flat.triangle_refs = {1};
  options_.view = {{1, 0, 0}, {0, 0, 1}};
  EXPECT_THAT(mesh_picture({ColourBy::none, flat, {}, {}, ""}, {}, options_, Canvas::Format::png),
              StartsWith(kPngStart));
}

TEST_F(MeshPicture, NothingToShowIsSaid) {
  options_.cut = Plane{{1, 0, 0}, -1};
  EXPECT_THROW(draw(ColourBy::none), meshing::InputError);
  options_.cut.reset();
  options_.only = {77};
  EXPECT_THROW(draw(ColourBy::none), meshing::InputError);
  mesh_ = {};
  metric_.clear();
  options_.only.reset();
  EXPECT_THROW(draw(ColourBy::none), meshing::InputError);
}

TEST(HistogramPlot, TakesMeasuresOfAllSizes) {
  const MeshData mesh = meshing::structured_box({{2, 2, 2}, {0, 0, 0}, {1, 1, 1}});
  std::string last;
  for (const double size : {1e-6, 0.5, 3.0, 1e6}) {
    const meshing::LogMetricField metric(mesh.points.size(),
                                         meshing::log_of(meshing::identity_tensor(1 / (size * size))));
    const std::string png =
        histogram_plot(meshing::measure(mesh, metric), {"t", "a", "b"}, Canvas::Format::png);
    EXPECT_THAT(png, StartsWith(kPngStart));
    EXPECT_NE(png, last);
    last = png;
  }
}

}  // namespace
}  // namespace weft::picture::mesh_picture_test
