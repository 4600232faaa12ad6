// GMF files written in parts: the bytes of the whole writer, wherever and in whatever order the parts come.
#include "meshing/io/gmf/gmf_slice_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/io/gmf/gmf_slice.h"
#include "tests/meshing/io/format_support.h"
#include "tests/support/meshes.h"

namespace weft::meshing::gmf_slice_writer_test {
namespace {

using gmf::Keyword;

/// A cube with all kinds of marks.
MeshData marked_cube() {
  MeshData mesh = support::unit_cube(3);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) mesh.point_refs[i] = static_cast<std::int32_t>(i % 4);
  mesh.required_points = {3, 1};
  mesh.required_edges = {2, 0, 5};
  mesh.required_triangles = {0, 4};
  return mesh;
}

template <std::size_t N>
std::vector<std::array<std::uint64_t, N>> wide(const std::vector<std::array<std::uint32_t, N>>& narrow) {
  std::vector<std::array<std::uint64_t, N>> result;
  for (const auto& entity : narrow) {
    result.emplace_back();
    std::copy(entity.begin(), entity.end(), result.back().begin());
  }
  return result;
}
std::vector<std::uint64_t> wide(const std::vector<std::uint32_t>& narrow) {
  return {narrow.begin(), narrow.end()};
}

/// Entries begin to end of an array.
template <class T>
std::vector<T> part(const std::vector<T>& all, std::size_t begin, std::size_t end) {
  return {all.begin() + static_cast<std::ptrdiff_t>(begin), all.begin() + static_cast<std::ptrdiff_t>(end)};
}

using Task = std::function<void(GmfSliceWriter&)>;

/// Cuts the rows [0, n) at random places and adds a task for each part.
void add_tasks(std::size_t n, std::mt19937& random, std::vector<Task>& tasks,
               const std::function<void(GmfSliceWriter&, std::size_t, std::size_t)>& write) {
  for (std::size_t begin = 0, end; begin < n || begin == 0; begin = end) {
    end = std::min<std::size_t>(n, begin + random() % (n / 2 + 2));
    tasks.push_back([=](GmfSliceWriter& out) { write(out, begin, end); });
    if (n == 0) return;
  }
}

template <std::size_t N>
void add_elements(Keyword code, const std::vector<std::array<std::uint32_t, N>>& elements,
                  const std::vector<std::int32_t>& refs, std::mt19937& random, std::vector<Task>& tasks) {
  add_tasks(elements.size(), random, tasks, [=](GmfSliceWriter& out, std::size_t begin, std::size_t end) {
    out.elements(code, begin, part(wide(elements), begin, end), part(refs, begin, end));
  });
}

std::vector<Task> tasks_of(const MeshData& mesh, std::mt19937& random) {
  std::vector<Task> tasks = {[](GmfSliceWriter& out) { out.frame(); }};
  add_tasks(mesh.points.size(), random, tasks, [=](GmfSliceWriter& out, std::size_t begin, std::size_t end) {
    out.vertices(begin, part(mesh.points, begin, end), part(mesh.point_refs, begin, end));
  });
  add_elements(gmf::kTetrahedra, mesh.tets, mesh.tet_refs, random, tasks);
  add_elements(gmf::kTriangles, mesh.triangles, mesh.triangle_refs, random, tasks);
  add_elements(gmf::kEdges, mesh.edges, mesh.edge_refs, random, tasks);
  const auto add_list = [&](Keyword code, const std::vector<std::uint32_t>& list) {
    add_tasks(list.size(), random, tasks, [=](GmfSliceWriter& out, std::size_t begin, std::size_t end) {
      out.indices(code, begin, part(wide(list), begin, end));
    });
  };
  add_list(gmf::kCorners, mesh.corners);
  add_list(gmf::kRidges, mesh.ridges);
  add_list(gmf::kRequiredVertices, mesh.required_points);
  add_list(gmf::kRequiredEdges, mesh.required_edges);
  add_list(gmf::kRequiredTriangles, mesh.required_triangles);
  std::shuffle(tasks.begin(), tasks.end(), random);
  return tasks;
}

class GmfSliceWriting : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Versions, GmfSliceWriting, testing::Values(0, 1, 2, 3, 4));

TEST_P(GmfSliceWriting, PartsOfAMeshGiveTheBytesOfTheWhole) {
  std::mt19937 random(5);
  const TemporaryDirectory directory;
  MeshData without = marked_cube();  // has no rows in some sections
  without.corners.clear();
  without.required_edges.clear();
  for (const MeshData& mesh : {marked_cube(), without, MeshData{}}) {
    write_gmf_mesh(directory / "whole.meshb", mesh, GetParam());
    for (int trial = 0; trial < 5; ++trial) {
      const GmfPlan plan = GmfPlan::of_mesh("m.meshb", gmf::counts_of(mesh), GetParam());
      put_bytes(directory / "parts", "");
      GmfSliceWriter first({directory / "parts", plan.name()}, plan),
          second({directory / "parts", plan.name()}, plan);
      for (const Task& task : tasks_of(mesh, random)) task(random() % 2 ? first : second);
      first.finish();
      second.finish();
      EXPECT_TRUE(bytes_of(directory / "parts") == bytes_of(directory / "whole.meshb"));
    }
  }
}

TEST_P(GmfSliceWriting, PartsOfASolutionGiveTheBytesOfTheWhole) {
  const TemporaryDirectory directory;
  SolutionData whole{5, {{Field::Kind::scalar, {1, 2, 3, 4, 5}, ""}, {Field::Kind::vector, {}, ""}}};
  for (int i = 0; i < 15; ++i) whole.fields[1].values.push_back(0.5 * i);
  write_gmf_solution(directory / "whole.solb", whole, GetParam());
  const GmfPlan plan = GmfPlan::of_solution("s.solb", 5, gmf::kinds_of(whole), GetParam());
  put_bytes(directory / "parts", "");
  GmfSliceWriter out({directory / "parts", plan.name()}, plan);
  for (const std::size_t begin : {2, 0}) {
    const std::size_t end = begin == 0 ? 2 : 5;
    SolutionData slice{end - begin, whole.fields};
    slice.fields[0].values = part(whole.fields[0].values, begin, end);
    slice.fields[1].values = part(whole.fields[1].values, 3 * begin, 3 * end);
    out.solution(begin, slice);
  }
  out.frame();
  out.finish();
  EXPECT_TRUE(bytes_of(directory / "parts") == bytes_of(directory / "whole.solb"));
}

TEST(GmfPlans, ChooseTheVersionBySizeAndPlaceRowsBeyondFourGibibytes) {
  const TemporaryDirectory directory;  // files with holes take no room
  struct Case {
    std::uint64_t points;
    int version;
  };
  for (const auto& [points, version] :
       {Case{1000, 2}, Case{70000000, 2}, Case{80000000, 3}, Case{200000000, 3}, Case{2200000000u, 4}}) {
    const GmfPlan plan = GmfPlan::of_mesh("m.meshb", {.points = points, .tets = 1});
    EXPECT_EQ(plan.version(), version);
    put_bytes(directory / "m.meshb", "");
    GmfSliceWriter out({directory / "m.meshb", plan.name()}, plan);
    const std::vector<Point> last = {{0.5, -1, 2}};
    const std::vector<std::int32_t> ref = {7};
    out.vertices(points - 1, last, ref);
    out.elements(gmf::kTetrahedra, 0, std::vector<std::array<std::uint64_t, 4>>{{0, 1, 2, points - 1}},
                 std::vector<std::int32_t>{3});
    out.frame();
    out.finish();
    const GmfLayout layout = read_gmf_layout(directory / "m.meshb");
    EXPECT_EQ(layout.num_points(), points);
    EXPECT_EQ(read_gmf_points(directory / "m.meshb", layout, points - 1, 1).points, last);
    EXPECT_EQ(read_gmf_points(directory / "m.meshb", layout, points - 1, 1).refs, ref);
    EXPECT_EQ(read_gmf_tets(directory / "m.meshb", layout, 0, 1).tets[0][3], points - 1);
  }
}

TEST(GmfPlans, RefuseWhatCannotBe) {
  const TemporaryDirectory directory;
  expect_contains(message_of([] { GmfPlan::of_mesh("m.meshb", {.points = 100000000}, 2); }),
                  "m.meshb: too large for GMF version 2");
  const GmfPlan plan = GmfPlan::of_mesh("m.meshb", {.points = 3});
  expect_contains(message_of([&] {
                    GmfSliceWriter({directory / "none", plan.name()}, plan);
                  }),
                  "m.meshb: cannot write: No such file or directory");
  put_bytes(directory / "parts", "");
  GmfSliceWriter out({directory / "parts", plan.name()}, plan);
  EXPECT_THROW(out.vertices(2, std::vector<Point>(2), std::vector<std::int32_t>(2)), std::out_of_range);
  EXPECT_THROW(out.indices(gmf::kCorners, 0, {1}), std::out_of_range);
  EXPECT_NO_THROW(out.indices(gmf::kCorners, 0, {}));
}

}  // namespace
}  // namespace weft::meshing::gmf_slice_writer_test
