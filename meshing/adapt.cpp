// The driver: the order of operations of the paper's requirement 6 over work lists.
#include "meshing/adapt.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <ctime>
static double env(const char* n, double d) { const char* e = getenv(n); return e ? atof(e) : d; }  // DEBUG

#include "meshing/box.h"
#include "meshing/import_mesh.h"
#include "meshing/passes.h"
#include "meshing/renumber.h"

namespace weft::meshing {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

/// One adaptation from the first mark to the last improvement.
class Adaptation {
 public:
  Adaptation(Kernel& kernel, const AdaptOptions& options, AdaptReport& report)
      : kernel_(kernel), mesh_(kernel.mesh), crew_(kernel, std::max(1, options.threads), options.interrupt),
        options_(options), report_(report) {}

  void run() {
    mark_all(kAllTetMarks, kAllVertexMarks);
    judge_by(env("LOGM", 1) > 0 ? MetricMean::log_euclidean : MetricMean::arithmetic);
    stage("collapse", [&] { repeat(5, 0.01, [&] { return collapse_pass(crew_); }); });
    stage("create points", [&] { create_points(); });
    stage("reconnect and smooth", [&] { optimise(); });
    stage("improve", [&] { improve_quality(); });
    crew_.run([&] { renumber(); });
    report_.interrupted = crew_.interrupted();
  }

 private:
  template <class F>
  void stage(const char* name, F f) {
    if (crew_.interrupted()) return;
    const auto start = Clock::now(); const double cpu = clock() * 1e-6;
    f();
    StageReport s;
    s.name = name;
    s.seconds = seconds_since(start);
    s.counts = crew_.take_counts();
    report_.counts += s.counts;
    report_.stages.push_back(s);
    if (getenv("WEFT_DEBUG")) fprintf(stderr, "%-24s %.2f s\n", name, s.seconds);
  }

  template <class F>
  std::uint64_t pass(const char* name, F f) {
    const double start = clock() * 1e-6;
    const std::uint64_t n = f();
    if (getenv("WEFT_DEBUG")) fprintf(stderr, "  %-12s %9lu  %.2f s  slots %u\n", name, n, clock() * 1e-6 - start, mesh_.tet_slots());
    if (getenv("WEFT_DEBUG2")) { std::vector<float> q; double sum=0; for (std::uint32_t i=0;i<mesh_.tet_slots();++i) if (mesh_.alive(TetId(i))) {q.push_back(mesh_.quality(TetId(i))); sum+=q.back();} std::sort(q.begin(),q.end()); fprintf(stderr,"     nt %zu mean %.4f 1%% %.4f min %.4f\n",q.size(),sum/q.size(),q[q.size()/100],q[0]); }
    if (getenv("DUPES")) { std::vector<std::array<std::uint32_t,4>> f; for (std::uint32_t i=0;i<mesh_.tet_slots();++i) if (mesh_.alive(TetId(i))) { auto v=mesh_.vertices(TetId(i)); for (auto&k:kTetFaces) { std::array<std::uint32_t,3> a{v[k[0]].value,v[k[1]].value,v[k[2]].value}; std::sort(a.begin(),a.end()); f.push_back({a[0],a[1],a[2],i}); } } std::sort(f.begin(),f.end()); int bad=0; for (size_t i=2;i<f.size();++i) if (f[i][0]==f[i-2][0]&&f[i][1]==f[i-2][1]&&f[i][2]==f[i-2][2]) { if(!bad) { fprintf(stderr,"dup face %u %u %u:",f[i][0],f[i][1],f[i][2]); for (int k=0;k<3;++k) {fprintf(stderr," k%d(%.5f %.5f %.5f)",(int)mesh_.kind(VertexId(f[i][k])),mesh_.point(VertexId(f[i][k])).x,mesh_.point(VertexId(f[i][k])).y,mesh_.point(VertexId(f[i][k])).z);} for (int k=0;k<3;++k) { TetId t(f[i-k][3]); auto v=mesh_.vertices(t); fprintf(stderr,"\n  tet %u:",t.value); for (int m=0;m<4;++m) fprintf(stderr," %u(k%d n%d p%d)",v[m].value,(int)mesh_.kind(v[m]),mesh_.neighbour(t,m).valid()?(int)mesh_.neighbour(t,m).tet().value:-1,(int)mesh_.patch(t,m).value); } fprintf(stderr,"\n"); } ++bad; } if (bad) {fprintf(stderr,"%s: %d dup\n",name,bad); exit(1);} }
    return n;
  }

  template <class F>
  void repeat(int most, double share, F f) {
    std::uint64_t first = 0;
    for (int i = 0; i < most && !crew_.interrupted(); ++i) {
      const std::uint64_t n = pass("repeat", f);
      if (i == 0) first = n;
      if (n == 0 || static_cast<double>(n) < share * static_cast<double>(first)) return;
    }
  }

  /// Longest edges first: levels of twice the wanted size and more come before it, each with its points well spread, so that a
  /// mesh that is far too coarse in one direction never becomes a heap of needles.
  void create_points() {
    const Limits wanted = kernel_.limits;
    std::uint32_t renumbered_at = mesh_.tet_slots();
    for (double level = first_level(); level >= 1 && !crew_.interrupted(); level *= 0.5) {
      kernel_.limits.long_edge = wanted.long_edge * level;
      kernel_.limits.split_shortest = wanted.split_shortest * level;
      kernel_.limits.collapse_longest = wanted.collapse_longest * level;
      mark_all(kCheckLong, 0);
      if (getenv("WEFT_DEBUG")) fprintf(stderr, " level %g\n", level);
      for (int i = 0; i < 10 && !crew_.interrupted(); ++i) {
        const std::uint64_t n = pass("split", [&] { return split_pass(crew_, kernel_.limits.long_edge); });
        if (n * 50 < mesh_.tet_slots()) break;
        pass("collapse", [&] { return collapse_pass(crew_); });
        pass("swap", [&] { return swap_pass(crew_, env("SQ0", 0.5)); });
        pass("smooth", [&] { return smooth_pass(crew_); });
        pass("collapse", [&] { return collapse_pass(crew_); });
        if (getenv("IMP")) pass("improve", [&] { return improve_pass(crew_, env("IMP", 0.1)); });
        if (getenv("DUMP")) { std::vector<std::pair<float,std::uint32_t>> q; for (std::uint32_t i=0;i<mesh_.tet_slots();++i) if (mesh_.alive(TetId(i))) q.push_back({mesh_.quality(TetId(i)),i}); std::sort(q.begin(),q.end());
          if (q[0].first < 1e-4) { for (int k=0;k<30;++k) { TetId t(q[k*3].second); auto v=mesh_.vertices(t); fprintf(stderr,"q %g ",q[k*3].first); for (auto x:v) fprintf(stderr,"[%u k%d %.5f %.5f %.5f r %.5f]",x.value,(int)mesh_.kind(x),mesh_.point(x).x,mesh_.point(x).y,mesh_.point(x).z,std::hypot(mesh_.point(x).x,mesh_.point(x).y)); fprintf(stderr," L"); for (auto&e:kTetEdges) fprintf(stderr," %.2f",length_between(mesh_,v[e[0]],v[e[1]])); fprintf(stderr,"\n"); } exit(1);} }
        if (mesh_.tet_slots() > 2 * renumbered_at) {
          crew_.run([&] { renumber(); });
          renumbered_at = mesh_.tet_slots();
        }
      }
    }
    kernel_.limits = wanted;
  }

  /// The power of two that makes the longest edge at most long at the first level.
  double first_level() const {
    double longest = 1;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i) {
      if (!mesh_.alive(TetId(i))) continue;
      const TetVertices v = mesh_.vertices(TetId(i));
      for (const auto& e : kTetEdges) longest = std::max(longest, length_between(mesh_, v[e[0]], v[e[1]]));
    }
    return std::exp2(std::max(0.0, std::floor(std::log2(longest / kernel_.limits.long_edge))));
  }

  /// Switches the judges' mean and brings all cached qualities up to date.
  void judge_by(MetricMean mean) {
    mesh_.set_metric_mean(mean);
    crew_.run([&] {
      tbb::parallel_for(0u, mesh_.tet_slots(), [&](std::uint32_t i) {
        if (!mesh_.alive(TetId(i))) return;
        const TetVertices v = mesh_.vertices(TetId(i));
        mesh_.set_quality(TetId(i), static_cast<float>(judge_quality(mesh_, v[0], v[1], v[2], v[3])));
      });
    });
  }

  void mark_all(std::uint8_t tet_marks, std::uint8_t vertex_marks) {
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i)
      if (mesh_.alive(TetId(i))) mesh_.mark(TetId(i), tet_marks);
    for (std::uint32_t i = 0; i < mesh_.vertex_slots(); ++i)
      if (mesh_.alive(VertexId(i))) mesh_.mark(VertexId(i), vertex_marks);
  }

  void optimise() {
    pass("renumber", [&] { crew_.run([&] { renumber(); }); return 0; });
    for (int i = 0; i < env("N1", 4) && !crew_.interrupted(); ++i) {
      pass("swap", [&] { return swap_pass(crew_, env("SQ", 0.8)); });
      pass("smooth", [&] { return smooth_pass(crew_); });
      pass("collapse", [&] { return collapse_pass(crew_); });
      pass("split", [&] { return split_pass(crew_, kernel_.limits.long_edge); });
    }
    for (int i = 0; i < env("N2", 3) && !crew_.interrupted(); ++i) {
      pass("swap", [&] { return swap_pass(crew_, env("SQ2", 0.8)); });
      pass("smooth", [&] { return smooth_pass(crew_); });
    }
  }

  void improve_quality() {
    for (int i = 0; i < 5 && !crew_.interrupted(); ++i)
      if (pass("improve", [&] { return improve_pass(crew_, 0.4); }) == 0) break;
  }

  void renumber() {
    renumber_along_curve(mesh_);
    crew_.forget_free_slots();
  }

  Kernel& kernel_;
  TetMesh& mesh_;
  Crew crew_;
  const AdaptOptions& options_;
  AdaptReport& report_;
};

double bounding_box_diagonal(const MeshData& m) {
  Box box;
  for (const Point& p : m.points) box.include(p);
  return norm(box.size());
}

}  // namespace

AdaptResult adapt(const MeshData& input, const BackgroundData& background_data, const AdaptOptions& options) {
  const auto start = Clock::now();
  AdaptResult result;
  ImportedMesh imported = import_mesh(input, options.ridge_angle_degrees, std::size_t{1} << 28, std::size_t{1} << 30);
  result.report.warnings = std::move(imported.warnings);
  const Background background(*background_data.mesh, *background_data.log_metrics);
  read_metric(*imported.mesh, background, background_data.mesh == &input);
  Kernel kernel{*imported.mesh, background, *imported.surface, {}};
  kernel.limits.hausd = options.hausd > 0 ? options.hausd : 0.01 * bounding_box_diagonal(input);
  kernel.limits.split_shortest = env("SS", 0.5); kernel.limits.shortest_step = env("ST", 0.03); kernel.limits.far_step = env("FS", 0.1); kernel.limits.collapse_longest = env("CL", 1.4142); kernel.limits.collapse_quality = env("CQ", 0.3);
  if (getenv("WEFT_DEBUG")) fprintf(stderr, "import %.2f s\n", seconds_since(start));
  Adaptation(kernel, options, result.report).run();
  export_mesh(*imported.mesh, *imported.surface, imported.patch_required, result.mesh, result.log_metrics);
  result.report.seconds = seconds_since(start);
  return result;
}

}  // namespace weft::meshing
