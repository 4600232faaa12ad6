// The C interface by programs' use and misuse. Programs see <weft/weft-c.h> and the shared library only.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <weft/weft-c.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/support/failing_new.h"

namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Frees what a test has made.
class Handles : public ::testing::Test {
 protected:
  ~Handles() override {
    for (void* handle : made_) weft_free(handle);
    EXPECT_EQ(weft_handles(), before_);
  }
  template <class Handle>
  Handle* keep(Handle* handle) {
    made_.push_back(handle);
    return handle;
  }
  weft_mesh* box(int64_t cells) {
    weft_mesh* mesh = nullptr;
    EXPECT_EQ(weft_mesh_box(cells, cells, cells, &mesh), WEFT_OK) << weft_last_error();
    return keep(mesh);
  }
  weft_metric* sizes(const weft_mesh* mesh, double h) {
    int64_t points = 0;
    weft_mesh_num_points(mesh, &points);
    const std::vector<double> all(static_cast<std::size_t>(points), h);
    weft_metric* metric = nullptr;
    EXPECT_EQ(weft_metric_from_sizes(points, all.data(), &metric), WEFT_OK) << weft_last_error();
    return keep(metric);
  }
  weft_options* options() {
    weft_options* made = nullptr;
    EXPECT_EQ(weft_options_create(nullptr, &made), WEFT_OK);
    EXPECT_EQ(weft_options_set(made, "threads", "1"), WEFT_OK);
    return keep(made);
  }

 private:
  int64_t before_ = weft_handles();
  std::vector<void*> made_;
};

using CInterface = Handles;

/// A folder of the test's own, which goes with it.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "weft-c-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

TEST_F(CInterface, AdaptsACallersArrays) {
  const weft_mesh* start = box(3);
  int64_t points = 0, tets = 0;
  weft_mesh_num_points(start, &points);
  weft_mesh_count(start, WEFT_TETS, &tets);
  const double* xyz = nullptr;
  weft_mesh_points(start, &xyz);
  std::vector<int64_t> corners(static_cast<std::size_t>(4 * tets));
  ASSERT_EQ(weft_mesh_get(start, WEFT_TETS, 4 * tets, corners.data()), WEFT_OK);
  weft_mesh* mesh = nullptr;
  ASSERT_EQ(weft_mesh_create(points, xyz, tets, corners.data(), &mesh), WEFT_OK) << weft_last_error();
  keep(mesh);
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.2), options(), nullptr, &result), WEFT_OK) << weft_last_error();
  keep(result);
  weft_mesh* fine = nullptr;
  ASSERT_EQ(weft_result_mesh(result, &fine), WEFT_OK);
  keep(fine);
  int64_t problems = -1;
  double volume = 0;
  ASSERT_EQ(weft_mesh_verify(fine, &problems, &volume), WEFT_OK);
  EXPECT_EQ(problems, 0);
  EXPECT_NEAR(volume, 1, 1e-12);
  weft_measures measures{};
  measures.size = sizeof measures;
  ASSERT_EQ(weft_result_measures(result, &measures), WEFT_OK);
  EXPECT_GT(measures.edges_unit, 0.85);
  int64_t fine_tets = 0;
  weft_mesh_count(fine, WEFT_TETS, &fine_tets);
  EXPECT_EQ(measures.tets, fine_tets);
  const char* json = nullptr;
  ASSERT_EQ(weft_result_json(result, &json), WEFT_OK);
  EXPECT_THAT(json, HasSubstr("weft-report-1"));
}

TEST_F(CInterface, WhatAResultHasOutlivesIt) {
  weft_mesh* mesh = box(2);
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.4), options(), nullptr, &result), WEFT_OK);
  weft_mesh* fine = nullptr;
  ASSERT_EQ(weft_result_mesh(result, &fine), WEFT_OK);
  keep(fine);
  weft_free(result);
  int64_t problems = -1;
  EXPECT_EQ(weft_mesh_verify(fine, &problems, nullptr), WEFT_OK);
  EXPECT_EQ(problems, 0);
}

TEST_F(CInterface, ChangingAMeshLeavesTheResultThatItIsOf) {
  weft_mesh* mesh = box(2);
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.4), options(), nullptr, &result), WEFT_OK);
  keep(result);
  weft_mesh *changed = nullptr, *kept = nullptr;
  weft_result_mesh(result, &changed);
  weft_result_mesh(result, &kept);
  keep(changed);
  keep(kept);
  ASSERT_EQ(weft_mesh_set(changed, WEFT_TETS, 0, nullptr), WEFT_OK);
  int64_t tets = 0;
  weft_mesh_count(kept, WEFT_TETS, &tets);
  EXPECT_GT(tets, 0);
}

TEST_F(CInterface, OrdersOfTensorsMeanTheSameMetric) {
  const std::array<double, 6> sol = {2, 0.1, 3, 0.2, 0.3, 4}, rows = {2, 0.1, 0.2, 3, 0.3, 4},
                              voigt = {2, 3, 4, 0.3, 0.2, 0.1};
  const std::array<std::pair<weft_tensor_order, const double*>, 3> all = {
      {{WEFT_ORDER_SOL, sol.data()}, {WEFT_ORDER_ROWS, rows.data()}, {WEFT_ORDER_VOIGT, voigt.data()}}};
  for (const auto& [order, values] : all) {
    weft_metric* metric = nullptr;
    ASSERT_EQ(weft_metric_from_tensors(1, values, order, &metric), WEFT_OK) << weft_last_error();
    keep(metric);
    for (const auto& [other, expected] : all) {
      std::array<double, 6> back{};
      ASSERT_EQ(weft_metric_get(metric, other, 6, back.data()), WEFT_OK);
      for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(back[i], expected[i], 1e-12);
    }
  }
}

TEST_F(CInterface, SettingsAndNamesSetTheSameOptions) {
  weft_settings settings{};
  settings.size = sizeof settings;
  ASSERT_EQ(weft_settings_default(&settings), WEFT_OK);
  EXPECT_EQ(settings.ridge_angle, 45);
  settings.hmin = 2;
  settings.hmax = 1;
  weft_options* made = nullptr;
  EXPECT_EQ(weft_options_create(&settings, &made), WEFT_OPTION_ERROR);
  EXPECT_STREQ(weft_last_error(), "--hmin: is larger than --hmax");
  weft_options* named = options();
  weft_options_set(named, "hmin", "2");
  weft_options_set_number(named, "hmax", 1);
  weft_mesh* mesh = box(1);
  weft_result* result = nullptr;
  EXPECT_EQ(weft_adapt(mesh, sizes(mesh, 1), named, nullptr, &result), WEFT_OPTION_ERROR);
  EXPECT_STREQ(weft_last_error(), "--hmin: is larger than --hmax");
}

TEST_F(CInterface, AnOlderProgramsShorterSettingsAreEnough) {
  struct Old {
    std::size_t size;
    double complexity, hmin;
  } old{sizeof(Old), 500, 0};
  weft_options* made = nullptr;
  ASSERT_EQ(weft_options_create(reinterpret_cast<const weft_settings*>(&old), &made), WEFT_OK)
      << weft_last_error();
  keep(made);
  weft_mesh* mesh = box(3);
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 1), made, nullptr, &result), WEFT_OK) << weft_last_error();
  keep(result);
  weft_measures measures{};
  measures.size = offsetof(weft_measures, quality_mean);
  measures.quality_mean = -7;  // beyond what the size allows to write
  ASSERT_EQ(weft_result_measures(result, &measures), WEFT_OK);
  EXPECT_NEAR(measures.complexity, 500, 60);
  EXPECT_EQ(measures.quality_mean, -7);
}

TEST_F(CInterface, EveryOptionHasANameATypeAndAText) {
  int64_t count = 0;
  const char *type = nullptr, *text = nullptr;
  for (; const char* name = weft_option_name(count, &type, &text); ++count) {
    EXPECT_GT(std::strlen(name), 2u);
    EXPECT_GT(std::strlen(type), 3u);
    EXPECT_GT(std::strlen(text), 5u);
    weft_options* some = options();
    EXPECT_NE(weft_options_set(some, (std::string(name) + "x").c_str(), "1"), WEFT_OK) << name;
  }
  EXPECT_GT(count, 30);
  EXPECT_EQ(weft_option_name(-1, nullptr, nullptr), nullptr);
}

TEST_F(CInterface, MisuseIsNamed) {
  weft_mesh* mesh = box(1);
  weft_metric* metric = sizes(mesh, 1);
  weft_result* result = nullptr;
  const auto misused = [](weft_status status, const std::string& text) {
    EXPECT_EQ(status, WEFT_MISUSE);
    EXPECT_THAT(weft_last_error(), HasSubstr(text));
  };
  misused(weft_adapt(nullptr, metric, nullptr, nullptr, &result), "mesh: is NULL");
  misused(weft_adapt(mesh, metric, nullptr, nullptr, nullptr), "result: is NULL");
  misused(weft_adapt(reinterpret_cast<weft_mesh*>(metric), metric, nullptr, nullptr, &result),
          "mesh: is a weft_metric, not a weft_mesh");
  weft_mesh* gone = nullptr;
  weft_mesh_box(1, 1, 1, &gone);
  weft_free(gone);
  misused(weft_adapt(gone, metric, nullptr, nullptr, &result), "has been freed");
  misused(weft_free(gone), "has been freed");
  misused(weft_mesh_create(-1, nullptr, 0, nullptr, &gone), "points: -1 rows");
  misused(weft_mesh_create(4, nullptr, 0, nullptr, &gone), "points: is NULL");
  misused(weft_mesh_create(INT64_MAX, &kNaN, 0, nullptr, &gone), "more than memory can have");
  int64_t few[3];
  misused(weft_mesh_get(mesh, WEFT_TETS, 3, few), "24 are needed");
  misused(weft_mesh_set(mesh, static_cast<weft_array>(77), 0, nullptr), "none of weft_array");
  EXPECT_EQ(weft_free(nullptr), WEFT_OK);
}

TEST_F(CInterface, InterfacesOfOtherLanguagesRefuseInTheirOwnWords) {
  EXPECT_EQ(weft_refuse("points: has 2 rows, not (3, n)"), WEFT_MISUSE);
  EXPECT_STREQ(weft_last_error(), "points: has 2 rows, not (3, n)");
  EXPECT_EQ(weft_refuse(nullptr), WEFT_MISUSE);
  EXPECT_STREQ(weft_last_error(), "why: is NULL, not a text");
}

TEST_F(CInterface, BadDataAreNamedByArrayAndIndex) {
  const std::vector<double> points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, kNaN};
  const std::vector<int64_t> tets = {0, 1, 2, 3}, wrong = {0, 1, 2, 4}, negative = {0, -1, 2, 3};
  weft_mesh* mesh = nullptr;
  const auto refused = [](weft_status status, const std::string& text) {
    EXPECT_EQ(status, WEFT_INPUT_ERROR);
    EXPECT_THAT(weft_last_error(), HasSubstr(text));
  };
  refused(weft_mesh_create(4, points.data(), 1, tets.data(), &mesh), "points[3]: is not finite");
  refused(weft_mesh_create(3, points.data(), 1, wrong.data(), &mesh), "tets[0]: 4 is not from 0 to 2");
  refused(weft_mesh_create(3, points.data(), 1, negative.data(), &mesh), "tets[0]: -1 is not from 0 to 2");
  const double bad[] = {1, -1};
  weft_metric* metric = nullptr;
  refused(weft_metric_from_sizes(2, bad, &metric), "vertex 2");
  refused(weft_metric_from_sizes(1, &kNaN, &metric), "vertex 1");
  refused(weft_mesh_read("no such file.meshb", &mesh), "no such file.meshb");
  EXPECT_EQ(weft_options_set(options(), "hmim", "1"), WEFT_OPTION_ERROR);
  EXPECT_THAT(weft_last_error(), StartsWith("--hmim: "));
  EXPECT_EQ(weft_options_set(options(), "hmin", "small"), WEFT_OPTION_ERROR);
  EXPECT_THAT(weft_last_error(), HasSubstr("'small' is not a number"));
}

int stop_at_once(void* calls, const weft_progress* now) {
  ++*static_cast<int*>(calls);
  EXPECT_NE(now->stage, nullptr);
  return 0;
}

TEST_F(CInterface, ACallbackCancelsWithAValidMeshAndTheOptionsServeAgain) {
  weft_mesh* mesh = box(3);
  weft_options* asked = options();
  int calls = 0;
  weft_options_set_progress(asked, stop_at_once, &calls);
  for (const int expected : {1, 0}) {
    weft_result* result = nullptr;
    ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.2), asked, nullptr, &result), WEFT_OK) << weft_last_error();
    keep(result);
    int cancelled = -1;
    weft_result_verdict(result, nullptr, &cancelled);
    EXPECT_EQ(cancelled, expected);
    weft_mesh* fine = nullptr;
    weft_result_mesh(result, &fine);
    int64_t problems = -1;
    weft_mesh_verify(keep(fine), &problems, nullptr);
    EXPECT_EQ(problems, 0);
    weft_options_set_progress(asked, nullptr, nullptr);
  }
  EXPECT_GT(calls, 0);
}

TEST_F(CInterface, ALimitEndsItsRunAndNotTheNextOneWithTheSameOptions) {
  weft_mesh* mesh = box(6);
  weft_options* asked = options();
  for (const auto& [limit, size, expected] : {std::tuple("0.01", 0.03, 1), std::tuple("0", 0.3, 0)}) {
    weft_options_set(asked, "time-limit", limit);
    weft_result* result = nullptr;
    ASSERT_EQ(weft_adapt(mesh, sizes(mesh, size), asked, nullptr, &result), WEFT_OK) << weft_last_error();
    int cancelled = -1;
    weft_result_verdict(keep(result), nullptr, &cancelled);
    EXPECT_EQ(cancelled, expected);
  }
}

TEST_F(CInterface, MeasuresAreTakenWhenTheyAreAskedFor) {
  weft_mesh* mesh = box(3);
  weft_options* asked = options();
  weft_options_set(asked, "measure", "no");
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.2), asked, nullptr, &result), WEFT_OK) << weft_last_error();
  keep(result);
  int goal_met = -1;
  ASSERT_EQ(weft_result_verdict(result, &goal_met, nullptr), WEFT_OK);
  EXPECT_EQ(goal_met, 1);
  weft_measures measures{};
  measures.size = sizeof measures;
  ASSERT_EQ(weft_result_measures(result, &measures), WEFT_OK) << weft_last_error();
  EXPECT_NEAR(measures.volume, 1, 1e-12);
  EXPECT_GT(measures.edges_unit, 0.5);
}

TEST_F(CInterface, FilesThatWereNotMeasuredHaveNoMeasures) {
  const Folder folder;
  const std::string start = folder / "start.meshb", fine = folder / "fine.meshb";
  ASSERT_EQ(weft_mesh_write(box(3), start.c_str()), WEFT_OK);
  weft_options* asked = options();
  weft_options_set(asked, "measure", "no");
  weft_options_set(asked, "metric-fn", "uniform:0.3");
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt_files(start.c_str(), fine.c_str(), asked, &result), WEFT_OK) << weft_last_error();
  weft_measures measures{};
  measures.size = sizeof measures;
  EXPECT_EQ(weft_result_measures(keep(result), &measures), WEFT_MISUSE);
  EXPECT_THAT(weft_last_error(), HasSubstr("result: has no measures"));
  int goal_met = -1;
  ASSERT_EQ(weft_result_verdict(result, &goal_met, nullptr), WEFT_OK);
  EXPECT_EQ(goal_met, 0);
}

TEST_F(CInterface, AnotherThreadCancels) {
  weft_mesh* mesh = box(4);
  weft_options* asked = options();
  ASSERT_EQ(weft_options_cancel(asked, 1), WEFT_OK);
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.05), asked, nullptr, &result), WEFT_OK);
  keep(result);
  int cancelled = 0;
  weft_result_verdict(result, nullptr, &cancelled);
  EXPECT_EQ(cancelled, 1);
  weft_measures measures{};
  measures.size = sizeof measures;
  ASSERT_EQ(weft_result_measures(result, &measures), WEFT_OK) << weft_last_error();
  EXPECT_NEAR(measures.volume, 1, 1e-12);
  const char* text = nullptr;
  ASSERT_EQ(weft_result_json(result, &text), WEFT_OK);
  EXPECT_THAT(text, HasSubstr("of the edges are unit"));
}

TEST_F(CInterface, AnotherThreadAsksForACheckpoint) {
  const Folder folder;
  const std::string states = folder / "states";
  weft_options* asked = options();
  weft_options_set(asked, "checkpoint", states.c_str());
  weft_options_set(asked, "checkpoint-every", "0");
  ASSERT_EQ(weft_options_checkpoint(asked), WEFT_OK);
  weft_mesh* mesh = box(4);
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.1), asked, nullptr, &result), WEFT_OK) << weft_last_error();
  keep(result);
  EXPECT_FALSE(std::filesystem::is_empty(states));
  EXPECT_EQ(weft_options_checkpoint(nullptr), WEFT_MISUSE);
}

TEST_F(CInterface, TheLastErrorIsThatOfTheThread) {
  weft_mesh* mesh = nullptr;
  weft_mesh_box(0, 1, 1, &mesh);
  const std::string mine = weft_last_error();
  std::string others;
  std::thread([&] {
    others = weft_last_error();
    weft_metric_count(nullptr, nullptr);
  }).join();
  EXPECT_EQ(others, "");
  EXPECT_EQ(mine, weft_last_error());
}

TEST_F(CInterface, CarriesFieldsAlong) {
  weft_mesh* mesh = box(3);
  int64_t points = 0;
  const double* xyz = nullptr;
  weft_mesh_num_points(mesh, &points);
  weft_mesh_points(mesh, &xyz);
  weft_fields* fields = nullptr;
  ASSERT_EQ(weft_fields_create(points, &fields), WEFT_OK);
  keep(fields);
  ASSERT_EQ(weft_fields_add(fields, "place", 3, xyz), WEFT_OK) << weft_last_error();
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt(mesh, sizes(mesh, 0.25), options(), fields, &result), WEFT_OK) << weft_last_error();
  keep(result);
  weft_fields* carried = nullptr;
  weft_mesh* fine = nullptr;
  weft_result_fields(result, &carried);
  weft_result_mesh(result, &fine);
  keep(carried);
  keep(fine);
  const char* name = nullptr;
  int components = 0;
  const double *values = nullptr, *places = nullptr;
  ASSERT_EQ(weft_fields_get(carried, 0, &name, &components, &values), WEFT_OK);
  EXPECT_STREQ(name, "place");
  EXPECT_EQ(components, 3);
  weft_mesh_num_points(fine, &points);
  weft_mesh_points(fine, &places);
  for (int64_t i = 0; i < 3 * points; ++i) EXPECT_NEAR(values[i], places[i], 1e-12);
}

TEST_F(CInterface, AdaptsToTheMetricOfAnotherMesh) {
  weft_mesh *mesh = box(3), *other = box(5), *fine = nullptr;
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt_to_background(mesh, other, sizes(other, 0.2), options(), nullptr, &result), WEFT_OK)
      << weft_last_error();
  keep(result);
  weft_measures measures{};
  measures.size = sizeof measures;
  weft_result_measures(result, &measures);
  EXPECT_GT(measures.edges_unit, 0.85);
  weft_result_mesh(result, &fine);
  keep(fine);
  int64_t differences = -1;
  ASSERT_EQ(weft_mesh_compare(fine, mesh, &differences), WEFT_OK);
  EXPECT_EQ(differences, 0);
  EXPECT_EQ(weft_adapt_to_background(mesh, other, sizes(mesh, 0.2), options(), nullptr, &result),
            WEFT_INPUT_ERROR);
  EXPECT_THAT(weft_last_error(), HasSubstr("metric of another mesh: it has 64 vertices, the mesh 216"));
  EXPECT_EQ(weft_adapt_to_background(mesh, nullptr, sizes(mesh, 0.2), options(), nullptr, &result),
            WEFT_MISUSE);
  EXPECT_THAT(weft_last_error(), StartsWith("background: is NULL"));
}

TEST_F(CInterface, SolutionsOfAnotherMeshMakeTheMetric) {
  weft_mesh *mesh = box(3), *other = box(6);
  int64_t points = 0;
  const double* x = nullptr;
  weft_mesh_num_points(other, &points);
  weft_mesh_points(other, &x);
  std::vector<double> values;
  for (int64_t i = 0; i < points; ++i) values.push_back(std::tanh(10 * (x[3 * i] - 0.4)));
  weft_fields* solution = nullptr;
  weft_fields_create(points, &solution);
  keep(solution);
  ASSERT_EQ(weft_fields_add(solution, "u", 1, values.data()), WEFT_OK);
  weft_options* asked = options();
  weft_options_add_solution(asked, solution);
  weft_options_set(asked, "complexity", "300");
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt_to_background(mesh, other, nullptr, asked, nullptr, &result), WEFT_OK)
      << weft_last_error();
  keep(result);
  weft_measures measures{};
  measures.size = sizeof measures;
  weft_result_measures(result, &measures);
  EXPECT_NEAR(static_cast<double>(measures.vertices), 600, 250);
}

TEST_F(CInterface, ComparesMeshesOfTheSameDomain) {
  weft_mesh* mesh = box(2);
  weft_mesh* other = nullptr;
  const int64_t cells[] = {2, 2, 2};
  const double min[] = {0, 0, 0}, max[] = {1, 1, 2}, wrong[] = {1, 0, 1};
  ASSERT_EQ(weft_mesh_box_between(cells, min, max, &other), WEFT_OK) << weft_last_error();
  keep(other);
  int64_t differences = -1;
  ASSERT_EQ(weft_mesh_compare(mesh, other, &differences), WEFT_OK);
  EXPECT_EQ(differences, 5);  // the volume, and the four sides that are taller
  EXPECT_THAT(weft_last_error(), HasSubstr("volume of reference 1 is 1, the other mesh's 2"));
  EXPECT_EQ(weft_mesh_box_between(cells, min, wrong, &other), WEFT_MISUSE);
  EXPECT_THAT(weft_last_error(), HasSubstr("max: must be above min"));
  EXPECT_EQ(weft_mesh_box_between(cells, min, nullptr, &other), WEFT_MISUSE);
}

TEST_F(CInterface, RepairsWhatAdaptRefuses) {
  const std::vector<double> points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 5, 5};
  const std::vector<int64_t> inverted = {1, 0, 2, 3};
  weft_mesh* mesh = nullptr;
  ASSERT_EQ(weft_mesh_create(5, points.data(), 1, inverted.data(), &mesh), WEFT_OK);
  keep(mesh);
  weft_fields* fields = nullptr;
  weft_fields_create(5, &fields);
  keep(fields);
  const std::vector<double> numbers = {0, 1, 2, 3, 4};
  ASSERT_EQ(weft_fields_add(fields, "number", 1, numbers.data()), WEFT_OK);
  weft_text* mends = nullptr;
  ASSERT_EQ(weft_mesh_repair(mesh, fields, &mends), WEFT_OK) << weft_last_error();
  keep(mends);
  const char* text = nullptr;
  weft_text_get(mends, &text);
  EXPECT_THAT(text, HasSubstr("1 unused vertices removed (vertex 5)"));
  int64_t problems = -1, left = 0, num_fields = 0;
  weft_mesh_verify(mesh, &problems, nullptr);
  EXPECT_EQ(problems, 0) << weft_last_error();
  weft_fields_count(fields, &num_fields, &left);
  EXPECT_EQ(left, 4);
  EXPECT_EQ(weft_mesh_repair(mesh, fields, nullptr), WEFT_OK);  // nothing to do, nobody to tell
  EXPECT_EQ(weft_mesh_repair(nullptr, nullptr, nullptr), WEFT_MISUSE);
  EXPECT_EQ(weft_mesh_repair(mesh, nullptr, &mends), WEFT_OK);
  keep(mends);
}

TEST_F(CInterface, RepairsAMetricAndASurface) {
  weft_mesh* mesh = box(2);
  std::vector<double> sizes(27, 0.3);
  sizes[4] = -1;
  weft_fields* metric = nullptr;
  weft_fields_create(27, &metric);
  keep(metric);
  ASSERT_EQ(weft_fields_add(metric, "sizes", 1, sizes.data()), WEFT_OK) << weft_last_error();
  weft_text* mends = nullptr;
  ASSERT_EQ(weft_fields_repair_metric(metric, mesh, &mends), WEFT_OK) << weft_last_error();
  keep(mends);
  const double* values = nullptr;
  const char* name = nullptr;
  int components = 0;
  weft_fields_get(metric, 0, &name, &components, &values);
  EXPECT_NEAR(values[4], 0.3, 1e-12);

  weft_mesh* ball = nullptr;
  const double center[] = {0, 0, 0};
  ASSERT_EQ(weft_ball_surface(1, center, 0.5, &ball), WEFT_OK);
  keep(ball);
  int64_t count = 0;
  weft_mesh_count(ball, WEFT_TRIANGLES, &count);
  std::vector<int64_t> triangles(static_cast<std::size_t>(3 * count));
  weft_mesh_get(ball, WEFT_TRIANGLES, 3 * count, triangles.data());
  triangles.insert(triangles.end(), triangles.begin(), triangles.begin() + 3);  // one twice
  weft_mesh_set(ball, WEFT_TRIANGLE_REFS, 0, nullptr);
  ASSERT_EQ(weft_mesh_set(ball, WEFT_TRIANGLES, count + 1, triangles.data()), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_surface_repair(ball, nullptr), WEFT_OK) << weft_last_error();
  int64_t left = 0;
  weft_mesh_count(ball, WEFT_TRIANGLES, &left);
  EXPECT_EQ(left, count);
}

TEST_F(CInterface, StatTellsAllThatTheCommandTells) {
  weft_mesh* mesh = box(2);
  weft_text* text = nullptr;
  const char* letters = nullptr;
  ASSERT_EQ(weft_stat(mesh, sizes(mesh, 0.5), nullptr, &text), WEFT_OK) << weft_last_error();
  keep(text);
  ASSERT_EQ(weft_text_get(text, &letters), WEFT_OK);
  for (const char* part :
       {"weft-stat-1", "\"vertices\": 27", "volume_by_ref", "bounding_box", "histogram_log"})
    EXPECT_THAT(letters, HasSubstr(part));
  weft_text* plain = nullptr;
  ASSERT_EQ(weft_stat(mesh, nullptr, nullptr, &plain), WEFT_OK);
  weft_text_get(keep(plain), &letters);
  EXPECT_THAT(letters, ::testing::Not(HasSubstr("measures")));
  weft_options* asked = options();
  weft_options_set(asked, "geometry", "no such model.step");
  EXPECT_EQ(weft_stat(mesh, nullptr, asked, &plain), WEFT_INPUT_ERROR);
  EXPECT_THAT(weft_last_error(), HasSubstr("no such model.step"));
}

TEST_F(CInterface, FilesAreAdaptedWithAllThatTheCommandIsTold) {
  const Folder folder;
  const std::string start = folder / "start.meshb", other = folder / "other.meshb", h = folder / "h.solb",
                    field = folder / "f.solb", out = folder / "out.meshb", report = folder / "run",
                    graph = folder / "graph.dot", trace = folder / "trace.json";
  weft_mesh *mesh = box(3), *background = box(4);
  ASSERT_EQ(weft_mesh_write(mesh, start.c_str()), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_mesh_write(background, other.c_str()), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_metric_write(sizes(background, 0.2), h.c_str()), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_metric_write(sizes(mesh, 0.3), field.c_str()), WEFT_OK) << weft_last_error();
  weft_options* asked = options();
  weft_options_set(asked, "metric", h.c_str());
  weft_options_set(asked, "subdomains", "3");
  const char* fields[] = {field.c_str()};
  weft_file_settings settings{};
  settings.size = sizeof settings;
  ASSERT_EQ(weft_file_settings_default(&settings), WEFT_OK);
  settings.background = other.c_str();
  settings.fields = fields;
  settings.num_fields = 1;
  settings.report = report.c_str();
  settings.page = 0;
  settings.graph = graph.c_str();
  settings.trace = trace.c_str();
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt_files_with(start.c_str(), out.c_str(), &settings, asked, &result), WEFT_OK)
      << weft_last_error();
  keep(result);
  for (const std::string& file : {out, graph, trace, report + "/report.json", folder / "out-fields.solb"})
    EXPECT_TRUE(std::filesystem::exists(file)) << file;
  EXPECT_FALSE(std::filesystem::exists(report + "/report.html"));
  const char *written = nullptr, *error = nullptr;
  ASSERT_EQ(weft_result_report(result, &written, &error), WEFT_OK) << weft_last_error();
  EXPECT_EQ(written, report + "/report.json");
  EXPECT_STREQ(error, "");
  settings = {};
  settings.size = sizeof settings;
  weft_file_settings_default(&settings);
  settings.background = other.c_str();
  settings.simulate_ranks = 2;
  settings.simulate_cores = 1;
  const std::string simulated = folder / "simulated.meshb";
  ASSERT_EQ(weft_adapt_files_with(start.c_str(), simulated.c_str(), &settings, asked, &result), WEFT_OK)
      << weft_last_error();
  keep(result);
  const char* summary = nullptr;
  weft_result_summary(result, &summary);
  EXPECT_THAT(summary, HasSubstr("simulated"));
  EXPECT_EQ(std::filesystem::file_size(out), std::filesystem::file_size(simulated));
  settings.simulate_cores = -1;
  EXPECT_EQ(weft_adapt_files_with(start.c_str(), simulated.c_str(), &settings, asked, &result),
            WEFT_OPTION_ERROR);
  EXPECT_THAT(weft_last_error(), HasSubstr("--simulate-cores"));
  settings.simulate_cores = 1;
  settings.num_fields = 2;
  settings.fields = nullptr;
  EXPECT_EQ(weft_adapt_files_with(start.c_str(), out.c_str(), &settings, asked, &result), WEFT_MISUSE);
  EXPECT_THAT(weft_last_error(), HasSubstr("fields: is NULL"));
}

TEST_F(CInterface, AReportThatCouldNotBeWrittenIsTold) {
  const Folder folder;
  const std::string start = folder / "start.meshb", out = folder / "out.meshb";
  std::string report = folder / "run";
  ASSERT_EQ(weft_mesh_write(box(3), start.c_str()), WEFT_OK);
  weft_options* asked = options();
  weft_options_set(asked, "metric-fn", "uniform:0.3");
  const auto remove = [](void* path, const weft_progress*) {
    std::filesystem::remove_all(*static_cast<std::string*>(path));
    return 1;
  };
  weft_options_set_progress(asked, remove, &report);
  weft_file_settings settings{};
  settings.size = sizeof settings;
  weft_file_settings_default(&settings);
  settings.report = report.c_str();
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt_files_with(start.c_str(), out.c_str(), &settings, asked, &result), WEFT_OK)
      << weft_last_error();
  const char *written = nullptr, *error = nullptr;
  ASSERT_EQ(weft_result_report(keep(result), &written, &error), WEFT_OK) << weft_last_error();
  EXPECT_STREQ(written, "");
  EXPECT_THAT(error, HasSubstr("report.json"));
}

TEST_F(CInterface, RecordedRunsAreReplayedDrawnAndCompared) {
  const Folder folder;
  const std::string start = folder / "start.meshb", out = folder / "out.meshb", report = folder / "run",
                    graph = report + "/graph.json", profile = report + "/profile.json",
                    account = folder / "replay.json", page = folder / "page.html";
  ASSERT_EQ(weft_mesh_write(box(3), start.c_str()), WEFT_OK);
  weft_options* asked = options();
  weft_options_set(asked, "metric-fn", "uniform:0.3");
  weft_options_set(asked, "subdomains", "2");
  weft_file_settings files{};
  files.size = sizeof files;
  weft_file_settings_default(&files);
  files.report = report.c_str();
  weft_result* result = nullptr;
  ASSERT_EQ(weft_adapt_files_with(start.c_str(), out.c_str(), &files, asked, &result), WEFT_OK)
      << weft_last_error();
  keep(result);
  const auto letters = [&](weft_text* text) {
    const char* all = nullptr;
    weft_text_get(keep(text), &all);
    return std::string(all);
  };

  weft_replay_settings settings{};
  settings.size = sizeof settings;
  ASSERT_EQ(weft_replay_settings_default(&settings), WEFT_OK);
  settings.ranks = 3;
  settings.balancer = "none";
  settings.account = account.c_str();
  weft_text *summary = nullptr, *json = nullptr;
  ASSERT_EQ(weft_replay(graph.c_str(), &settings, &summary, &json), WEFT_OK) << weft_last_error();
  EXPECT_THAT(letters(summary), HasSubstr("3 ranks"));
  std::ostringstream written;
  written << std::ifstream(account).rdbuf();
  EXPECT_EQ(letters(json), written.str());
  EXPECT_THAT(written.str(), HasSubstr("\"balancer\": \"none\""));
  EXPECT_EQ(weft_replay(graph.c_str(), nullptr, nullptr, nullptr), WEFT_OK) << weft_last_error();
  settings.ranks = 0;
  EXPECT_EQ(weft_replay(graph.c_str(), &settings, nullptr, nullptr), WEFT_OPTION_ERROR);
  settings.ranks = 1;
  settings.subdomain_bytes = -1;
  EXPECT_EQ(weft_replay(graph.c_str(), &settings, nullptr, nullptr), WEFT_MISUSE);
  EXPECT_EQ(weft_replay(out.c_str(), nullptr, nullptr, nullptr), WEFT_INPUT_ERROR);

  weft_graph_filter filter{};
  filter.size = sizeof filter;
  ASSERT_EQ(weft_graph_filter_default(&filter), WEFT_OK);
  weft_text *whole = nullptr, *part = nullptr;
  ASSERT_EQ(weft_graph_text(graph.c_str(), "dot", nullptr, &whole), WEFT_OK) << weft_last_error();
  filter.subdomain = 1;
  ASSERT_EQ(weft_graph_text(graph.c_str(), "dot", &filter, &part), WEFT_OK) << weft_last_error();
  const std::string all = letters(whole);
  EXPECT_THAT(all, StartsWith("digraph"));
  EXPECT_LT(letters(part).size(), all.size());
  filter.subdomain = -2;
  EXPECT_EQ(weft_graph_text(graph.c_str(), "dot", &filter, &part), WEFT_MISUSE);

  ASSERT_EQ(weft_report_page(profile.c_str(), page.c_str()), WEFT_OK) << weft_last_error();
  EXPECT_EQ(std::filesystem::file_size(page), std::filesystem::file_size(report + "/report.html"));
  weft_text* differences = nullptr;
  ASSERT_EQ(weft_compare_reports(profile.c_str(), profile.c_str(), nullptr, &differences), WEFT_OK)
      << weft_last_error();
  EXPECT_THAT(letters(differences), HasSubstr("as fast as"));
  EXPECT_EQ(weft_report_page(profile.c_str(), profile.c_str()), WEFT_OPTION_ERROR);
}

TEST_F(CInterface, FilesAreConverted) {
  const Folder folder;
  const std::string start = folder / "start.meshb", out = folder / "out.msh", stl = folder / "out.stl",
                    h = folder / "h.solb";
  weft_mesh* mesh = box(2);
  ASSERT_EQ(weft_mesh_write(mesh, start.c_str()), WEFT_OK);
  ASSERT_EQ(weft_metric_write(sizes(mesh, 0.3), h.c_str()), WEFT_OK);
  weft_write_settings settings{};
  settings.size = sizeof settings;
  ASSERT_EQ(weft_write_settings_default(&settings), WEFT_OK);
  settings.encoding = "ascii";
  settings.msh_version = 2;
  ASSERT_EQ(weft_convert(start.c_str(), out.c_str(), h.c_str(), &settings, nullptr), WEFT_OK)
      << weft_last_error();
  std::ifstream file(out);
  std::string line;
  std::getline(file, line);
  std::getline(file, line);
  EXPECT_EQ(line, "2.2 0 8");
  weft_text* dropped = nullptr;
  ASSERT_EQ(weft_convert(start.c_str(), stl.c_str(), nullptr, nullptr, &dropped), WEFT_OK);
  const char* letters = nullptr;
  weft_text_get(keep(dropped), &letters);
  EXPECT_THAT(letters, HasSubstr("tets"));
  settings.encoding = "utf";
  EXPECT_EQ(weft_convert(start.c_str(), out.c_str(), nullptr, &settings, nullptr), WEFT_OPTION_ERROR);
  EXPECT_THAT(weft_last_error(), StartsWith("--encoding: 'utf'"));
  settings.encoding = nullptr;
  EXPECT_EQ(weft_convert(start.c_str(), out.c_str(), nullptr, &settings, nullptr), WEFT_MISUSE);
}

TEST_F(CInterface, HistogramsAreDrawn) {
  const Folder folder;
  weft_mesh* mesh = box(2);
  ASSERT_EQ(weft_draw_histograms((folder / "plot.svg").c_str(), mesh, sizes(mesh, 0.5)), WEFT_OK)
      << weft_last_error();
  EXPECT_GT(std::filesystem::file_size(folder / "plot.svg"), 2000u);
}

TEST_F(CInterface, MeshesAreDrawn) {
  const Folder folder;
  const std::string path = folder / "mesh.svg", png = folder / "mesh.png";
  weft_mesh* mesh = box(2);
  ASSERT_EQ(weft_draw(path.c_str(), mesh, nullptr, nullptr, 0, nullptr), WEFT_OK) << weft_last_error();
  const auto whole = std::filesystem::file_size(path);
  EXPECT_GT(whole, 2000u);
  weft_picture_settings settings{};
  EXPECT_EQ(weft_picture_settings_default(&settings), WEFT_MISUSE);
  settings.size = sizeof settings;
  ASSERT_EQ(weft_picture_settings_default(&settings), WEFT_OK);
  EXPECT_STREQ(settings.color_by, "none");
  settings.clip = "x=0.5";
  settings.title = "cut in the middle";
  const std::vector<double> field(27, 1.5);
  ASSERT_EQ(weft_draw(path.c_str(), mesh, nullptr, field.data(), 27, &settings), WEFT_OK)
      << weft_last_error();
  EXPECT_NE(std::filesystem::file_size(path), whole);
  settings.color_by = "quality";
  settings.pixels = "300x200";
  ASSERT_EQ(weft_draw(png.c_str(), mesh, sizes(mesh, 0.5), nullptr, 0, &settings), WEFT_OK)
      << weft_last_error();
  EXPECT_GT(std::filesystem::file_size(png), 1000u);

  const auto refused = [&](weft_status status, const char* with) {
    EXPECT_EQ(weft_draw(path.c_str(), mesh, nullptr, nullptr, 0, &settings), status);
    EXPECT_THAT(weft_last_error(), HasSubstr(with));
  };
  settings.color_by = "length";
  refused(WEFT_OPTION_ERROR, "needs a metric");
  settings.color_by = "mood";
  refused(WEFT_OPTION_ERROR, "'mood'");
  weft_picture_settings_default(&settings);
  settings.zoom = 0;
  refused(WEFT_OPTION_ERROR, "--zoom");
  EXPECT_EQ(weft_draw(path.c_str(), mesh, nullptr, field.data(), 26, nullptr), WEFT_INPUT_ERROR);
  EXPECT_EQ(weft_draw("mesh.gif", mesh, nullptr, nullptr, 0, nullptr), WEFT_MISUSE);
  EXPECT_EQ(weft_draw(nullptr, mesh, nullptr, nullptr, 0, nullptr), WEFT_MISUSE);
}

TEST_F(CInterface, SurfacesOfBodiesAreFilledToo) {
  const double origin[] = {0, 0, 0};
  weft_mesh *ball = nullptr, *cylinder = nullptr, *wing = nullptr, *filled = nullptr, *finer = nullptr;
  ASSERT_EQ(weft_ball_surface(1, origin, 0.5, &ball), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_cylinder_surface(1, 2, origin, 0.5, &cylinder), WEFT_OK) << weft_last_error();
  ASSERT_EQ(weft_delta_wing_surface(0, &wing), WEFT_OK) << weft_last_error();
  for (weft_mesh* mesh : {ball, cylinder, wing}) {
    int64_t triangles = 0;
    weft_mesh_count(keep(mesh), WEFT_TRIANGLES, &triangles);
    EXPECT_GT(triangles, 20);
  }
  ASSERT_EQ(weft_fill(ball, nullptr, options(), &filled, nullptr), WEFT_OK) << weft_last_error();
  keep(filled);
  ASSERT_EQ(weft_fill_to_background(ball, filled, sizes(filled, 0.2), nullptr, options(), &finer, nullptr),
            WEFT_OK)
      << weft_last_error();
  int64_t before = 0, after = 0;
  weft_mesh_count(filled, WEFT_TETS, &before);
  weft_mesh_count(keep(finer), WEFT_TETS, &after);
  EXPECT_GT(after, 2 * before);
  EXPECT_EQ(weft_fill_to_background(ball, filled, sizes(ball, 0.2), nullptr, options(), &finer, nullptr),
            WEFT_INPUT_ERROR);
  EXPECT_EQ(weft_ball_surface(-1, origin, 0.5, &ball), WEFT_MISUSE);
  EXPECT_THAT(weft_last_error(), StartsWith("radius: -1"));
  EXPECT_EQ(weft_tessellate(options(), 20, &ball), WEFT_OPTION_ERROR);
  EXPECT_THAT(weft_last_error(), HasSubstr("no CAD model is named"));
}

TEST_F(CInterface, AFillingTellsWhatItHasDoneAndHowItEnded) {
  const double origin[] = {0, 0, 0};
  weft_mesh* ball = nullptr;
  ASSERT_EQ(weft_ball_surface(1, origin, 0.3, &ball), WEFT_OK);
  keep(ball);
  weft_options* asked = options();
  const auto told = [&](const weft_result* of, weft_told what) {
    weft_text* text = nullptr;
    EXPECT_EQ(weft_result_told(of, what, &text), WEFT_OK) << weft_last_error();
    const char* letters = nullptr;
    weft_text_get(keep(text), &letters);
    return std::string(letters);
  };
  weft_result* result = nullptr;
  ASSERT_EQ(weft_fill_to_result(ball, nullptr, nullptr, nullptr, asked, &result), WEFT_OK)
      << weft_last_error();
  weft_fill_account account{};
  account.size = sizeof account;
  ASSERT_EQ(weft_result_fill(keep(result), &account), WEFT_OK) << weft_last_error();
  EXPECT_EQ(account.regions, 1);
  int goal_met = -1, cancelled = -1;
  weft_result_verdict(result, &goal_met, &cancelled);
  EXPECT_EQ(goal_met, 1);
  EXPECT_EQ(cancelled, 0);
  EXPECT_EQ(told(result, WEFT_MENDS) + told(result, WEFT_MISSED) + told(result, WEFT_ENDED_BY), "");
  weft_measures measures{};
  measures.size = sizeof measures;
  ASSERT_EQ(weft_result_measures(result, &measures), WEFT_OK) << weft_last_error();
  EXPECT_GT(measures.tets, 100);
  const char* text = nullptr;
  EXPECT_EQ(weft_result_json(result, &text), WEFT_MISUSE);
  EXPECT_EQ(weft_result_summary(result, &text), WEFT_MISUSE);

  int64_t count = 0;
  weft_mesh_count(ball, WEFT_TRIANGLES, &count);
  std::vector<int64_t> triangles(static_cast<std::size_t>(3 * count));
  weft_mesh_get(ball, WEFT_TRIANGLES, 3 * count, triangles.data());
  triangles.insert(triangles.end(), triangles.begin(), triangles.begin() + 3);  // one twice
  weft_mesh_set(ball, WEFT_TRIANGLE_REFS, 0, nullptr);
  weft_mesh_set(ball, WEFT_TRIANGLES, count + 1, triangles.data());
  weft_options_set(asked, "repair", "yes");
  const auto stop_at_tets = [](void*, const weft_progress* now) { return now->tets > 0 ? 0 : 1; };
  weft_options_set_progress(asked, stop_at_tets, nullptr);
  ASSERT_EQ(weft_fill_to_result(ball, nullptr, nullptr, nullptr, asked, &result), WEFT_OK)
      << weft_last_error();
  weft_result_verdict(keep(result), &goal_met, &cancelled);
  EXPECT_EQ(goal_met, 0);
  EXPECT_EQ(cancelled, 1);
  EXPECT_EQ(told(result, WEFT_ENDED_BY), "interrupted");
  EXPECT_THAT(told(result, WEFT_MENDS), HasSubstr("1 "));
  EXPECT_EQ(weft_result_told(result, static_cast<weft_told>(9), nullptr), WEFT_MISUSE);
}

TEST_F(CInterface, MetricsComeWithTheirWarnings) {
  weft_mesh* mesh = box(3);
  weft_options* asked = options();
  weft_options_set(asked, "complexity", "5000");
  weft_options_set(asked, "hmin", "0.5");
  weft_metric* metric = nullptr;
  weft_text* warnings = nullptr;
  ASSERT_EQ(weft_metric_make_with(mesh, sizes(mesh, 0.3), asked, &metric, &warnings), WEFT_OK)
      << weft_last_error();
  keep(metric);
  const char* text = nullptr;
  weft_text_get(keep(warnings), &text);
  EXPECT_THAT(text, HasSubstr("instead of 5,000\n"));
}

/// Runs call() with memory that runs out at each of its last allocations, where its outputs are made. `good`
/// and `untouched` are called after calls that have ended well and that have not.
template <class Call, class Good, class Untouched>
void expect_untouched_outputs(const Call& call, const Good& good, const Untouched& untouched) {
  if (!weft::testing::kNewCanFail) GTEST_SKIP() << "memory cannot be made to run out";
  constexpr int kMost = 1 << 30, kLast = 12;
  ASSERT_EQ(call(), WEFT_OK) << weft_last_error();  // what is made once is there from now on
  good();
  int used = 0;
  {
    const weft::testing::FailingNew counting(kMost);
    ASSERT_EQ(call(), WEFT_OK);
    used = kMost - counting.successes_left();
  }
  good();
  ASSERT_GT(used, kLast);
  int failures = 0;
  for (int last = 1; last <= kLast; ++last) {
    const int64_t handles = weft_handles();
    weft_status status = WEFT_OK;
    {
      const weft::testing::FailingNew failing(used - last);
      status = call();
    }
    if (status == WEFT_OK) {
      good();
      continue;
    }
    ++failures;
    EXPECT_EQ(status, WEFT_OUT_OF_MEMORY) << "at the last allocation but " << last - 1;
    EXPECT_EQ(weft_handles(), handles) << "at the last allocation but " << last - 1;
    untouched();
  }
  EXPECT_GT(failures, kLast / 2);
}

TEST_F(CInterface, MetricsWhoseMemoryRunsOutLeaveNoWarnings) {
  weft_mesh* mesh = box(1);
  weft_metric* given = sizes(mesh, 0.3);
  weft_options* asked = options();
  weft_options_set(asked, "complexity", "5000");
  weft_options_set(asked, "hmin", "0.5");
  weft_metric* metric = nullptr;
  weft_text* warnings = nullptr;
  expect_untouched_outputs([&] { return weft_metric_make_with(mesh, given, asked, &metric, &warnings); },
                           [&] {
                             weft_free(std::exchange(metric, nullptr));
                             weft_free(std::exchange(warnings, nullptr));
                           },
                           [&] {
                             EXPECT_EQ(metric, nullptr);
                             EXPECT_EQ(warnings, nullptr);
                           });
}

TEST_F(CInterface, RepairsWhoseMemoryRunsOutLeaveTheMesh) {
  weft_mesh* mesh = nullptr;
  const auto points_of = [&mesh] {
    int64_t points = 0;
    weft_mesh_num_points(mesh, &points);
    return points;
  };
  const auto make = [&] {  // two tets, of which one has points of its own where the other's are
    weft_free(std::exchange(mesh, nullptr));
    const double points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, -1};
    const int64_t tets[] = {0, 1, 2, 3, 4, 5, 6, 7};
    weft_mesh_create(8, points, 2, tets, &mesh);
  };
  weft_text* mends = nullptr;
  make();
  expect_untouched_outputs([&] { return weft_mesh_repair(mesh, nullptr, &mends); },
                           [&] {
                             EXPECT_EQ(points_of(), 5);
                             weft_free(std::exchange(mends, nullptr));
                             make();
                           },
                           [&] {
                             EXPECT_EQ(points_of(), 8);
                             EXPECT_EQ(mends, nullptr);
                           });
  weft_free(mesh);
}

TEST_F(CInterface, TransfersAreAccountedFor) {
  weft_mesh *mesh = box(3), *other = box(4);
  int64_t points = 0;
  const double* x = nullptr;
  weft_mesh_num_points(mesh, &points);
  weft_mesh_points(mesh, &x);
  weft_fields *fields = nullptr, *there = nullptr;
  weft_fields_create(points, &fields);
  keep(fields);
  weft_fields_add(fields, "place", 3, x);
  ASSERT_EQ(weft_interpolate(mesh, fields, other, options(), &there), WEFT_OK) << weft_last_error();
  keep(there);
  weft_component_account account{};
  account.size = sizeof account;
  ASSERT_EQ(weft_fields_account(there, 2, &account), WEFT_OK) << weft_last_error();
  EXPECT_STREQ(account.name, "place 3");
  EXPECT_NEAR(account.integral_after, 0.5, 1e-12);
  int64_t outside = -1;
  double farthest = -1;
  ASSERT_EQ(weft_fields_outside(there, &outside, &farthest), WEFT_OK);
  EXPECT_EQ(outside, 0);
  EXPECT_EQ(farthest, 0);
  EXPECT_EQ(weft_fields_account(there, 3, &account), WEFT_MISUSE);
  EXPECT_EQ(weft_fields_account(fields, 0, &account), WEFT_MISUSE);
  EXPECT_THAT(weft_last_error(), HasSubstr("are not those that weft_interpolate() has made"));
}

/// Calls of all functions with arguments at random: good handles, freed ones, those of another kind, NULL and
/// junk; sizes from negative to huge; NaN. Buffers are as large as the sizes say, as C cannot check that.
class Fuzz {
 public:
  explicit Fuzz(unsigned seed) : random_(seed) {}
  ~Fuzz() {
    for (void* handle : handles_) weft_free(handle);
  }

  void call() {
    const weft_status status = call_one();
    ++calls;
    if (status == WEFT_OK) return;
    ++refused;
    EXPECT_NE(std::string(weft_last_error()), "");
    EXPECT_NE(status, WEFT_INTERNAL_ERROR) << weft_last_error();
  }
  int calls = 0, refused = 0, adapted = 0;

 private:
  int pick(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  template <class Handle>
  Handle* handle() {
    const int kind = pick(20);
    if (kind == 0) return nullptr;
    if (kind == 1) return reinterpret_cast<Handle*>(static_cast<std::uintptr_t>(random_()));
    if (kind == 2 && !freed_.empty())
      return static_cast<Handle*>(freed_[static_cast<std::size_t>(pick(static_cast<int>(freed_.size())))]);
    if (kind < 6 && !handles_.empty()) return static_cast<Handle*>(any());
    return static_cast<Handle*>(of_type<Handle>());
  }
  void* any() { return handles_[static_cast<std::size_t>(pick(static_cast<int>(handles_.size())))]; }
  template <class Handle>
  void* of_type() {
    std::vector<Handle*>& known = typed<Handle>();
    return known.empty() ? nullptr : known[static_cast<std::size_t>(pick(static_cast<int>(known.size())))];
  }
  template <class Handle>
  std::vector<Handle*>& typed() {
    return std::get<std::vector<Handle*>>(typed_);
  }
  template <class Handle>
  weft_status made(weft_status status, Handle* const& handle) {  // written by the call that gives the status
    if (status == WEFT_OK) {
      handles_.push_back(handle);
      typed<Handle>().push_back(handle);
    }
    return status;
  }
  double value() {
    const double all[] = {0.3, 1, -1, 0, kNaN, INFINITY, 1e300, 1e-300, 0.5};
    return pick(3) ? 0.2 + 0.1 * pick(9) : all[pick(9)];
  }
  int64_t count() {
    const int64_t all[] = {0, 1, 27, 8, -1, 5, 64};
    return pick(4) ? (pick(2) ? 8 : 27) : all[pick(7)];
  }
  std::vector<double> values(int64_t n, bool tame) {
    std::vector<double> all(static_cast<std::size_t>(std::max<int64_t>(n, 0)));
    for (double& v : all) v = tame ? 0.1 + 0.1 * pick(9) : value();
    return all;
  }
  std::vector<int64_t> indices(int64_t n, bool tame) {
    std::vector<int64_t> all(static_cast<std::size_t>(std::max<int64_t>(n, 0)));
    for (int64_t& v : all) v = tame ? pick(8) : pick(12) ? pick(30) : int64_t{-5} << pick(50);
    return all;
  }
  /// A pointer to the data, or, seldom, NULL.
  template <class T>
  const T* data(const std::vector<T>& all) {
    return pick(15) ? all.data() : nullptr;
  }

  weft_status call_one() {
    weft_mesh* mesh = nullptr;
    weft_metric* metric = nullptr;
    weft_options* options = nullptr;
    weft_fields* fields = nullptr;
    weft_result* result = nullptr;
    weft_part* part = nullptr;
    int64_t n = count(), out = 0;
    const bool tame = pick(2) == 0;
    switch (pick(36)) {
      case 0:
        return made(weft_mesh_box(pick(4), 2, 1 + pick(2), &mesh), mesh);
      case 1: {
        const auto xyz = values(3 * n, tame);
        const int64_t tets = count();
        const auto corners = indices(4 * tets, tame);
        return made(weft_mesh_create(n, data(xyz), tets, data(corners), &mesh), mesh);
      }
      case 2: {
        const auto all = indices(4 * n, tame);
        return weft_mesh_set(handle<weft_mesh>(), static_cast<weft_array>(pick(14) - 1), n, data(all));
      }
      case 3: {
        std::vector<int64_t> room(static_cast<std::size_t>(std::max<int64_t>(n, 0)) * 8 + 1);
        return weft_mesh_get(handle<weft_mesh>(), static_cast<weft_array>(pick(13)), 8 * n, room.data());
      }
      case 4:
        return weft_mesh_num_points(handle<weft_mesh>(), pick(9) ? &out : nullptr);
      case 5:
        return weft_mesh_count(handle<weft_mesh>(), static_cast<weft_array>(pick(14) - 1), &out);
      case 6:
        return weft_mesh_verify(handle<weft_mesh>(), &out, nullptr);
      case 7: {
        const auto h = values(n, tame);
        return made(weft_metric_from_sizes(n, data(h), &metric), metric);
      }
      case 8: {
        const auto m = values(6 * n, false);
        return made(weft_metric_from_tensors(n, data(m), static_cast<weft_tensor_order>(pick(5)), &metric),
                    metric);
      }
      case 9: {
        std::vector<double> room(static_cast<std::size_t>(std::max<int64_t>(n, 0)) * 6 + 1);
        return weft_metric_get(handle<weft_metric>(), static_cast<weft_tensor_order>(pick(5)), 6 * n,
                               room.data());
      }
      case 10: {
        double c = 0;
        return weft_metric_complexity(handle<weft_mesh>(), handle<weft_metric>(), &c);
      }
      case 11:
        return made(weft_options_create(nullptr, &options), options);
      case 12: {
        weft_settings s{};
        s.size = pick(2) ? sizeof s : static_cast<std::size_t>(pick(400));
        if (pick(3)) weft_settings_default(&s);
        s.hmin = pick(3) ? 0 : value();
        s.threads = pick(5) ? 1 : pick(3000) - 100;
        return made(weft_options_create(&s, &options), options);
      }
      case 13: {
        const char* name = weft_option_name(pick(40), nullptr, nullptr);
        const char* texts[] = {"1", "0.5", "yes", "", "nan", "linear", "-3", "1,2", "99999999999", "2"};
        return weft_options_set(handle<weft_options>(), name, pick(20) ? texts[pick(10)] : nullptr);
      }
      case 14:
        return weft_options_set_number(handle<weft_options>(), pick(2) ? "hmax" : "hgrad", value());
      case 15:
        return made(weft_fields_create(n, &fields), fields);
      case 16: {
        const auto known = handle<weft_fields>();
        int64_t points = 0;
        if (weft_fields_count(known, nullptr, &points) != WEFT_OK) points = 0;
        const auto v = values(6 * points, tame);
        return weft_fields_add(known, pick(9) ? "u" : nullptr, pick(8), data(v));
      }
      case 17:
        return weft_options_add_solution(handle<weft_options>(), handle<weft_fields>());
      case 18:  // a metric that belongs to the mesh
      case 19: {
        const auto asked = pick(2) ? handle<weft_options>() : nullptr;
        weft_options_set_number(asked, "threads", 1);
        const auto known = handle<weft_mesh>();
        if (pick(4) && weft_mesh_num_points(known, &out) == WEFT_OK) {
          const std::vector<double> h(static_cast<std::size_t>(out), 0.4);
          made(weft_metric_from_sizes(out, h.data(), &metric), metric);
          const weft_status status = weft_adapt(known, metric, asked, nullptr, &result);
          adapted += status == WEFT_OK;
          return made(status, result);
        }
        const weft_status status = weft_adapt(handle<weft_mesh>(), handle<weft_metric>(), asked,
                                              pick(2) ? handle<weft_fields>() : nullptr, &result);
        adapted += status == WEFT_OK;
        return made(status, result);
      }
      case 20:
        return made(weft_result_mesh(handle<weft_result>(), &mesh), mesh);
      case 21:
        return made(weft_result_metric(handle<weft_result>(), &metric), metric);
      case 22: {
        const char* text = nullptr;
        return weft_result_summary(handle<weft_result>(), pick(9) ? &text : nullptr);
      }
      case 23: {
        const auto known = handle<weft_mesh>();
        if (weft_mesh_num_points(known, &out) != WEFT_OK) out = 0;
        const auto ids = indices(out, tame);
        return made(weft_part_create(known, data(ids), nullptr, nullptr, &part), part);
      }
      case 24:
        return made(weft_part_mesh(handle<weft_part>(), &mesh), mesh);
      case 25:
        return made(weft_interpolate(handle<weft_mesh>(), handle<weft_fields>(), handle<weft_mesh>(), nullptr,
                                     &fields),
                    fields);
      case 26:
        return weft_mesh_compare(handle<weft_mesh>(), handle<weft_mesh>(), pick(9) ? &out : nullptr);
      case 27: {
        weft_text* text = nullptr;
        const weft_status status = weft_stat(handle<weft_mesh>(), pick(2) ? handle<weft_metric>() : nullptr,
                                             nullptr, pick(9) ? &text : nullptr);
        if (status == WEFT_OK) handles_.push_back(text);
        return status;
      }
      case 28: {
        const std::array<int64_t, 3> cells = {pick(4), 1, 2};
        const auto corners = values(6, tame);
        return made(
            weft_mesh_box_between(pick(9) ? cells.data() : nullptr, data(corners), corners.data() + 3, &mesh),
            mesh);
      }
      case 29: {
        const auto asked = handle<weft_options>();
        weft_options_set_number(asked, "threads", 1);
        const weft_status status = weft_adapt_to_background(handle<weft_mesh>(), handle<weft_mesh>(),
                                                            handle<weft_metric>(), asked, nullptr, &result);
        return made(status, result);
      }
      case 30: {
        const auto place = values(3, tame);
        return made(weft_ball_surface(value(), data(place), 0.5, &mesh), mesh);
      }
      case 31: {
        weft_component_account account{};
        account.size = pick(3) ? sizeof account : static_cast<std::size_t>(pick(200));
        return weft_fields_account(handle<weft_fields>(), n, pick(9) ? &account : nullptr);
      }
      case 32: {
        double farthest = 0;
        return weft_fields_outside(handle<weft_fields>(), &out, &farthest);
      }
      case 33: {
        weft_write_settings s{};
        s.size = pick(2) ? sizeof s : static_cast<std::size_t>(pick(100));
        if (pick(3)) weft_write_settings_default(&s);
        return weft_convert(pick(5) ? "no such file.meshb" : nullptr, "none.meshb", nullptr, &s, nullptr);
      }
      case 34: {
        weft_file_settings s{};
        s.size = pick(2) ? sizeof s : static_cast<std::size_t>(pick(200));
        if (pick(3)) weft_file_settings_default(&s);
        s.num_fields = n;
        return made(
            weft_adapt_files_with("no such file.meshb", "none.meshb", &s, handle<weft_options>(), &result),
            result);
      }
      default: {
        if (pick(3)) return weft_mesh_points(handle<weft_mesh>(), nullptr);
        void* gone = handles_.empty() || pick(5) == 0 ? nullptr : any();
        const weft_status status = weft_free(gone);
        freed_.push_back(gone);
        return status;
      }
    }
  }

  std::mt19937 random_;
  std::vector<void*> handles_, freed_;
  std::tuple<std::vector<weft_mesh*>, std::vector<weft_metric*>, std::vector<weft_options*>,
             std::vector<weft_fields*>, std::vector<weft_result*>, std::vector<weft_part*>>
      typed_;
};

TEST(CFuzz, AThousandCallsAtRandomEndWithAStatusAndAText) {
  int adapted = 0;
  for (unsigned seed = 0; seed < 4; ++seed) {
    Fuzz fuzz(seed);
    for (int i = 0; i < 500; ++i) fuzz.call();
    adapted += fuzz.adapted;
    EXPECT_GT(fuzz.refused, fuzz.calls / 10);
    EXPECT_LT(fuzz.refused, fuzz.calls * 9 / 10);
  }
  EXPECT_GT(adapted, 0);  // not all has been refused at the door
}

}  // namespace
