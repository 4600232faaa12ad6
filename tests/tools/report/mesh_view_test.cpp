// The view shows the surface and sections that the mesh has, from whole meshes and from pieces, and thinned
// out loses nothing bad.
#include "tools/report/mesh_view.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "engine/json/json.h"
#include "meshing/base/error.h"
#include "meshing/mesh/structured_box.h"
#include "meshing/metric/metric_field.h"

namespace weft::report::mesh_view_test {
namespace {

using meshing::Box;
using meshing::MeshData;

struct Shaken {
  MeshData mesh;
  meshing::LogMetricField metric;
  Box box;
};

/// A box with its inner vertices moved at random.
Shaken shaken_box(std::uint32_t cells, unsigned seed) {
  Shaken s;
  s.mesh = meshing::structured_box({.cells = {cells, cells, cells}, .min = {0, 0, 0}, .max = {1, 2, 3}});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.1 / cells, 0.1 / cells);
  const meshing::Point corner{1, 2, 3};
  for (meshing::Point& p : s.mesh.points)
    for (int a = 0; a < 3; ++a)
      if (p[a] > 0 && p[a] < corner[a]) p[a] += shift(random);
  for (const meshing::Point& p : s.mesh.points) s.box.include(p);
  s.metric = meshing::sample(meshing::AnalyticMetric("uniform:0.4"), s.mesh);
  return s;
}

double area(const ViewLayer& layer) {
  double sum = 0;
  for (const ViewFacet& facet : layer.facets) {
    const auto point = [&](std::size_t i) {
      return meshing::Point{facet.corners[i][0], facet.corners[i][1], facet.corners[i][2]};
    };
    sum += norm(cross(point(1) - point(0), point(2) - point(0))) / 2;
  }
  return sum;
}

MeshView whole_view(const Shaken& s, const MeshViewOptions& options = {}) {
  return mesh_view(std::array{ViewedPiece{s.mesh, s.metric, 5}}, s.box, options);
}

/// With more facets than any mesh here has.
MeshViewOptions unlimited(int sections) {
  return {.sections = sections, .surface_facets = 1'000'000, .section_facets = 1'000'000};
}

void expect_same(const MeshView& a, const MeshView& b) {
  ASSERT_EQ(a.layers.size(), b.layers.size());
  for (std::size_t l = 0; l < a.layers.size(); ++l) {
    EXPECT_EQ(a.layers[l].thinned, b.layers[l].thinned);
    ASSERT_EQ(a.layers[l].facets.size(), b.layers[l].facets.size());
    for (std::size_t f = 0; f < a.layers[l].facets.size(); ++f) {
      const ViewFacet &mine = a.layers[l].facets[f], &other = b.layers[l].facets[f];
      EXPECT_EQ(mine.corners, other.corners);
      EXPECT_EQ(mine.subdomain, other.subdomain);
      EXPECT_EQ(mine.quality, other.quality);
      EXPECT_EQ(mine.length, other.length);
      EXPECT_EQ(mine.deviation, other.deviation);
    }
  }
}

TEST(MeshView, ShowsTheSurfaceAndSectionsWholly) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Shaken s = shaken_box(4, seed);
    const MeshView view = whole_view(s);
    ASSERT_EQ(view.layers.size(), 1u + 3 * 7);
    EXPECT_NEAR(area(view.layers[0]), 22, 1e-4);
    const double areas[] = {6, 3, 2};
    for (std::size_t l = 1; l < view.layers.size(); ++l) {
      const ViewLayer& layer = view.layers[l];
      EXPECT_NEAR(area(layer), areas[layer.axis], 1e-4);
      for (const ViewFacet& facet : layer.facets)
        for (const auto& corner : facet.corners)
          EXPECT_NEAR(corner[static_cast<std::size_t>(layer.axis)], layer.position, 1e-5);
    }
  }
}

TEST(MeshView, KnowsSubdomainQualityAndLength) {
  const Shaken s = shaken_box(3, 1);
  for (const ViewLayer& layer : whole_view(s).layers)
    for (const ViewFacet& facet : layer.facets) {
      EXPECT_EQ(facet.subdomain, 5u);
      EXPECT_GT(facet.quality, 0);
      EXPECT_LE(facet.quality, 1);
      EXPECT_GT(facet.length, 0.1);
      EXPECT_LT(facet.length, 10);
    }
}

/// The tets of `mesh` for which `mine` holds, with the triangles on them.
template <class Mine>
MeshData part_of(const MeshData& mesh, const Mine& mine) {
  MeshData part = mesh;
  part.tets.clear(), part.tet_refs.clear(), part.triangles.clear(), part.triangle_refs.clear();
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (!mine(t)) continue;
    part.tets.push_back(mesh.tets[t]), part.tet_refs.push_back(1);
    for (const auto& triangle : mesh.triangles) {
      const auto has = [&](std::uint32_t v) {
        return std::ranges::find(mesh.tets[t], v) != mesh.tets[t].end();
      };
      if (std::ranges::all_of(triangle, has))
        part.triangles.push_back(triangle), part.triangle_refs.push_back(1);
    }
  }
  return part;
}

std::vector<MeshData> random_parts(const MeshData& mesh, int count) {
  std::mt19937 random(5);
  std::vector<int> owner(mesh.tets.size());
  for (int& o : owner) o = static_cast<int>(random() % static_cast<unsigned>(count));
  std::vector<MeshData> parts;
  for (int p = 0; p < count; ++p)
    parts.push_back(part_of(mesh, [&](std::size_t t) { return owner[t] == p; }));
  return parts;
}

TEST(MeshView, OfPiecesIsThatOfTheWhole) {
  const Shaken s = shaken_box(4, 3);
  const MeshView whole = whole_view(s);
  std::vector<ViewedPiece> pieces;
  MeshView appended;
  const std::vector<MeshData> parts = random_parts(s.mesh, 3);
  for (const MeshData& part : parts) {
    pieces.push_back({part, s.metric, 5});
    append(appended, mesh_view(std::array{pieces.back()}, s.box, {}));
  }
  const MeshView together = mesh_view(pieces, s.box, {});
  expect_same(together, appended);
  ASSERT_EQ(together.layers.size(), whole.layers.size());
  for (std::size_t l = 0; l < whole.layers.size(); ++l) {
    EXPECT_EQ(together.layers[l].facets.size(), whole.layers[l].facets.size());
    EXPECT_NEAR(area(together.layers[l]), area(whole.layers[l]), 1e-5);
  }
}

TEST(MeshView, OfNoPiecesHasTheLayersOfAny) {
  const Shaken s = shaken_box(2, 3);
  MeshView view = mesh_view({}, s.box, {});
  append(view, whole_view(s));
  expect_same(view, whole_view(s));
}

TEST(MeshView, RefusesIndicesOutOfRange) {
  Shaken s = shaken_box(2, 3);
  const auto points = static_cast<std::uint32_t>(s.mesh.points.size());
  s.mesh.tets.back()[2] = points;
  EXPECT_THROW(whole_view(s), meshing::InputError);
  s = shaken_box(2, 3);
  s.mesh.triangles.back()[1] = points;
  EXPECT_THROW(whole_view(s), meshing::InputError);
}

bool is_unit(const ViewFacet& facet) {
  return facet.length >= 1 / std::numbers::sqrt2 && facet.length <= std::numbers::sqrt2;
}

TEST(MeshView, IsThinnedOutToItsLimits) {
  const Shaken s = shaken_box(12, 3);
  const MeshViewOptions options{.sections = 2, .surface_facets = 500, .section_facets = 100};
  const MeshView view = whole_view(s, options);
  EXPECT_GT(whole_view(s, unlimited(2)).layers[0].facets.size(), 500u);
  EXPECT_LE(view.layers[0].facets.size(), 500u);
  EXPECT_GT(view.layers[0].facets.size(), 50u);
  EXPECT_TRUE(view.layers[0].thinned);
  EXPECT_NEAR(area(view.layers[0]), 22, 8);
  for (std::size_t l = 1; l < view.layers.size(); ++l) EXPECT_LE(view.layers[l].facets.size(), 100u);
}

/// Values are worked out after thinning, of the tets that count: as if it had been of all before.
TEST(MeshView, HasTheValuesThatThinningAllFacetsLeaves) {
  const Shaken s = shaken_box(12, 3);
  const MeshViewOptions options{.sections = 3, .surface_facets = 400, .section_facets = 90};
  std::vector<ViewedPiece> pieces;
  const std::vector<MeshData> parts = random_parts(s.mesh, 3);
  for (std::uint32_t p = 0; p < parts.size(); ++p) pieces.push_back({parts[p], s.metric, p});
  MeshView all = mesh_view(pieces, s.box, unlimited(3));
  thin_out(all, s.box, options);
  expect_same(mesh_view(pieces, s.box, options), all);
}

TEST(MeshView, DoesNotDependOnThreads) {
  const Shaken s = shaken_box(20, 3);
  const MeshViewOptions options{.sections = 3, .surface_facets = 2000, .section_facets = 400};
  const auto made_by = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return whole_view(s, options);
  };
  const MeshView one = made_by(1);
  for (const std::size_t threads : {2, 3, 8}) expect_same(made_by(threads), one);
}

TEST(MeshView, KeepsMostOfWhatItMayWhereItIsThinnedOut) {
  const Shaken s = shaken_box(40, 3);
  const MeshView view = whole_view(s, {.sections = 3, .surface_facets = 10'000, .section_facets = 2'000});
  for (const ViewLayer& layer : view.layers) {
    EXPECT_TRUE(layer.thinned);
    EXPECT_GT(layer.facets.size(), layer.axis < 0 ? 5'000u : 1'000u);
  }
}

/// Every facet that stays has at most the quality of the best that it can stand for, and a mesh with nothing
/// but facets that do not conform keeps only such.
TEST(MeshView, StaysRedWhereItIsThinnedOut) {
  Shaken s = shaken_box(10, 4);
  s.metric = meshing::sample(meshing::AnalyticMetric("uniform:0.01"), s.mesh);
  const MeshView view = whole_view(s, {.sections = 1, .surface_facets = 300, .section_facets = 100});
  for (const ViewLayer& layer : view.layers)
    for (const ViewFacet& facet : layer.facets) EXPECT_FALSE(is_unit(facet));
}

TEST(MeshView, IsLeftAsItIsWithinItsLimits) {
  const Shaken s = shaken_box(3, 2);
  const MeshView view = whole_view(s);
  EXPECT_EQ(view.layers[0].facets.size(), 2u * 6 * 9);
  MeshView again = view;
  thin_out(again, s.box, {});
  expect_same(again, view);
  for (const ViewLayer& layer : view.layers) EXPECT_FALSE(layer.thinned);
}

TEST(MeshView, IsWrittenWithSharedVertices) {
  const Shaken s = shaken_box(3, 2);
  const MeshView view = whole_view(s);
  const nlohmann::ordered_json json = json_of(view, s.box);
  const auto& surface = json["layers"][0];
  EXPECT_EQ(surface["facets"], 2 * 6 * 9);
  EXPECT_EQ(surface["corners"].get<std::string>().size(), 4u * 2 * 6 * 9 * 3 * 4 / 3);  // base64 of uint32
  EXPECT_EQ(surface["positions"].get<std::string>().size(), 4u * 56 * 3 * 2 / 3);       // 4^3 - 2^3 vertices
  EXPECT_EQ(json["box"][1][2], 3);
}

}  // namespace
}  // namespace weft::report::mesh_view_test
