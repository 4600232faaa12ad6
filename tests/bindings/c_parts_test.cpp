// Parts through the C interface: what one rank does wrong, all hear of. Under mpirun, with any number of
// ranks.
#include <gtest/gtest.h>
#include <weft/weft-c.h>

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

namespace {

struct OnRank {
  OnRank() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  }
  int rank = 0, ranks = 1;
};

struct Input {
  weft_mesh* mesh = nullptr;
  weft_part* part = nullptr;
  weft_metric* metric = nullptr;
  weft_options* options = nullptr;
  ~Input() {
    weft_free(mesh);
    weft_free(part);
    weft_free(metric);
    weft_free(options);
  }
};

/// What a call is given of it.
struct Arguments {
  weft_part* part;
  weft_metric* metric;
  weft_options* options;
};

/// The whole box on rank 0, nothing on the others.
void make(const OnRank& me, Input& in) {
  if (me.rank == 0)
    weft_mesh_box(3, 3, 3, &in.mesh);
  else
    weft_mesh_create(0, nullptr, 0, nullptr, &in.mesh);
  int64_t points = 0;
  weft_mesh_num_points(in.mesh, &points);
  std::vector<int64_t> ids;
  for (int64_t i = 0; i < points; ++i) ids.push_back(1000 + 7 * i);
  const std::vector<double> sizes(ids.size(), 0.2);
  ASSERT_EQ(weft_part_create(in.mesh, ids.data(), nullptr, nullptr, &in.part), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_metric_from_sizes(points, sizes.data(), &in.metric), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_options_create(nullptr, &in.options), WEFT_OK);
  weft_options_set(in.options, "threads", "1");
  weft_options_set(in.options, "subdomains", "4");
}

/// What all ranks say, which must be the same.
std::string common(weft_status status, weft_status expected) {
  EXPECT_EQ(status, expected);
  const std::string mine = weft_last_error();
  std::array<char, 512> first{};
  mine.copy(first.data(), first.size() - 1);
  MPI_Bcast(first.data(), static_cast<int>(first.size()), MPI_CHAR, 0, MPI_COMM_WORLD);
  EXPECT_EQ(mine, first.data());
  return mine;
}

TEST(CParts, AdaptAndComeBackNumberedAndOwned) {
  const OnRank me;
  Input in;
  make(me, in);
  weft_result* result = nullptr;
  weft_part* part = nullptr;
  weft_mesh* mesh = nullptr;
  ASSERT_EQ(weft_adapt_parts(MPI_COMM_WORLD, in.part, in.metric, in.options, &result), WEFT_OK)
      << weft_last_error();
  weft_measures measures{};
  measures.size = sizeof measures;
  weft_result_measures(result, &measures);
  EXPECT_NEAR(measures.volume, 1, 1e-12);
  ASSERT_EQ(weft_result_part(result, &part), WEFT_OK);
  weft_free(result);
  ASSERT_EQ(weft_part_mesh(part, &mesh), WEFT_OK);
  int64_t points = 0, tets = 0, own_tets = 0, owned = 0, all = 0;
  const uint64_t* ids = nullptr;
  const int* owners = nullptr;
  weft_mesh_num_points(mesh, &points);
  weft_mesh_count(mesh, WEFT_TETS, &tets);
  ASSERT_EQ(weft_part_points(part, &ids, &owners), WEFT_OK);
  ASSERT_EQ(weft_part_ghosts(part, &own_tets, nullptr), WEFT_OK);
  EXPECT_EQ(own_tets, tets);
  EXPECT_GT(tets, 0);
  for (int64_t i = 0; i < points; ++i) owned += owners[i] == me.rank;
  MPI_Allreduce(&owned, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  EXPECT_EQ(all, measures.vertices);
  weft_free(mesh);
  weft_free(part);
}

/// Points and tets of a box, and sizes at the points; what one rank has of it, and the ids.
struct Box {
  std::vector<double> points, sizes;
  std::vector<int64_t> tets, ids, tet_ids;
};

Box whole_box(int64_t nx, int64_t ny, int64_t nz) {
  Box box;
  weft_mesh* mesh = nullptr;
  weft_mesh_box(nx, ny, nz, &mesh);
  int64_t points = 0, tets = 0;
  const double* x = nullptr;
  weft_mesh_num_points(mesh, &points);
  weft_mesh_points(mesh, &x);
  weft_mesh_count(mesh, WEFT_TETS, &tets);
  box.points.assign(x, x + 3 * points);
  box.tets.resize(static_cast<std::size_t>(4 * tets));
  weft_mesh_get(mesh, WEFT_TETS, 4 * tets, box.tets.data());
  weft_free(mesh);
  for (int64_t i = 0; i < points; ++i) {
    box.ids.push_back(i);
    box.sizes.push_back(0.1 + 0.1 * box.points[static_cast<std::size_t>(3 * i)]);
  }
  for (int64_t t = 0; t < tets; ++t) box.tet_ids.push_back(t);
  return box;
}

/// Every `ranks`-th block of 7 tets.
Box share_of(const Box& whole, int rank, int ranks) {
  Box share;
  std::vector<int64_t> local(whole.ids.size(), -1);
  for (std::size_t t = 0; t < whole.tet_ids.size(); ++t) {
    if (static_cast<int>(t / 7) % ranks != rank) continue;
    share.tet_ids.push_back(static_cast<int64_t>(t));
    for (std::size_t i = 4 * t; i < 4 * t + 4; ++i) {
      const auto v = static_cast<std::size_t>(whole.tets[i]);
      if (local[v] < 0) {
        local[v] = static_cast<int64_t>(share.ids.size());
        share.ids.push_back(whole.ids[v]);
        share.sizes.push_back(whole.sizes[v]);
        for (std::size_t axis = 0; axis < 3; ++axis) share.points.push_back(whole.points[3 * v + axis]);
      }
      share.tets.push_back(local[v]);
    }
  }
  return share;
}

weft_part* part_of(const Box& box) {
  weft_mesh* mesh = nullptr;
  weft_part* part = nullptr;
  EXPECT_EQ(weft_mesh_create(static_cast<int64_t>(box.ids.size()), box.points.data(),
                             static_cast<int64_t>(box.tet_ids.size()), box.tets.data(), &mesh),
            WEFT_OK)
      << weft_last_error();
  EXPECT_EQ(weft_part_create(mesh, box.ids.data(), box.tet_ids.data(), nullptr, &part), WEFT_OK)
      << weft_last_error();
  weft_free(mesh);
  return part;
}

/// The tets of a mesh by the coordinates of their points, in ascending order, on all ranks.
std::vector<std::array<double, 12>> shape_of(weft_mesh* mesh, MPI_Comm communicator) {
  int64_t tets = 0;
  const double* x = nullptr;
  weft_mesh_count(mesh, WEFT_TETS, &tets);
  weft_mesh_points(mesh, &x);
  std::vector<int64_t> corners(static_cast<std::size_t>(4 * tets));
  weft_mesh_get(mesh, WEFT_TETS, 4 * tets, corners.data());
  std::vector<std::array<double, 12>> mine;
  for (std::size_t t = 0; t < corners.size() / 4; ++t) {
    std::array<std::array<double, 3>, 4> points{};
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        points[i][axis] = x[3 * static_cast<std::size_t>(corners[4 * t + i]) + axis];
    std::sort(points.begin(), points.end());
    std::array<double, 12> flat{};
    for (std::size_t i = 0; i < 12; ++i) flat[i] = points[i / 3][i % 3];
    mine.push_back(flat);
  }
  int ranks = 1, count = static_cast<int>(12 * mine.size());
  MPI_Comm_size(communicator, &ranks);
  std::vector<int> counts(static_cast<std::size_t>(ranks)), starts(static_cast<std::size_t>(ranks));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, communicator);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<std::array<double, 12>> all(static_cast<std::size_t>(starts.back() + counts.back()) / 12);
  MPI_Allgatherv(mine.data(), count, MPI_DOUBLE, all.data(), counts.data(), starts.data(), MPI_DOUBLE,
                 communicator);
  std::sort(all.begin(), all.end());
  return all;
}

/// A box in parts, adapted to the sizes of another box in parts.
std::vector<std::array<double, 12>> adapt_to_background(MPI_Comm communicator, const Box& box,
                                                        const Box& background, weft_options* options) {
  weft_part *part = part_of(box), *other = part_of(background);
  weft_metric* metric = nullptr;
  weft_result* result = nullptr;
  weft_mesh* mesh = nullptr;
  weft_metric_from_sizes(static_cast<int64_t>(background.sizes.size()), background.sizes.data(), &metric);
  EXPECT_EQ(weft_adapt_parts_to_background(communicator, part, other, metric, options, &result), WEFT_OK)
      << weft_last_error();
  EXPECT_EQ(weft_result_mesh(result, &mesh), WEFT_OK);
  const auto shape = shape_of(mesh, communicator);
  for (void* handle : {static_cast<void*>(part), static_cast<void*>(other), static_cast<void*>(metric),
                       static_cast<void*>(result), static_cast<void*>(mesh)})
    weft_free(handle);
  return shape;
}

TEST(CParts, TheMetricOfAnotherMeshInPartsGivesTheMeshOfOneProcess) {
  const OnRank me;
  const Box box = whole_box(4, 4, 4), background = whole_box(6, 5, 6);
  weft_options* options = nullptr;
  weft_options_create(nullptr, &options);
  weft_options_set(options, "threads", "1");
  weft_options_set(options, "subdomains", "5");
  const auto shape = adapt_to_background(MPI_COMM_WORLD, share_of(box, me.rank, me.ranks),
                                         share_of(background, me.ranks - 1 - me.rank, me.ranks), options);
  EXPECT_GT(shape.size(), 1000u);
  EXPECT_EQ(shape, adapt_to_background(MPI_COMM_SELF, box, background, options));

  weft_mesh *mesh = nullptr, *other = nullptr, *fine = nullptr;
  weft_metric* metric = nullptr;
  weft_result* result = nullptr;
  const auto points = [](const Box& of) { return static_cast<int64_t>(of.ids.size()); };
  const auto tets = [](const Box& of) { return static_cast<int64_t>(of.tet_ids.size()); };
  weft_mesh_create(points(box), box.points.data(), tets(box), box.tets.data(), &mesh);
  weft_mesh_create(points(background), background.points.data(), tets(background), background.tets.data(),
                   &other);
  weft_metric_from_sizes(points(background), background.sizes.data(), &metric);
  ASSERT_EQ(weft_adapt_to_background(mesh, other, metric, options, nullptr, &result), WEFT_OK)
      << weft_last_error();
  weft_result_mesh(result, &fine);
  EXPECT_EQ(shape, shape_of(fine, MPI_COMM_SELF));
  for (void* handle : {static_cast<void*>(mesh), static_cast<void*>(other), static_cast<void*>(metric),
                       static_cast<void*>(result), static_cast<void*>(fine), static_cast<void*>(options)})
    weft_free(handle);
}

TEST(CParts, WhatIsWrongWithABackgroundOnOneRankAllHearOf) {
  const OnRank me;
  const bool last = me.rank == me.ranks - 1;
  const std::string rank = "rank " + std::to_string(me.ranks - 1) + ": ";
  const Box share = share_of(whole_box(4, 4, 4), me.rank, me.ranks);
  const auto points = static_cast<int64_t>(share.ids.size());
  const auto call = [&](const std::function<void(Box&, weft_part*&, bool&)>& spoil) {
    Input in;
    make(me, in);
    Box background = share;
    bool with_metric = true;
    weft_part *other = part_of(background), *given = other;
    if (last) spoil(background, given, with_metric);
    weft_metric* metric = nullptr;
    if (with_metric)
      weft_metric_from_sizes(static_cast<int64_t>(background.sizes.size()), background.sizes.data(), &metric);
    weft_result* result = nullptr;
    const weft_status status =
        weft_adapt_parts_to_background(MPI_COMM_WORLD, in.part, given, metric, in.options, &result);
    weft_free(other);
    weft_free(metric);
    return status;
  };
  int64_t of_last = points;
  MPI_Bcast(&of_last, 1, MPI_INT64_T, me.ranks - 1, MPI_COMM_WORLD);
  const std::string mesh = " vertices, the mesh " + std::to_string(of_last);
  EXPECT_EQ(common(call([](Box& box, weft_part*&, bool&) { box.sizes.push_back(1); }), WEFT_INPUT_ERROR),
            "background: " + rank + "metric of another mesh: it has " + std::to_string(of_last + 1) + mesh);
  EXPECT_EQ(common(call([](Box& box, weft_part*&, bool&) { box.sizes.pop_back(); }), WEFT_INPUT_ERROR),
            "background: " + rank + "metric of another mesh: it has " + std::to_string(of_last - 1) + mesh);
  EXPECT_EQ(common(call([](Box&, weft_part*& part, bool&) { part = nullptr; }), WEFT_MISUSE),
            rank + "background: is NULL, not a weft_part");
  EXPECT_EQ(common(call([](Box&, weft_part*&, bool& with_metric) { with_metric = false; }), WEFT_MISUSE),
            rank + "metric: is NULL, not a weft_metric");
}

TEST(CParts, SolutionsOfThePartsMakeTheMetric) {
  const OnRank me;
  Input in;
  make(me, in);
  int64_t points = 0;
  weft_mesh_num_points(in.mesh, &points);
  const double* x = nullptr;
  if (points > 0) {
    ASSERT_EQ(weft_mesh_points(in.mesh, &x), WEFT_OK);
  }
  std::vector<double> values;
  for (int64_t i = 0; i < points; ++i)
    values.push_back(x[3 * i] * x[3 * i] + 2 * x[3 * i + 1] * x[3 * i + 1] + 3 * x[3 * i + 2] * x[3 * i + 2]);
  weft_fields* solution = nullptr;
  weft_result* result = nullptr;
  ASSERT_EQ(weft_fields_create(points, &solution), WEFT_OK);
  ASSERT_EQ(weft_fields_add(solution, "u", 1, values.data()), WEFT_OK) << weft_last_error();
  weft_options_add_solution(in.options, solution);
  weft_options_set(in.options, "complexity", "300");
  ASSERT_EQ(weft_adapt_parts(MPI_COMM_WORLD, in.part, nullptr, in.options, &result), WEFT_OK)
      << weft_last_error();
  weft_measures measures{};
  measures.size = sizeof measures;
  weft_result_measures(result, &measures);
  EXPECT_NEAR(measures.volume, 1, 1e-12);
  EXPECT_NEAR(static_cast<double>(measures.vertices), 600, 250);
  weft_free(result);
  weft_free(solution);
}

TEST(CParts, WhatOneRankDoesWrongAllHearOf) {
  const OnRank me;
  const bool last = me.rank == me.ranks - 1;
  const std::string name = "rank " + std::to_string(me.ranks - 1) + ": ";
  const auto call = [&](const std::function<void(Arguments&, weft_result**&)>& spoil) {
    Input in;
    make(me, in);
    weft_result* result = nullptr;
    weft_result** place = &result;
    Arguments given{in.part, in.metric, in.options};
    if (last) spoil(given, place);
    return weft_adapt_parts(MPI_COMM_WORLD, given.part, given.metric, given.options, place);
  };
  EXPECT_EQ(common(call([](Arguments& in, weft_result**&) { in.part = nullptr; }), WEFT_MISUSE),
            name + "part: is NULL, not a weft_part");
  EXPECT_EQ(common(call([](Arguments& in, weft_result**&) { in.metric = nullptr; }), WEFT_MISUSE),
            name + "metric: is NULL, not a weft_metric");
  EXPECT_EQ(common(call([](Arguments&, weft_result**& place) { place = nullptr; }), WEFT_MISUSE),
            name + "result: is NULL, and the result has no place to go to");
  EXPECT_EQ(common(call([](Arguments& in, weft_result**&) { weft_options_set(in.options, "hgrad", "nan"); }),
                   WEFT_OPTION_ERROR),
            name + "--hgrad: is not a number");
}

TEST(CParts, ACommunicatorThatIsNoneIsRefused) {
  weft_result* result = nullptr;
  EXPECT_EQ(weft_adapt_parts(MPI_COMM_NULL, nullptr, nullptr, nullptr, &result), WEFT_MISUSE);
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  MPI_Init(&argc, &argv);
  const int mine = RUN_ALL_TESTS();
  int worst = 0;
  MPI_Allreduce(&mine, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return worst;
}
