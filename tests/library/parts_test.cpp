// A mesh that a program holds in parts, on communicators of its own. Under mpirun, with any number of ranks.
#include <gtest/gtest.h>
#include <weft/weft.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <vector>

namespace weft {
namespace {

int world_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

/// The ranks of the world in the opposite order.
class Split {
 public:
  Split() {
    MPI_Comm_split(MPI_COMM_WORLD, 0, -world_rank(), &communicator);
    MPI_Comm_rank(communicator, &rank);
    MPI_Comm_size(communicator, &ranks);
  }
  ~Split() { MPI_Comm_free(&communicator); }
  MPI_Comm communicator = MPI_COMM_NULL;
  int rank = 0, ranks = 1;
};

Mesh whole_box() {
  BoxOptions options;
  options.cells = {5, 5, 5};
  return box(options);
}

/// Which rank a tet is on.
using Rule = std::function<int(std::size_t tet)>;

/// Ids that are neither small nor dense.
std::uint64_t id_of(std::uint32_t vertex) { return 1000 + 3 * std::uint64_t{vertex}; }

double linear(const Point& p) { return 1 + 2 * p.x - p.y + 0.5 * p.z; }

Part part_of(const Mesh& whole, int rank, const Rule& rule, bool triangles = true) {
  Part part;
  std::map<std::uint32_t, std::uint32_t> local;
  const auto local_of = [&](std::uint32_t v) {
    const auto [at, added] = local.try_emplace(v, static_cast<std::uint32_t>(part.ids.size()));
    if (added) {
      part.ids.push_back(id_of(v));
      part.mesh.points.push_back(whole.points[v]);
      part.mesh.point_refs.push_back(whole.point_refs[v]);
    }
    return at->second;
  };
  std::set<std::array<std::uint32_t, 3>> faces;
  for (std::size_t t = 0; t < whole.tets.size(); ++t) {
    if (rule(t) != rank) continue;
    std::array<std::uint32_t, 4> tet{};
    for (std::size_t i = 0; i < 4; ++i) tet[i] = local_of(whole.tets[t][i]);
    part.mesh.tets.push_back(tet);
    part.mesh.tet_refs.push_back(whole.tet_refs[t]);
    part.tet_ids.push_back(t);
  }
  const auto has = [&](std::uint32_t v) { return local.contains(v); };
  for (std::size_t t = 0; triangles && t < whole.triangles.size(); ++t) {
    const auto& [a, b, c] = whole.triangles[t];
    if (!has(a) || !has(b) || !has(c)) continue;
    part.mesh.triangles.push_back({local[a], local[b], local[c]});
    part.mesh.triangle_refs.push_back(whole.triangle_refs[t]);
  }
  for (std::size_t e = 0; triangles && e < whole.edges.size(); ++e) {
    const auto& [a, b] = whole.edges[e];
    if (!has(a) || !has(b)) continue;
    part.mesh.ridges.push_back(static_cast<std::uint32_t>(part.mesh.edges.size()));
    part.mesh.edges.push_back({local[a], local[b]});
    part.mesh.edge_refs.push_back(whole.edge_refs[e]);
  }
  for (const std::uint32_t v : whole.corners)
    if (triangles && has(v)) part.mesh.corners.push_back(local[v]);
  Field field{Field::Kind::scalar, {}, "linear"};
  for (const Point& p : part.mesh.points) field.values.push_back(linear(p));
  part.fields = {part.ids.size(), {field}};
  return part;
}

Metric metric_of(const Part& part) {
  std::vector<double> h;
  for (const Point& p : part.mesh.points) h.push_back(0.08 + 0.1 * p.x);
  return Metric::from_sizes(h);
}

/// A layer across the box.
double layer(const Point& x) { return std::tanh(20 * (x.x + 0.3 * x.y - 0.6)); }

Fields layer_of(const Mesh& mesh) {
  Fields fields{mesh.points.size(), {{Field::Kind::scalar, {}, "layer"}}};
  for (const Point& x : mesh.points) fields.fields[0].values.push_back(layer(x));
  return fields;
}

Options options_of(std::uint32_t subdomains = 6) {
  Options options;
  options.run.threads = 1;
  options.distributed.subdomains = subdomains;
  return options;
}

/// All own tets by the coordinates of their points, in ascending order, on all ranks: meshes that are equal
/// but for numbers and ranks give the same.
std::vector<double> shape_of(const PartResult& result, MPI_Comm communicator) {
  std::vector<std::array<double, 12>> tets;
  for (std::size_t t = 0; t < result.part.num_own_tets; ++t) {
    std::array<std::array<double, 3>, 4> points{};
    for (std::size_t i = 0; i < 4; ++i) {
      const Point& p = result.part.mesh.points[result.part.mesh.tets[t][i]];
      points[i] = {p.x, p.y, p.z};
    }
    std::sort(points.begin(), points.end());
    std::array<double, 12> flat{};
    for (std::size_t i = 0; i < 12; ++i) flat[i] = points[i / 3][i % 3];
    tets.push_back(flat);
  }
  int ranks = 1, count = static_cast<int>(12 * tets.size());
  MPI_Comm_size(communicator, &ranks);
  std::vector<int> counts(static_cast<std::size_t>(ranks)), starts(static_cast<std::size_t>(ranks));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, communicator);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<double> all(static_cast<std::size_t>(starts.back() + counts.back()));
  MPI_Allgatherv(tets.data(), count, MPI_DOUBLE, all.data(), counts.data(), starts.data(), MPI_DOUBLE,
                 communicator);
  auto* first = reinterpret_cast<std::array<double, 12>*>(all.data());
  std::sort(first, first + all.size() / 12);
  return all;
}

/// The rules that the tests spread the box by; the last rank of several is empty in the second.
Rule blocks(const Mesh& whole, int ranks) {
  return [n = whole.tets.size(), ranks](std::size_t t) {
    return static_cast<int>(t * static_cast<std::size_t>(ranks) / n);
  };
}
Rule dealt(int ranks) {
  return [ranks](std::size_t t) {
    return static_cast<int>(t % static_cast<std::size_t>(std::max(ranks - 1, 1)));
  };
}

/// What all ranks throw, which must be the same.
std::string common_error(const Split& split, const std::function<void()>& call) {
  std::string text;
  try {
    call();
  } catch (const InputError& error) {
    text = error.what();
  }
  std::array<char, 512> first{};
  std::snprintf(first.data(), first.size(), "%s", text.c_str());
  MPI_Bcast(first.data(), static_cast<int>(first.size()), MPI_CHAR, 0, split.communicator);
  EXPECT_EQ(text, first.data());
  return text;
}

TEST(Parts, GiveTheSameMeshHoweverTheyAreSpreadAndAsOneMeshInSubdomainsDoes) {
  const Split split;
  const Mesh whole = whole_box();
  const Part one = part_of(whole, split.rank, blocks(whole, split.ranks));
  const Part other = part_of(whole, split.rank, dealt(split.ranks));
  const auto expected =
      shape_of(adapt(split.communicator, one, metric_of(one), options_of()), split.communicator);
  const auto spread =
      shape_of(adapt(split.communicator, other, metric_of(other), options_of()), split.communicator);
  EXPECT_EQ(expected, spread);
  const Part all = part_of(whole, 0, [](std::size_t) { return 0; });
  Part same;
  same.mesh = whole;
  const Result in_memory = adapt(whole, metric_of(same), options_of());
  PartResult one_part;
  one_part.part.mesh = in_memory.mesh;
  one_part.part.num_own_tets = in_memory.mesh.tets.size();
  EXPECT_EQ(shape_of(one_part, MPI_COMM_SELF), expected);
  const PartResult alone = adapt(MPI_COMM_SELF, all, metric_of(all), options_of());
  EXPECT_EQ(shape_of(alone, MPI_COMM_SELF), expected);
}

TEST(Parts, ReadTheirMetricFromAnotherMeshInParts) {
  const Split split;
  const Mesh whole = whole_box();
  BoxOptions finer;
  finer.cells = {8, 7, 8};
  const Mesh background = box(finer);
  const Part one = part_of(whole, split.rank, blocks(whole, split.ranks));
  const Part other = part_of(background, split.rank, dealt(split.ranks));
  const PartResult fine = adapt(split.communicator, one, other, metric_of(other), options_of());
  EXPECT_FALSE(fine.before);
  const Part all = part_of(whole, 0, [](std::size_t) { return 0; });
  const Part all_other = part_of(background, 0, [](std::size_t) { return 0; });
  const PartResult alone = adapt(MPI_COMM_SELF, all, all_other, metric_of(all_other), options_of());
  EXPECT_EQ(shape_of(fine, split.communicator), shape_of(alone, MPI_COMM_SELF));
  Part same;
  same.mesh = background;
  const Result in_memory = adapt(whole, background, metric_of(same), options_of());
  EXPECT_EQ(12 * in_memory.mesh.tets.size(), shape_of(alone, MPI_COMM_SELF).size());
  EXPECT_GT(fine.after->edges_unit, 0.85);
  EXPECT_NE(common_error(split,
                         [&] {
                           Part bad = other;
                           bad.ids.pop_back();
                           adapt(split.communicator, one, bad, metric_of(other), options_of());
                         })
                .find("background"),
            std::string::npos);
}

TEST(Parts, MakeTheirMetricOfSolutionsOnAnotherMeshInParts) {
  const Split split;
  const Mesh whole = whole_box();
  BoxOptions finer;
  finer.cells = {7, 6, 7};
  const Mesh background = box(finer);
  const auto with = [](const Mesh& mesh) {
    Options options = options_of(8);
    options.metric.complexity = 700;
    if (!mesh.points.empty()) options.metric.solutions = {layer_of(mesh)};
    return options;
  };
  const Part one = part_of(whole, split.rank, dealt(split.ranks));
  const Part other = part_of(background, split.rank, blocks(background, split.ranks));
  const PartResult fine = adapt(split.communicator, one, other, with(other.mesh));
  const Part all = part_of(whole, 0, [](std::size_t) { return 0; });
  const Part all_other = part_of(background, 0, [](std::size_t) { return 0; });
  const PartResult alone = adapt(MPI_COMM_SELF, all, all_other, with(all_other.mesh));
  EXPECT_EQ(shape_of(fine, split.communicator), shape_of(alone, MPI_COMM_SELF));
  EXPECT_EQ(12 * adapt(whole, background, with(background)).mesh.tets.size(),
            shape_of(alone, MPI_COMM_SELF).size());
}

TEST(Parts, OfWhichSomeRanksAloneGiveABackgroundAreRefused) {
  const Split split;
  if (split.ranks == 1) return;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, dealt(split.ranks));
  const std::string text = common_error(split, [&] {
    if (split.rank == split.ranks - 1)
      adapt(split.communicator, part, metric_of(part), options_of());
    else
      adapt(split.communicator, part, part, metric_of(part), options_of());
  });
  EXPECT_NE(text.find("background: some ranks give one"), std::string::npos) << text;
}

TEST(Parts, ComeBackBalancedNumberedAndOwned) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, dealt(split.ranks));
  const PartResult fine = adapt(split.communicator, part, metric_of(part), options_of(24));
  const Part& p = fine.part;
  EXPECT_EQ(p.owners.size(), p.ids.size());
  EXPECT_EQ(p.mesh.points.size(), p.ids.size());
  EXPECT_EQ(p.num_own_tets, p.mesh.tets.size());
  const double mean = static_cast<double>(fine.after->num_tets) / split.ranks;
  EXPECT_LT(static_cast<double>(p.num_own_tets), 1.4 * mean);
  EXPECT_GT(static_cast<double>(p.num_own_tets), 0.6 * mean);
  std::uint64_t owned = 0, all = 0;
  for (const int owner : p.owners) owned += owner == split.rank;
  MPI_Allreduce(&owned, &all, 1, MPI_UINT64_T, MPI_SUM, split.communicator);
  EXPECT_EQ(all, fine.after->num_vertices);
  for (const std::uint64_t id : p.ids) EXPECT_LT(id, all);
}

TEST(Parts, CarryFieldsAlong) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, dealt(split.ranks));
  const PartResult fine = adapt(split.communicator, part, metric_of(part), options_of());
  ASSERT_EQ(fine.part.fields.fields.size(), 1u);
  for (std::size_t v = 0; v < fine.part.ids.size(); ++v)
    EXPECT_NEAR(fine.part.fields.fields[0].values[v], linear(fine.part.mesh.points[v]), 1e-9);
}

TEST(Parts, CarryFieldsAlongWithTheirIntegrals) {
  const Split split;
  const Mesh whole = whole_box();
  Part part = part_of(whole, split.rank, dealt(split.ranks));
  Field layer{Field::Kind::scalar, {}, "layer"}, flow{Field::Kind::vector, {}, "flow"};
  for (const Point& x : part.mesh.points) {
    layer.values.push_back(std::tanh(30 * (x.x - 0.4)));
    for (const double v : {x.y * x.z, std::sin(9 * x.x), 1.0}) flow.values.push_back(v);
  }
  part.fields = {part.ids.size(), {layer, flow}};
  if (part.ids.empty()) part.fields = {};  // need not list them
  Options options = options_of(8);
  options.distributed.ghosts = true;
  options.transfer = TransferMethod::conservative;
  const PartResult fine = adapt(split.communicator, part, metric_of(part), options);
  ASSERT_EQ(fine.part.fields.fields.size(), 2u);
  EXPECT_EQ(fine.part.fields.fields[0].name, "layer");
  EXPECT_EQ(fine.part.fields.fields[1].values.size(), 3 * fine.part.ids.size());
  ASSERT_EQ(fine.field_accounts.size(), 4u);
  for (const ComponentAccount& a : fine.field_accounts) {
    EXPECT_GT(a.absolute, 0);
    EXPECT_LE(std::abs(a.integral_after - a.integral_before), 1e-10 * a.absolute) << a.name;
  }
  for (std::size_t v = 0; v < fine.part.ids.size(); ++v) {
    EXPECT_LE(std::abs(fine.part.fields.fields[0].values[v]), 1.0);
    EXPECT_NEAR(fine.part.fields.fields[1].values[3 * v + 2], 1, 1e-9) << "constants stay";
  }
}

TEST(Parts, HaveGhostsOnRequest) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks));
  Options options = options_of(8);
  options.distributed.ghosts = true;
  const PartResult fine = adapt(split.communicator, part, metric_of(part), options);
  const Part& p = fine.part;
  EXPECT_EQ(p.ghost_owners.size(), p.mesh.tets.size() - p.num_own_tets);
  EXPECT_EQ(p.ghost_owners.empty(), split.ranks == 1);
  for (const int owner : p.ghost_owners) EXPECT_NE(owner, split.rank);
  // Around a vertex that lies inside the domain the tets, ghosts included, leave no solid angle open: every
  // face at an own vertex that one tet alone has is one of the boundary's triangles.
  std::map<std::array<std::uint32_t, 3>, int> faces;
  for (const auto& tet : p.mesh.tets)
    for (std::size_t f = 0; f < 4; ++f) {
      std::array<std::uint32_t, 3> face{};
      for (std::size_t i = 0, k = 0; i < 4; ++i)
        if (i != f) face[k++] = tet[i];
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  std::set<std::uint32_t> own;
  for (std::size_t t = 0; t < p.num_own_tets; ++t) own.insert(p.mesh.tets[t].begin(), p.mesh.tets[t].end());
  const auto on_box = [&](std::uint32_t v) {
    const Point& x = p.mesh.points[v];
    return std::array<bool, 6>{x.x == 0, x.x == 1, x.y == 0, x.y == 1, x.z == 0, x.z == 1};
  };
  for (const auto& [face, count] : faces) {
    if (count != 1 || !(own.contains(face[0]) || own.contains(face[1]) || own.contains(face[2]))) continue;
    bool together = false;
    for (std::size_t side = 0; side < 6; ++side)
      together |= on_box(face[0])[side] && on_box(face[1])[side] && on_box(face[2])[side];
    EXPECT_TRUE(together);
  }
}

TEST(Parts, WithoutTrianglesGetThose) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks), false);
  const PartResult fine = adapt(split.communicator, part, metric_of(part), options_of());
  EXPECT_FALSE(fine.warnings.empty());
  EXPECT_NEAR(fine.after->volume, 1, 1e-12);
}

TEST(Parts, MetricsThatAreGradedAreMadeOfTheWholeMesh) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks));
  Options options = options_of();
  options.metric.hgrad = 1.3;
  options.metric.complexity = 800;
  const PartResult fine = adapt(split.communicator, part, metric_of(part), options);
  EXPECT_NEAR(fine.after->complexity, 800, 120);
}

TEST(Parts, MetricsOfSolutionsAreThoseOfTheWholeMesh) {
  const Split split;
  const Mesh whole = whole_box();
  const auto with = [](const Mesh& mesh) {
    Options options = options_of(8);
    options.metric.complexity = 700;
    options.metric.hgrad = 1.5;
    if (!mesh.points.empty()) options.metric.solutions = {layer_of(mesh)};
    return options;
  };
  const Part part = part_of(whole, split.rank, dealt(split.ranks));
  const PartResult fine = adapt(split.communicator, part, with(part.mesh));
  const Part all = part_of(whole, 0, [](std::size_t) { return 0; });
  const PartResult alone = adapt(MPI_COMM_SELF, all, with(all.mesh));
  EXPECT_EQ(shape_of(fine, split.communicator), shape_of(alone, MPI_COMM_SELF));
  EXPECT_EQ(12 * adapt(whole, with(whole)).mesh.tets.size(), shape_of(alone, MPI_COMM_SELF).size());
  EXPECT_NEAR(fine.after->complexity, 700, 70);
}

TEST(Parts, WrongOnesAreRefusedOnAllRanksNamingRankAndEntity) {
  const Split split;
  const Mesh whole = whole_box();
  const int last = split.ranks - 1;
  const auto refused = [&](const std::function<void(Part&, Metric&)>& spoil, bool triangles = true) {
    Part part = part_of(whole, split.rank, blocks(whole, split.ranks), triangles);
    Metric metric = metric_of(part);
    if (split.rank == last) spoil(part, metric);
    return common_error(split, [&] { adapt(split.communicator, part, metric, options_of()); });
  };
  const std::string rank = "rank " + std::to_string(last) + ": ";
  const auto says = [&](const std::string& text, const std::string& what) {
    EXPECT_NE(text.find(what), std::string::npos) << text;
  };
  says(refused([](Part&, Metric& m) { m = Metric::from_sizes(std::vector<double>(3, 1.0)); }),
       rank + "metric of another mesh");
  says(refused([](Part& p, Metric&) { p.ids[1] = p.ids[0]; }), rank + "vertex id");
  says(refused([](Part& p, Metric&) { p.ids.pop_back(); }), rank + "list of ids");
  says(refused([](Part& p, Metric&) { p.mesh.tets[2][0] = 99999; }), rank);
  if (split.ranks > 1) {  // one rank may call its vertices what it likes
    says(refused([](Part& p, Metric&) { p.ids[0] = 77777777; }), "a hole between");
    says(refused([](Part& p, Metric&) { p.ids[0] = 77777777; }, false), "a hole between");
    says(refused([](Part& p, Metric&) { p.tet_ids[0] = 0; }), "is on rank");
    says(refused([&](Part& p, Metric&) {
           for (std::size_t v = 0; v < p.ids.size(); ++v) p.mesh.points[v].x += 1e-3;
         }),
         "is another point than on rank");
  }
}

TEST(Parts, OptionsThatDifferBetweenRanksAreRefusedOnAllNamingRankAndOption) {
  const Split split;
  if (split.ranks == 1) return;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks), true);
  const int last = split.ranks - 1;
  const auto refused = [&](const std::function<void(Options&)>& change) {
    Options options = options_of();
    if (split.rank == last) change(options);
    return common_error(split, [&] { adapt(split.communicator, part, metric_of(part), options); });
  };
  const std::string rank = "rank " + std::to_string(last) + ": options differ: ";
  for (const auto& [name, value] : {std::pair{"subdomains", "7"},
                                    {"layers", "3"},
                                    {"hgrad", "1.7"},
                                    {"partitioner", "bisection"},
                                    {"balancer", "none"},
                                    {"ghosts", "yes"},
                                    {"no-verify", "yes"},
                                    {"measure", "no"},
                                    {"complexity", "900"},
                                    {"hgrad-space", "mixed"}}) {
    const std::string told = refused([&](Options& o) { set_option(o, name, value); });
    EXPECT_NE(told.find(rank + "--" + name + " " + value), std::string::npos) << told;
  }
  // A value that makes no sense on one rank ends the call on the others too.
  Options senseless = options_of();
  if (split.rank == last) senseless.metric.complexity = -1;
  EXPECT_ANY_THROW(adapt(split.communicator, part, metric_of(part), senseless));
  EXPECT_NO_THROW(adapt(split.communicator, part, metric_of(part), options_of()));
}

TEST(Parts, OfWhichSomeRanksAloneGiveAMetricAreRefused) {
  const Split split;
  if (split.ranks == 1) return;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks), true);
  Options options = options_of();
  options.metric.implied = true;
  const std::string told = common_error(split, [&] {
    if (split.rank == 0)
      adapt(split.communicator, part, options);
    else
      adapt(split.communicator, part, metric_of(part), options);
  });
  EXPECT_NE(told.find("metric: some ranks give one"), std::string::npos) << told;
}

TEST(Parts, HaveMetricAndSolutionsTogetherWhereOneRankHasAll) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, [](std::size_t) { return 0; });
  Options options = options_of(8);
  options.metric.complexity = 700;
  if (!part.mesh.points.empty()) options.metric.solutions = {layer_of(part.mesh)};
  const PartResult fine = adapt(split.communicator, part, metric_of(part), options);
  const Part all = part_of(whole, 0, [](std::size_t) { return 0; });
  options.metric.solutions = {layer_of(all.mesh)};
  EXPECT_EQ(shape_of(fine, split.communicator),
            shape_of(adapt(MPI_COMM_SELF, all, metric_of(all), options), MPI_COMM_SELF));
}

TEST(Parts, OfWhichOneRankHasPointsAndNoFieldsAreRefused) {
  const Split split;
  const Mesh whole = whole_box();
  Part part = part_of(whole, split.rank, blocks(whole, split.ranks));
  if (split.rank == split.ranks - 1) part.fields = {};
  const std::string error =
      common_error(split, [&] { adapt(split.communicator, part, metric_of(part), options_of()); });
  EXPECT_EQ(error.find("not of the same number and kinds") != std::string::npos, split.ranks > 1) << error;
}

TEST(Parts, WrongSolutionsAreRefusedOnAllRanks) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks));
  const int last = split.ranks - 1;
  const auto refused = [&](const std::function<void(std::vector<Fields>&)>& spoil) {
    Options options = options_of(8);
    options.metric.complexity = 700;
    options.metric.solutions = {layer_of(part.mesh)};
    if (split.rank == last) spoil(options.metric.solutions);
    return common_error(split, [&] { adapt(split.communicator, part, options); });
  };
  const std::string rank = "rank " + std::to_string(last) + ": ";
  const auto says = [](const std::string& text, const std::string& what) {
    EXPECT_NE(text.find(what), std::string::npos) << text;
  };
  says(refused([](auto& s) { s[0].fields[0].values[3] = std::nan(""); }), rank);
  says(refused([](auto& s) { s[0].fields[0].kind = Field::Kind::vector; }), rank);
  says(refused([](auto& s) { s[0].fields.clear(); }), rank + "solutions: holds no scalar field");
  says(common_error(split, [&] { adapt(split.communicator, part, options_of(8)); }), "no metric is given");
  if (split.ranks == 1) return;
  says(refused([](auto& s) { s.push_back(s[0]); }), "of the same number of scalar fields");
  says(refused([](auto& s) {
         for (double& value : s[0].fields[0].values) value += 1;
       }),
       "different values of a solution");
  const std::string text = common_error(split, [&] {
    if (split.rank == last)
      adapt(split.communicator, part, metric_of(part), options_of(8));
    else
      adapt(split.communicator, part, options_of(8));
  });
  says(text, "some ranks give one");
}

TEST(Parts, ProgressIsToldOnTheFirstRankAlone) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks));
  int calls = 0;
  Options options = options_of();
  options.run.progress = [&](const Progress&) { return ++calls > 0; };
  adapt(split.communicator, part, metric_of(part), options);
  EXPECT_EQ(calls > 0, split.rank == 0);
}

TEST(Parts, CancelEndsWithAValidMesh) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks));
  std::atomic<bool> cancel = true;
  Options options = options_of();
  options.run.cancel = &cancel;
  const PartResult result = adapt(split.communicator, part, metric_of(part), options);
  EXPECT_TRUE(result.cancelled);
  EXPECT_NEAR(result.after->volume, 1, 1e-12);
}

TEST(Parts, CancelOfOneRankEndsTheRunAndSetsNoFlagOfAnother) {
  const Split split;
  const Mesh whole = whole_box();
  const Part part = part_of(whole, split.rank, blocks(whole, split.ranks));
  std::atomic<bool> cancel = split.rank == 0;
  Options options = options_of();
  options.run.cancel = &cancel;
  EXPECT_TRUE(adapt(split.communicator, part, metric_of(part), options).cancelled);
  EXPECT_EQ(cancel, split.rank == 0);
}

}  // namespace
}  // namespace weft

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  MPI_Init(&argc, &argv);  // plain, as many programs do
  const int mine = RUN_ALL_TESTS();
  int finalized = 0, worst = 0;
  MPI_Finalized(&finalized);
  if (finalized) return 3;  // it is the program's own
  MPI_Allreduce(&mine, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return worst;
}
