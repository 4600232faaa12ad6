// Values of facets and the legends that explain them.
#include "tools/picture/colouring.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "meshing/mesh/structured_box.h"
#include "meshing/metric/measures.h"
#include "meshing/metric/metric_field.h"

namespace weft::picture::colouring_test {
namespace {

using meshing::LogMetricField;
using meshing::MeshData;
using meshing::Point;

class ColouringTest : public testing::Test {
 protected:
  ColouringTest() {
    std::mt19937 random(11);
    std::normal_distribution<double> normal(0, 0.5);
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      const auto part = [&] { return normal(random); };
      metric_.push_back(meshing::identity_tensor(2 * std::log(4)) +
                        meshing::LogMetric{part(), part(), part(), part(), part(), part()});
      field_.push_back(linear(mesh_.points[v]));
    }
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) mesh_.tet_refs[t] = t % 2 ? 10 : -3;
  }

  static double linear(const Point& p) { return 1 + 2 * p.x - 3 * p.y + 5 * p.z; }
  ColourSource source(ColourBy by) const { return {by, mesh_, metric_, field_, "f"}; }
  std::vector<ShownFace> shown() const { return Surface(mesh_).behind(plane_); }
  double length(std::uint32_t a, std::uint32_t b) const {
    return meshing::edge_length(mesh_.points[b] - mesh_.points[a], meshing::exp_exact(metric_[a]),
                                meshing::exp_exact(metric_[b]));
  }

  MeshData mesh_ = meshing::structured_box({{4, 4, 4}, {0, 0, 0}, {1, 1, 1}});
  LogMetricField metric_;
  std::vector<double> field_;
  Plane plane_{{0.6, 0, 0.8}, 0.71};
};

TEST_F(ColouringTest, QualityIsTheMeanRatioOfTheTet) {
  const Colouring colouring(source(ColourBy::quality));
  for (const ShownFace& face : shown()) {
    std::array<Point, 4> points;
    std::array<meshing::LogMetric, 4> metrics;
    for (std::size_t i = 0; i < 4; ++i) {
      points[i] = mesh_.points[mesh_.tets[face.tet][i]];
      metrics[i] = metric_[mesh_.tets[face.tet][i]];
    }
    EXPECT_DOUBLE_EQ(colouring.facet(face).values[0], meshing::mean_ratio(points, metrics));
  }
}

TEST_F(ColouringTest, WithoutAMetricQualityIsThatOfTheShape) {
  const Colouring colouring({ColourBy::quality, mesh_, {}, {}, ""});
  const double kuhn = meshing::mean_ratio({Point{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}}, {});
  for (const ShownFace& face : shown()) EXPECT_NEAR(colouring.facet(face).values[0], kuhn, 1e-12);
}

TEST_F(ColouringTest, LengthsAreThoseOfTheEdgesOppositeTheCorners) {
  const Colouring colouring(source(ColourBy::length));
  for (const ShownFace& face : shown()) {
    const Facet facet = colouring.facet(face);
    EXPECT_EQ(facet.blend, Blend::nearest_edge);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(facet.values[i], length(face.vertices[(i + 1) % 3], face.vertices[(i + 2) % 3]), 1e-9);
  }
}

TEST_F(ColouringTest, NonconformingTetsHaveAnEdgeOutside) {
  const Colouring colouring(source(ColourBy::nonconforming));
  int red = 0, grey = 0;
  for (const ShownFace& face : shown()) {
    bool outside = false;
    const auto& tet = mesh_.tets[face.tet];
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        outside |=
            length(tet[i], tet[j]) > std::numbers::sqrt2 || length(tet[i], tet[j]) < 1 / std::numbers::sqrt2;
    EXPECT_EQ(colouring.facet(face).values[0], outside ? 1 : 0);
    ++(outside ? red : grey);
  }
  EXPECT_GT(red, 5);
  EXPECT_GT(grey, 5);
}

TEST_F(ColouringTest, ALinearFieldIsLinearOnFacesAndSections) {
  const Colouring colouring(source(ColourBy::field));
  std::vector<Facet> facets;
  for (const ShownFace& face : shown()) facets.push_back(colouring.facet(face));
  for (const Section& section : sections(mesh_, plane_)) colouring.append(section, facets);
  for (const Facet& facet : facets) {
    EXPECT_EQ(facet.blend, Blend::linear);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(facet.values[i], linear(facet.corners[i]), 1e-12);
  }
}

TEST_F(ColouringTest, SectionsTakeTheirTetsValue) {
  for (const ColourBy by : {ColourBy::quality, ColourBy::nonconforming, ColourBy::subdomain}) {
    const Colouring colouring(source(by));
    for (const Section& section : sections(mesh_, plane_)) {
      std::vector<Facet> facets;
      colouring.append(section, facets);
      EXPECT_EQ(facets.size(), static_cast<std::size_t>(section.size - 2));
      const auto& [a, b, c, d] = mesh_.tets[section.tet];
      for (const Facet& facet : facets)
        EXPECT_EQ(facet.values[0], colouring.facet({{a, b, c}, section.tet, {}, true}).values[0]);
      int drawn = 0;
      for (const Facet& facet : facets) drawn += facet.edges[0] + facet.edges[1] + facet.edges[2];
      EXPECT_EQ(drawn, section.size);
    }
  }
}

TEST_F(ColouringTest, TheLegendNamesWhatIsShownAndNothingElse) {
  meshing::RefNames names;
  names.set(2, 2, "outlet");
  const Colouring colouring(source(ColourBy::ref));
  std::vector<Facet> facets;
  for (const ShownFace& face : Surface(mesh_, std::vector<std::int32_t>{2, 3}).faces())
    facets.push_back(colouring.facet(face));
  const Legend legend = colouring.legend(facets, names, light_theme(), {});
  ASSERT_EQ(legend.entries.size(), 2u);
  EXPECT_EQ(legend.entries[0].label, "outlet");
  EXPECT_EQ(legend.entries[1].label, "3");
}

TEST_F(ColouringTest, SubdomainsAreReferencesOfTets) {
  const Colouring colouring(source(ColourBy::subdomain));
  std::vector<Facet> facets;
  for (const ShownFace& face : shown()) {
    facets.push_back(colouring.facet(face));
    EXPECT_EQ(facets.back().values[0], mesh_.tet_refs[face.tet] == 10 ? 1 : 0);
  }
  const Legend legend = colouring.legend(facets, {}, light_theme(), {});
  ASSERT_EQ(legend.entries.size(), 2u);
  EXPECT_EQ(legend.entries[0].label, "-3");
}

TEST_F(ColouringTest, AFieldsScaleIsItsRangeOrTheOneAskedFor) {
  const Colouring colouring(source(ColourBy::field));
  std::vector<Facet> facets;
  for (const ShownFace& face : Surface(mesh_).faces()) facets.push_back(colouring.facet(face));
  const Legend own = colouring.legend(facets, {}, light_theme(), {});
  EXPECT_NEAR(own.scale.lo, -2, 1e-12);
  EXPECT_NEAR(own.scale.hi, 8, 1e-12);
  EXPECT_EQ(own.title, "f");
  EXPECT_GE(own.ticks.size(), 3u);
  const Legend asked = colouring.legend(facets, {}, light_theme(), std::pair{0.0, 4.0});
  EXPECT_EQ(asked.scale.hi, 4);
}

TEST_F(ColouringTest, AConstantFieldHasOneTick) {
  field_.assign(field_.size(), 2.5);
  const Colouring colouring(source(ColourBy::field));
  const std::vector<Facet> facets = {colouring.facet(Surface(mesh_).faces().front())};
  const Legend legend = colouring.legend(facets, {}, light_theme(), {});
  ASSERT_EQ(legend.ticks.size(), 1u);
  EXPECT_EQ(legend.ticks[0].label, "2.5");
}

TEST_F(ColouringTest, AFieldThatRoundingAloneVariesHasOneTick) {
  for (std::size_t v = 0; v < field_.size(); ++v) field_[v] = v % 2 ? 2.5 : std::nextafter(2.5, 3.0);
  const Colouring colouring(source(ColourBy::field));
  const std::vector<Facet> facets = {colouring.facet(Surface(mesh_).faces().front())};
  const Legend legend = colouring.legend(facets, {}, light_theme(), {});
  EXPECT_LT(legend.scale.lo, legend.scale.hi);
  ASSERT_EQ(legend.ticks.size(), 1u);
  EXPECT_EQ(legend.ticks[0].label, "2.5");
}

}  // namespace
}  // namespace weft::picture::colouring_test
