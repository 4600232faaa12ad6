// The library as programs see it: this file includes nothing of weft but its public header.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <weft/weft.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <thread>
#include <vector>

namespace weft {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

Mesh box_of(std::uint32_t cells) {
  BoxOptions options;
  options.cells = {cells, cells, cells};
  return box(options);
}

Metric sizes(const Mesh& mesh, double h) {
  return Metric::from_sizes(std::vector<double>(mesh.points.size(), h));
}

Options one_thread() {
  Options options;
  options.run.threads = 1;
  return options;
}

bool equal(const Mesh& a, const Mesh& b) {
  return a.points == b.points && a.tets == b.tets && a.triangles == b.triangles && a.tet_refs == b.tet_refs &&
         a.triangle_refs == b.triangle_refs && a.edges == b.edges;
}

/// What a call throws, as text; empty for nothing.
template <class Error>
std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Door, AdaptsOneMeshToAMetric) {
  const Mesh start = box_of(4);
  const Result fine = adapt(start, sizes(start, 0.15), one_thread());
  EXPECT_TRUE(verify(fine.mesh).ok());
  EXPECT_EQ(fine.metric.size(), fine.mesh.points.size());
  EXPECT_GT(fine.after->edges_unit, 0.9);
  EXPECT_TRUE(fine.goal_met());
  EXPECT_NEAR(measure_geometry(fine.mesh).volume_by_ref.at(1), 1, 1e-12);
}

TEST(Door, AcceptsMeshesWithoutReferences) {
  Mesh bare = box_of(3);
  bare.point_refs.clear();
  bare.tet_refs.clear();
  bare.triangles.clear();
  bare.triangle_refs.clear();
  bare.edges.clear();
  bare.edge_refs.clear();
  bare.ridges.clear();
  bare.corners.clear();
  const Result fine = adapt(bare, sizes(bare, 0.2), one_thread());
  EXPECT_TRUE(verify(fine.mesh).ok());
  ASSERT_FALSE(fine.warnings.empty());  // triangles have been made
}

TEST(Door, ScalesToTheComplexityThatOptionsAskFor) {
  const Mesh start = box_of(4);
  Options options = one_thread();
  options.metric.complexity = 500;
  const Result fine = adapt(start, sizes(start, 1), options);
  EXPECT_NEAR(fine.after->complexity, 500, 50);
  EXPECT_TRUE(fine.complexity_asked);
}

TEST(Door, GivesTheSameMeshInSubdomainsFromMemoryAsFromFiles) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "weft-door";
  std::filesystem::create_directories(folder);
  const Mesh start = box_of(4);
  write_mesh((folder / "start.meshb").string(), start);
  Options options = one_thread();
  options.metric.function = "uniform:0.2";
  options.metric.complexity = 800;
  options.distributed.subdomains = 4;
  Files files;
  files.input = (folder / "start.meshb").string();
  files.output = (folder / "fine.meshb").string();
  const FilesResult by_files = adapt_files(files, options);
  EXPECT_TRUE(by_files.goal_met());
  const Result in_memory = adapt(start, options);
  EXPECT_TRUE(equal(read_mesh(files.output), in_memory.mesh));
  EXPECT_NE(summary(by_files), "");
}

TEST(Door, AReportThatCouldNotBeWrittenIsNotToldAsWritten) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "weft-door-report";
  std::filesystem::create_directories(folder);
  Files files;
  files.input = (folder / "start.meshb").string();
  files.output = (folder / "fine.meshb").string();
  files.report = (folder / "run").string();
  write_mesh(files.input, box_of(3));
  for (const std::uint32_t subdomains : {0u, 2u}) {
    Options options = one_thread();
    options.metric.function = "uniform:0.3";
    options.distributed.subdomains = subdomains;
    const FilesResult written = adapt_files(files, options);
    EXPECT_EQ(written.report, (folder / "run" / "report.json").string());
    EXPECT_EQ(written.report_error, "");
    options.run.progress = [&](const Progress&) {
      std::filesystem::remove_all(files.report);
      return true;
    };
    const FilesResult lost = adapt_files(files, options);
    EXPECT_TRUE(std::filesystem::exists(files.output));
    EXPECT_EQ(lost.report, "");
    EXPECT_THAT(lost.report_error, HasSubstr("report.json"));
    EXPECT_THAT(summary(lost), Not(HasSubstr("\nreport  ")));
    EXPECT_THAT(summary(lost), HasSubstr("\nerror   " + lost.report_error + "\n"));
  }
}

TEST(Door, CarriesFieldsAlong) {
  const Mesh start = box_of(4);
  Field field{Field::Kind::scalar, {}, "linear"};
  for (const Point& p : start.points) field.values.push_back(1 + 2 * p.x - p.y + 3 * p.z);
  Options options = one_thread();
  options.transfer = TransferMethod::conservative;
  const Result fine = adapt(start, sizes(start, 0.2), options, {start.points.size(), {field}});
  ASSERT_EQ(fine.fields.fields.size(), 1u);
  for (std::size_t v = 0; v < fine.mesh.points.size(); ++v) {
    const Point& p = fine.mesh.points[v];
    EXPECT_NEAR(fine.fields.fields[0].values[v], 1 + 2 * p.x - p.y + 3 * p.z, 1e-9);
  }
}

TEST(Door, RefusesOptionsNamingThem) {
  const auto wrong = [](const std::function<void(Options&)>& change) {
    Options options;
    change(options);
    return error_of<OptionError>([&] { validate(options); });
  };
  EXPECT_THAT(wrong([](Options& o) { o.metric.hmin = 2, o.metric.hmax = 1; }), StartsWith("--hmin: "));
  EXPECT_THAT(wrong([](Options& o) { o.metric.aspect = 0.5; }), StartsWith("--aspect: "));
  EXPECT_THAT(wrong([](Options& o) { o.metric.complexity = -1; }), StartsWith("--complexity: "));
  EXPECT_THAT(wrong([](Options& o) { o.metric.complexity = NAN; }), StartsWith("--complexity: "));
  EXPECT_THAT(wrong([](Options& o) { o.metric.function = "cubes"; }), StartsWith("--metric-fn: "));
  EXPECT_THAT(wrong([](Options& o) { o.metric.wall.refs = {1}; }), StartsWith("--wall-height: "));
  EXPECT_THAT(wrong([](Options& o) { o.geometry.ridge_angle = 181; }), StartsWith("--ridge-angle: "));
  EXPECT_THAT(wrong([](Options& o) { o.run.threads = -1; }), StartsWith("--threads: "));
  EXPECT_THAT(wrong([](Options& o) { o.distributed.partitioner = "slices"; }), StartsWith("--partitioner: "));
  EXPECT_THAT(wrong([](Options& o) { o.distributed.balancer = "best"; }), StartsWith("--balancer: "));
  EXPECT_THAT(wrong([](Options& o) { o.distributed.layers = -1; }), StartsWith("--layers: "));
  EXPECT_EQ(wrong([](Options&) {}), "");
}

TEST(Door, CutsSlabsAlongTheBoundary) {
  const Mesh start = box_of(3);
  Options options;
  options.metric.function = "uniform:0.3";
  set_option(options, "partitioner", "pqr:3x1x1:harmonic=1,2");
  set_option(options, "layers", "3");
  EXPECT_EQ(options.distributed.layers, 3);
  const Result fine = adapt(start, options);
  ASSERT_TRUE(fine.distributed);
  EXPECT_EQ(fine.distributed->subdomains, 3u);
  EXPECT_EQ(fine.distributed->layers, 3);
  EXPECT_TRUE(verify(fine.mesh).ok());
  set_option(options, "layers", "auto");
  EXPECT_EQ(options.distributed.layers, std::nullopt);
  set_option(options, "partitioner", "pqr:3x1x1:wall=9");
  EXPECT_THAT(error_of<InputError>([&] { adapt(start, options); }),
              ::testing::HasSubstr("no triangle has the reference 9"));
}

TEST(Door, RefusesABackgroundWhereThereIsNoPlaceForOne) {
  const Mesh start = box_of(2), background = box_of(3);
  const Metric metric = sizes(background, 0.4);
  Options options = one_thread();
  options.run.repair = true;
  EXPECT_THAT(error_of<OptionError>([&] { adapt(start, background, metric, options); }),
              HasSubstr("--repair"));
  FillOptions filling;
  filling.background = &background;
  EXPECT_THAT(error_of<OptionError>([&] { fill(start, filling); }),
              HasSubstr("--background: requires --metric"));
}

TEST(Door, RefusesDataNamingTheEntity) {
  const Mesh start = box_of(2);
  const Metric short_metric = Metric::from_sizes(std::vector<double>(5, 0.2));
  EXPECT_THAT(error_of<InputError>([&] { adapt(start, short_metric); }), HasSubstr("metric of another mesh"));
  Mesh wrong = start;
  wrong.tets[3][1] = 1000;
  EXPECT_THAT(error_of<InputError>([&] { adapt(wrong, sizes(start, 0.2)); }), HasSubstr("tet 4"));
  wrong = start;
  wrong.points[2].y = NAN;
  EXPECT_THAT(error_of<InputError>([&] { adapt(wrong, sizes(start, 0.2)); }), HasSubstr("vertex 3"));
  const std::vector<double> negative = {1, -1, 1};
  EXPECT_THAT(error_of<InputError>([&] { Metric::from_sizes(negative); }), HasSubstr("vertex 2"));
  EXPECT_THAT(error_of<InputError>([&] { adapt(start, Options{}); }), HasSubstr("no metric"));
  EXPECT_THAT(error_of<InputError>([] { read_mesh("nowhere.meshb"); }), HasSubstr("nowhere.meshb"));
}

TEST(Door, CancelsByTheProgressFunctionWithAValidMesh) {
  const Mesh start = box_of(6);
  for (const std::uint32_t subdomains : {0u, 4u}) {
    Options options = one_thread();
    options.distributed.subdomains = subdomains;
    options.run.progress = [](const Progress& now) { return now.tets == 0 || now.stage == "reading"; };
    Result result = adapt(start, sizes(start, 0.03), options);
    EXPECT_TRUE(result.cancelled);
    EXPECT_FALSE(result.goal_met());
    EXPECT_TRUE(verify(result.mesh).ok());
    EXPECT_FALSE(result.after.has_value());
    EXPECT_THAT(result.missed, ElementsAre(HasSubstr("interrupted")));
    EXPECT_THAT(summary(result), Not(HasSubstr("GOAL MET")));
    EXPECT_EQ(measures(result).num_tets, result.mesh.tets.size());
    EXPECT_EQ(to_json(*result.after), to_json(measure(result.mesh, result.metric)));
    EXPECT_THAT(result.missed, ElementsAre(HasSubstr("interrupted"), HasSubstr("of the edges are unit")));
  }
}

TEST(Door, MeasuresAreTakenWhenTheyAreAskedForWhereTheRunLeavesThemOut) {
  const Mesh start = box_of(3);
  Options options = one_thread();
  const Result measured = adapt(start, sizes(start, 0.2), options);
  options.run.measure = false;
  Result result = adapt(start, sizes(start, 0.2), options);
  EXPECT_FALSE(result.after.has_value());
  EXPECT_FALSE(result.goal_met());
  EXPECT_THAT(summary(result), StartsWith("NOT MEASURED"));
  EXPECT_THAT(to_json(result), HasSubstr("\"after\": null"));
  EXPECT_EQ(to_json(measures(result)), to_json(*measured.after));
  EXPECT_TRUE(result.goal_met());
}

TEST(Door, CancelsByAFlagOfAnotherThread) {
  const Mesh start = box_of(6);
  std::atomic<bool> cancel = false;
  Options options = one_thread();
  options.run.cancel = &cancel;
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    cancel = true;
  });
  const Result result = adapt(start, sizes(start, 0.02), options);
  other.join();
  EXPECT_TRUE(result.cancelled);
  EXPECT_TRUE(verify(result.mesh).ok());
}

TEST(Door, CancelledWhileItsMetricIsMadeReturnsTheInput) {
  const Mesh start = box_of(6);
  std::atomic<bool> cancel = true;
  for (const std::uint32_t subdomains : {0u, 4u}) {
    Options options = one_thread();
    options.distributed.subdomains = subdomains;
    options.metric.function = "polar-2";
    options.metric.complexity = 20000;
    options.metric.hgrad = 1.3;
    options.run.cancel = &cancel;
    const Result result = adapt(start, options);
    EXPECT_EQ(result.ended_by, "interrupted");
    EXPECT_THAT(result.warnings, ::testing::Contains(HasSubstr("the metric need not be as asked for")));
    EXPECT_TRUE(verify(result.mesh).ok());
  }
}

TEST(Door, WhatEndsARunLeavesTheCallersFlagAlone) {
  const Mesh start = box_of(6);
  std::atomic<bool> cancel = false;
  for (const std::uint32_t subdomains : {0u, 4u}) {
    Options options = one_thread();
    options.distributed.subdomains = subdomains;
    options.run.cancel = &cancel;
    options.run.time_limit = 0.01;
    EXPECT_EQ(adapt(start, sizes(start, 0.03), options).ended_by, "time limit");
    options.run.time_limit = 0;
    options.run.progress = [](const Progress&) { return false; };
    EXPECT_EQ(adapt(start, sizes(start, 0.03), options).ended_by, "interrupted");
    EXPECT_FALSE(cancel);
  }
}

TEST(Door, FillingThatIsCancelledBeforeThereIsAMeshSaysSo) {
  std::atomic<bool> cancel = true;
  FillOptions options;
  options.run.cancel = &cancel;
  BallOptions ball;
  ball.size = 0.4;
  EXPECT_EQ(error_of<RunError>([&] { fill(ball_surface(ball), options); }),
            "interrupted before there was a mesh");
}

TEST(Door, AdaptsTwoMeshesAtOnceAsItDoesEachAlone) {
  const Mesh a = box_of(5), b = box_of(6);
  Options for_a = one_thread(), for_b = one_thread();
  for_a.metric.function = "polar-1";
  for_a.metric.complexity = 1500;
  for_b.metric.function = "linear";
  for_b.metric.complexity = 1500;
  for_b.distributed.subdomains = 4;
  const Result alone_a = adapt(a, for_a), alone_b = adapt(b, for_b);
  Result beside_a, beside_b;
  std::thread first([&] { beside_a = adapt(a, for_a); });
  std::thread second([&] { beside_b = adapt(b, for_b); });
  first.join();
  second.join();
  EXPECT_TRUE(equal(alone_a.mesh, beside_a.mesh));
  EXPECT_TRUE(equal(alone_b.mesh, beside_b.mesh));
}

TEST(Door, ChecksAFileOfFieldsAsReadingItDoes) {
  const Mesh mesh = box_of(3);
  const std::size_t n = mesh.points.size();
  Fields good{n,
              {{Field::Kind::scalar, std::vector<double>(n, 2.5), "heat"},
               {Field::Kind::vector, std::vector<double>(3 * n, 1.5), "flow"}}};
  Fields bad = good;
  bad.fields[1].values[3 * 9 + 1] = std::numeric_limits<double>::quiet_NaN();
  for (const char* extension : {".solb", ".sol", ".vtu", ".msh", ".cgns"}) {
    const std::string path = ::testing::TempDir() + "weft_door_checked" + extension;
    const auto check = [&](std::size_t points) {
      return error_of<InputError>([&] { check_field_file(path, {points, points}, "box"); });
    };
    const auto read = [&](std::size_t points) {
      return error_of<InputError>([&] { read_fields({path}, points, "box"); });
    };
    if (is_mesh_name(path))
      write_mesh(path, mesh, good);
    else
      write_fields(path, good);
    EXPECT_EQ(check(n), "") << path;
    const Fields heads = check_field_file(path, {n, n});
    ASSERT_EQ(heads.fields.size(), 2u) << path;
    EXPECT_EQ(heads.fields[0].kind, Field::Kind::scalar);
    EXPECT_EQ(heads.fields[1].kind, Field::Kind::vector);
    EXPECT_THAT(heads.fields[1].values, ElementsAre());
    EXPECT_THAT(check(n - 1), HasSubstr("belongs to another mesh"));
    EXPECT_EQ(check(n - 1), read(n - 1));
    if (!is_mesh_name(path)) {  // those with such values are not written
      write_fields(path, bad);
      EXPECT_THAT(check(n), HasSubstr("field 2: vertex 10: not a finite number"));
      EXPECT_EQ(check(n), read(n));
    }
    std::filesystem::remove(path);
  }
}

TEST(Door, CountsTheVerticesOfAMeshFile) {
  const Mesh mesh = box_of(3);
  for (const char* name :
       {"a.meshb", "a.mesh", "a.msh", "a.vtu", "a.cgns", "a.su2", "a.ugrid", "a.lb8.ugrid"}) {
    const std::string path = ::testing::TempDir() + "weft_door_counted_" + name;
    write_mesh(path, mesh);
    const VertexCount count = count_vertices(path);
    EXPECT_EQ(count.least, mesh.points.size()) << name;
    EXPECT_EQ(count.most, mesh.points.size()) << name;
    std::filesystem::remove(path);
  }
  const std::string pieces = ::testing::TempDir() + "weft_door_counted.pvtu";
  write_mesh(pieces, mesh);
  const VertexCount count = count_vertices(pieces);
  EXPECT_LE(count.least, mesh.points.size());
  EXPECT_GE(count.most, mesh.points.size());
}

TEST(Door, ReadsAMetricFromAnotherMesh) {
  const Mesh start = box_of(3), background = box_of(5);
  std::vector<double> h;
  for (const Point& p : background.points) h.push_back(0.1 + 0.2 * p.x);
  const Result fine = adapt(start, background, Metric::from_sizes(h), one_thread());
  EXPECT_TRUE(verify(fine.mesh).ok());
  EXPECT_GT(fine.after->edges_unit, 0.85);
  EXPECT_FALSE(fine.before);
  Options options = one_thread();
  options.distributed.subdomains = 4;
  const Result parts = adapt(start, background, Metric::from_sizes(h), options);
  EXPECT_TRUE(verify(parts.mesh).ok());
  EXPECT_GT(parts.after->edges_unit, 0.85);
  EXPECT_NEAR(parts.target_complexity, fine.target_complexity, 1e-9 * fine.target_complexity);
  EXPECT_NEAR(parts.after->complexity, fine.after->complexity, 0.05 * fine.after->complexity);
  EXPECT_FALSE(parts.before);
}

TEST(Door, MakesMetricsOfSolutionsInMemory) {
  const Mesh mesh = box_of(8);
  Field u{Field::Kind::scalar, {}, "u"};
  for (const Point& p : mesh.points) u.values.push_back(std::tanh(10 * (p.x - 0.5)));
  MetricOptions options;
  options.solutions = {{mesh.points.size(), {u}}};
  options.complexity = 400;
  options.hgrad = 1.5;
  const MadeMetric made = make_metric(mesh, options);
  EXPECT_NEAR(complexity(mesh, made.metric), 400, 4);
}

/// The same with a vertex before the others that no tet has.
Mesh with_unused_vertex(Mesh mesh) {
  mesh.points.insert(mesh.points.begin(), {5, 5, 5});
  mesh.point_refs.insert(mesh.point_refs.begin(), 0);
  const auto shift = [](auto& rows) {
    for (auto& row : rows)
      for (std::uint32_t& point : row) ++point;
  };
  shift(mesh.tets), shift(mesh.triangles), shift(mesh.edges);
  for (auto* indices : {&mesh.corners, &mesh.required_points})
    for (std::uint32_t& point : *indices) ++point;
  return mesh;
}

Fields wave_at(const Mesh& mesh) {
  Field field{Field::Kind::scalar, {}, "wave"};
  for (const Point& p : mesh.points) field.values.push_back(std::tanh(10 * (p.x - 0.5)) + p.y * p.z);
  return {mesh.points.size(), {field}};
}

TEST(Door, CancelledWhileFieldsAreCarriedInterpolatesThem) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "weft-door-fields";
  std::filesystem::create_directories(folder);
  const Mesh start = box_of(4);
  Files files;
  files.input = (folder / "start.meshb").string();
  files.output = (folder / "fine.meshb").string();
  files.fields = {(folder / "wave.solb").string()};
  write_mesh(files.input, start);
  write_fields(files.fields[0], wave_at(start));
  for (const std::uint32_t subdomains : {0u, 2u}) {
    Options options = one_thread();
    options.metric.function = "uniform:0.3";
    options.distributed.subdomains = subdomains;
    options.transfer = TransferMethod::conservative;
    const FilesResult whole = adapt_files(files, options);
    EXPECT_EQ(whole.transfer, TransferMethod::conservative);
    EXPECT_FALSE(whole.cancelled);
    options.run.progress = [](const Progress& now) { return now.stage != "fields"; };
    const FilesResult cut = adapt_files(files, options);
    EXPECT_EQ(cut.transfer, TransferMethod::linear);
    EXPECT_EQ(cut.ended_by, "interrupted");
    EXPECT_THAT(cut.missed, ::testing::Contains(HasSubstr("interrupted")));
    EXPECT_THAT(cut.warnings, ::testing::Contains(HasSubstr("the fields are interpolated")));
    EXPECT_TRUE(cut.after.has_value());  // the mesh is what was asked for
    EXPECT_TRUE(std::filesystem::exists(cut.fields));
  }
}

TEST(Door, CancelledInSubdomainsInterpolatesFieldsInMemory) {
  const Mesh start = box_of(4);
  Options options = one_thread();
  options.metric.function = "uniform:0.3";
  options.distributed.subdomains = 2;
  options.transfer = TransferMethod::conservative;
  EXPECT_EQ(adapt(start, options, wave_at(start)).transfer, TransferMethod::conservative);
  options.run.progress = [](const Progress&) { return false; };
  const Result cut = adapt(start, options, wave_at(start));
  EXPECT_TRUE(cut.cancelled);
  EXPECT_EQ(cut.transfer, TransferMethod::linear);
}

TEST(Door, WhatIsAtTheVerticesOfAMendedMeshFollows) {
  const Mesh sound = box_of(4), broken = with_unused_vertex(sound);
  Options options = one_thread();
  options.metric.complexity = 500;
  options.metric.solutions = {wave_at(sound)};
  const Result plain = adapt(sound, options);
  options.run.repair = true;
  options.metric.solutions = {wave_at(broken)};
  const Result of_memory = adapt(broken, options);
  EXPECT_EQ(of_memory.mends.size(), 1u);
  EXPECT_TRUE(equal(of_memory.mesh, plain.mesh));
  const std::string file = (std::filesystem::path(::testing::TempDir()) / "weft-door-wave.solb").string();
  write_fields(file, wave_at(broken));
  options.metric.solutions.clear();
  options.metric.sol = {file};
  EXPECT_TRUE(equal(adapt(broken, options).mesh, plain.mesh));
  options.metric = {};
  options.metric.file = file;
  write_fields(file, sizes(broken, 0.2).fields());
  const Mesh by_metric = adapt(broken, options).mesh;
  write_fields(file, sizes(sound, 0.2).fields());
  options.run.repair = false;
  EXPECT_TRUE(equal(by_metric, adapt(sound, options).mesh));
}

TEST(Door, RefusesSolutionsOfAnotherMeshThanTheOneToBeMended) {
  const Mesh broken = with_unused_vertex(box_of(2));
  Options options = one_thread();
  options.run.repair = true;
  options.metric.solutions = {wave_at(box_of(3))};
  EXPECT_THAT(error_of<InputError>([&] { adapt(broken, options); }), HasSubstr("solution of another mesh"));
  options.metric.solutions = {wave_at(broken)};
  options.metric.solutions[0].fields[0].values.pop_back();
  EXPECT_THAT(error_of<InputError>([&] { adapt(broken, options); }), HasSubstr("field 1: has "));
}

TEST(Door, MetricsOfSolutionsAskForNoEdgesLongerThanTheDomain) {
  const Mesh mesh = box_of(8);
  Field u{Field::Kind::scalar, {}, "u"};
  for (const Point& p : mesh.points) u.values.push_back(p.x * p.x);  // nothing to resolve in y and z
  MetricOptions options;
  options.solutions = {{mesh.points.size(), {u}}};
  options.complexity = 400;
  const auto least_of = [&] {
    const MadeMetric made = make_metric(mesh, options);
    EXPECT_NEAR(complexity(mesh, made.metric), 400, 4);
    double least = 1e300;
    for (std::size_t v = 0; v < made.metric.size(); ++v) least = std::min(least, made.metric.tensor(v).yy);
    return least;
  };
  EXPECT_GE(least_of(), (1 - 1e-9) / 3);  // the diagonal of the box is the square root of 3
  options.hmax = 1000;
  EXPECT_LT(least_of(), 0.1);
}

TEST(Door, FillsAClosedSurface) {
  BallOptions ball;
  ball.size = 0.4;
  FillOptions options;
  options.run.threads = 1;
  const FillResult filled = fill(ball_surface(ball), options);
  EXPECT_TRUE(verify(filled.mesh).ok());
  EXPECT_EQ(filled.regions, 1u);
}

TEST(Door, TensorsGoInAndComeOutAgain) {
  const std::vector<Tensor> tensors = {{100, 0, 4, 0, 0, 1}, {2, 0.5, 3, 0.1, 0.2, 4}};
  const Metric metric = Metric::from_tensors(tensors);
  for (std::size_t i = 0; i < tensors.size(); ++i) {
    EXPECT_NEAR(metric.tensor(i).xx, tensors[i].xx, 1e-12 * tensors[i].xx);
    EXPECT_NEAR(metric.tensor(i).yz, tensors[i].yz, 1e-12);
  }
}

}  // namespace
}  // namespace weft
