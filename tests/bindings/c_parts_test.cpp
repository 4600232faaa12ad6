// Parts through the C interface: what one rank does wrong, all hear of. Under mpirun, with any number of
// ranks.
#include <gtest/gtest.h>
#include <weft/weft-c.h>

#include <array>
#include <functional>
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
