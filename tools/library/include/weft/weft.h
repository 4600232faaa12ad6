// weft adapts tetrahedral meshes to anisotropic metric fields. This is the interface of the library; beside
// it on_ranks.h has what the command does with files on all ranks, and replay.h simulated replays of runs.
// What the `weft` command can do, a program can do through these functions, because the command itself calls
// nothing else.
//
//   weft::Mesh mesh = weft::read_mesh("wing.meshb");
//   weft::Options options;
//   options.metric.complexity = 500000;
//   weft::Result fine = weft::adapt(mesh, weft::read_metric("wing.solb", mesh), options);
//   weft::write_mesh("fine.meshb", fine.mesh);
//
// The library prints nothing, handles no signals and never ends the process (but see adapt_files()). Errors
// are exceptions: InputError for data that cannot be used (it names file, entity and reason), OptionError for
// options that make no sense; in a run on several ranks all ranks throw alike. Functions may be called from
// several threads at the same time, each on data of its own. With one thread the same input gives the same
// bytes.
#pragma once

#include <mpi.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "weft/data.h"

namespace weft {

namespace engine {
struct RunSummary;
}

/// The library's version, such as "0.1.0".
WEFT_API const char* version();
/// `weft X.Y.Z`, then a line for the compiler, each library, the processor and the assertions; no line end
/// after the last.
WEFT_API std::string version_details();

/// An option that makes no sense, or contradicts another. what() reads "--hmin: is larger than --hmax".
class WEFT_API OptionError : public std::invalid_argument {
 public:
  /// `option`: as the command calls it, such as "--hmin".
  OptionError(const std::string& option, const std::string& reason);
  const std::string& option() const { return option_; }
  const std::string& reason() const { return reason_; }

 private:
  std::string option_, reason_;
};

/// A run on several ranks that came to no end: a rank died, or something failed on one of them. Thrown on all
/// that live.
class WEFT_API RunError : public std::runtime_error {
 public:
  explicit RunError(const std::string& what, bool reported = false)
      : std::runtime_error(what), reported_(reported) {}
  /// Whether the run itself came to know of it, and told one rank's on_failure; not where MPI fails before it
  /// begins or after it has ended.
  bool reported() const { return reported_; }

 private:
  bool reported_;
};

// ---------------------------------------------------------------------------------------------------------------
// Metrics

/// A metric at every vertex of a mesh: symmetric positive definite tensors in which edges of the wanted size
/// and direction have length 1. Kept as logarithms, the form in which metrics are averaged, scaled and
/// interpolated, so that a metric that is passed on keeps its bits.
class WEFT_API Metric {
 public:
  Metric() = default;
  /// Of tensors m11 m12 m22 m13 m23 m33. Throws InputError naming the vertex (1-based) where one is not
  /// positive definite or not finite.
  static Metric from_tensors(std::span<const Tensor> tensors);
  /// Of wanted sizes h, the same in all directions: h^-2 times the unit tensor.
  static Metric from_sizes(std::span<const double> sizes);
  /// Of the first tensor or scalar (size) field that was read from `file`, for a mesh of `num_points`
  /// vertices.
  static Metric from_fields(const Fields& fields, std::size_t num_points, const std::string& file = {});
  /// Of matrix logarithms.
  static Metric from_logarithms(std::vector<Tensor> logarithms);

  std::size_t size() const { return logarithms_.size(); }
  bool empty() const { return logarithms_.empty(); }
  Tensor tensor(std::size_t vertex) const;
  const std::vector<Tensor>& logarithms() const { return logarithms_; }
  /// A tensor field, to write.
  Fields fields() const;

 private:
  std::vector<Tensor> logarithms_;
};

// ---------------------------------------------------------------------------------------------------------------
// Options: named as those of the command, whose --help describes them too

/// The boundary.
struct GeometryOptions {
  double ridge_angle = meshing::kRidgeAngle;  ///< degrees; boundary edges sharper than this are kept
  /// Largest distance to the surface; 0: 0.1 % of the bounding box diagonal, and on a CAD model at most what
  /// a face's size and curvature bear.
  double hausd = 0;
  /// Where the boundary is curved, edges must be short to stay as near as that. Is the metric made as fine
  /// there? Otherwise it is taken as it is, and those edges are shorter than it asks for: poor tets where
  /// they are much shorter. Not where the metric belongs to a background.
  bool limit_metric = true;  ///< false: --no-surface-limit
  /// A CAD model that the boundary lies on: .step, .stp, .iges, .igs, .brep, .egads. Empty: the surface is
  /// reconstructed from the input's triangles. "carried": the model that the mesh file carries (ByteFlow).
  std::string model;
  double model_scale = 1;  ///< the model's lengths are multiplied by this: --geometry-scale
};

/// Where a metric comes from and what is done to it. Sources are intersected with each other (and with the
/// metric that adapt() is given), scaled together so that the metric has the wanted complexity in the end,
/// made as fine as the boundary's demands, limited and graded.
struct MetricOptions {
  // Sources.
  std::string file;               ///< --metric
  std::string function;           ///< --metric-fn: polar-1, polar-2, linear, uniform:H
  std::vector<std::string> sol;   ///< files of solutions to resolve: all their scalar fields
  std::vector<Fields> solutions;  ///< the same, in memory: at the vertices of the mesh, or of the part
  double norm = 2;                ///< p of the Lp norm of the interpolation error
  HessianRecovery recovery = HessianRecovery::least_squares;
  bool implied = false;  ///< the metric in which the input mesh is unit
  // Demands of the boundary, which are not scaled where there is a source too.
  double curvature = 0;  ///< edges per full turn of curvature; 0: none
  double sagitta = 0;    ///< distance of an edge's middle from the surface; 0: any
  WallOptions wall;      ///< --wall, --wall-height, --wall-growth, --wall-size
  // Processing.
  double complexity = 0;  ///< wanted; 0: as the metric is
  /// Smallest and largest size; 0: none, but for solutions, whose metric has no size above the diagonal of
  /// the mesh's bounding box.
  double hmin = 0, hmax = 0;
  double aspect = 0;  ///< largest ratio of sizes at a vertex; 0: none
  double hgrad = 0;   ///< largest growth of sizes per unit edge; <= 1: none
  GradationSpace hgrad_space = GradationSpace::metric;

  /// Whether any source or demand is given.
  WEFT_API bool given() const;
};

/// How far a run is.
struct Progress {
  std::string stage;       ///< "collapse", "measuring", or for subdomains a sentence with counts and times
  bool sentence = false;   ///< `stage` is such a sentence
  double done = 0;         ///< predicted share of the run's time, 0 to 1; of a sentence: of its step's work
  std::uint64_t tets = 0;  ///< now; 0: not known
};

struct RunOptions {
  int threads = 0;  ///< of this process or rank; 0: all cores, one for a run on several ranks
  /// Called on the calling thread of rank 0, a few times a second. Returning false cancels: the run ends soon
  /// with the valid mesh that it has.
  std::function<bool(const Progress&)> progress;
  /// The same from elsewhere: set (on all ranks) by another thread or a signal handler. It is only read, so
  /// that it serves the next run too. Must outlive the call.
  std::atomic<bool>* cancel = nullptr;
  /// Seconds from the beginning of the call after which the run is to have ended with the best valid mesh
  /// that it has by then, written (goal missed: Report::cancelled); 0: none. The first rank's clock counts.
  double time_limit = 0;
  /// Bytes that this process, or each rank, may take; 0: what the machine, its control groups and ulimit
  /// leave. A run that is predicted to need more is refused; one that comes near it ends with the valid mesh
  /// that it has.
  double max_memory = 0;
  /// Mend what can be mended of an imperfect input instead of refusing it: see repair(). What was done is in
  /// Report::mends.
  bool repair = false;
  bool force = false;  ///< run even if the memory seems insufficient, or the mesh fits its metric already
  bool check = false;  ///< check the invariants of all subdomains after every round: slow
  /// Check that the result conforms before it is given away, by a sum over all faces (less than a hundredth
  /// of the time). RunError names what is wrong: a fault of weft, not of the input.
  bool verify = true;
  bool measure = true;  ///< measure before the result is given away; see Report::after
  /// SIGUSR1 makes every rank tell on_state what it does. The command's; a library handles no signals else.
  bool state_on_signal = false;
  std::function<void(const std::string&)> on_state;
  /// Called on one rank, from another thread, as soon as it is certain that a run on several ranks fails, and
  /// why: what the others are doing may keep RunError from being thrown for a while.
  std::function<void(const std::string&)> on_failure;
};

/// Checkpoints, written while the run works on. Of a run in subdomains: a state of all of them that belongs
/// together, by all ranks. Of one mesh: its state between two passes. A folder keeps the two latest; one that
/// is not complete is never taken for one that is.
struct CheckpointOptions {
  std::string folder;  ///< on a file system that all ranks see; empty: no checkpoints
  /// Seconds between the end of one and the next, at most: the first comes after 10, the next after 20, 40
  /// ... 0: only when asked for.
  double every = 600;
  /// A folder of checkpoints: the run goes on from the latest that is not damaged, on as many ranks and
  /// threads as there are now.
  /// Input and options must be those of the run that wrote it. A folder without one: it starts anew.
  std::string resume;
  /// Asks for one now; set back when it begins. From any thread or signal handler of any rank.
  std::atomic<bool>* now = nullptr;
};

/// Adaptation in subdomains, on the threads of one process or on many ranks.
struct DistributedOptions {
  enum class Equal { work, tets };
  enum class LayersBy { points, faces };
  enum class Freeze { vertices, tets };

  std::uint32_t subdomains = 0;  ///< 0: one mesh in one process, 4 for each thread on several ranks
  /// graph (default), bisection, or slabs: pqr:PxQxR[:COORDINATE][:principal][:fewer], COORDINATE being
  /// harmonic=A,B (0 on triangles of reference A, 1 on those of B, harmonic between) or wall=A,... (distance
  /// from triangles of these references): what the P slabs are cut along
  std::string partitioner;
  Equal equal = Equal::work;  ///< what parts have equally of: predicted work or tets of the input
  std::optional<int> layers;  ///< of tets handed over in every shift; empty: 2 in the first, then 1
  LayersBy layers_by = LayersBy::points;
  std::optional<std::uint32_t> shifts;  ///< at most; empty: until all the interface has been free, at most 12
  std::string balancer = "stealing";    ///< stealing, diffusion, none
  Freeze freeze = Freeze::vertices;     ///< what is frozen at an interface; tets as in the paper
  bool interface_refinement = true;     ///< before what it bounds is adapted; not where swaps are off
  bool ghosts = false;                  ///< results in parts get a layer of ghost tets

  /// Whether a run in one process works in subdomains.
  bool asked() const { return subdomains > 0 || !partitioner.empty(); }
};

struct Options {
  GeometryOptions geometry;
  MetricOptions metric;
  AllowedOperations allowed;                         ///< --no-insert, --no-swap, --no-move
  TransferMethod transfer = TransferMethod::linear;  ///< of the fields that are carried along
  RunOptions run;
  DistributedOptions distributed;
  CheckpointOptions checkpoint;
};

/// Throws OptionError for the first option that makes no sense. All functions call it themselves.
WEFT_API void validate(const Options& options);

/// An option by its name, for languages that have no use for the members above.
struct NamedOption {
  std::string name;  ///< as the command has it, without dashes: "hgrad-space"
  std::string
      type;  ///< number, whole number, size, yes or no, text, texts, whole numbers, or the words it may be
  std::string text;  ///< what it is
  bool of_command;   ///< `weft adapt` has it too
};
/// All of them.
WEFT_API const std::vector<NamedOption>& named_options();
/// Sets an option by its name ('_' stands for '-') to the value that `text` means: as on the command line;
/// several values with commas between them; yes, no, true, false, 1 or 0. A file of --sol is added to those
/// before. Throws OptionError for a name that none has and a text that means no value; which values make
/// sense is what validate() says.
WEFT_API void set_option(Options& options, const std::string& name, const std::string& text);
/// The text of the value that an option has, as set_option() takes it (files of --sol with commas between
/// them). Texts are equal where values are.
WEFT_API std::string get_option(const Options& options, const std::string& name);

// ---------------------------------------------------------------------------------------------------------------
// What is known of a run

struct MeshCounts {
  std::uint64_t vertices = 0, tets = 0, triangles = 0, edges = 0;
};

struct StageTimes {
  double read = 0, metric = 0, decompose = 0, adapt = 0, measure = 0, fields = 0, write = 0, total = 0;
  double measure_input = 0;  ///< of `measure`, what was before the adaptation
};

/// What an adaptation to a complexity is expected to end with.
struct SizePrediction {
  double vertices = 0, tets = 0, bytes = 0;
};

/// Seconds of all workers in one operation of the distributed method.
struct OperationTime {
  std::string name;
  double seconds = 0;
};

struct RankStats {
  int rank = 0;
  std::vector<OperationTime> operations;
};

/// What has been written to go on from, and what it cost.
struct CheckpointStats {
  std::uint32_t written = 0;  ///< complete
  double bytes = 0;           ///< of the latest
  double seconds = 0;         ///< of all workers, spent on copying states
  std::string resumed;        ///< the checkpoint that the run went on from; empty: it began anew
  std::string failure;        ///< why the latest could not be written; empty: it could
};

/// One kind of mend of an input, and what it was done to.
struct Mend {
  std::string what;                     ///< "duplicate vertices merged"
  std::string entity;                   ///< "vertex": what `examples` number
  std::uint64_t count = 0;              ///< how many
  std::vector<std::uint64_t> examples;  ///< the first of them, 1-based in the input
  double amount = 0;                    ///< the largest change, by what `unit` says
  std::string unit;                     ///< "distance moved", "volume removed"; empty: there is no amount
};

/// One round of shifts over all subdomains.
struct ShiftStats {
  std::uint64_t round = 0;
  std::uint64_t wanted = 0;     ///< interface vertices to be freed, once for each subdomain that has them
  std::uint64_t moved = 0;      ///< tets
  std::uint64_t receivers = 0;  ///< subdomains that received any
  std::uint64_t thawed = 0;     ///< copies of vertices that are no longer interface
};

/// What ranks send each other in one part of a run.
struct ExchangeStats {
  double messages = 0, peers = 0;                   ///< of a rank, on average: sent; others it talks with
  std::uint64_t most_messages = 0, most_peers = 0;  ///< of any rank
};

struct DistributedStats {
  std::uint32_t subdomains = 0;
  int ranks = 1;
  std::string partitioner;
  int layers = 0;
  std::uint32_t checks = 0;  ///< of all invariants; 0: not asked for
  double decomposition_seconds = 0, adaptation_seconds = 0;
  std::uint32_t coarse_shifts = 0;  ///< of `shifts`, those of phases to coarser metrics
  std::uint32_t divided_from = 0;   ///< subdomains that had tets at first, and were divided; 0: none were
  std::uint64_t division = 0;       ///< the round of `shifts` in which they were
  std::vector<ShiftStats> shifts;
  std::vector<RankStats> by_rank;                                      ///< where a report was asked for
  std::vector<OperationTime> sum;                                      ///< of all ranks
  ExchangeStats exchanged_before, exchanged_in_loop, exchanged_after;  ///< the loop of adaptation and shifts
  double beside_adaptation = 0;  ///< share of the busy time that is not spent adapting
  Measures former_interface;     ///< tets with a vertex that has been one of an interface
  std::uint64_t messages = 0, bytes = 0, collective_calls = 0;  ///< within the loop
  std::string verdict;                                          ///< on the balance of the load
  CheckpointStats checkpoints;
  std::shared_ptr<const engine::RunSummary> engine;  ///< for the library's own reports
};

/// Everything that is known after an adaptation; the summary and the report are made from it. On several
/// ranks it is complete on rank 0, and the measures on all.
struct Report {
  std::optional<Measures> before;  ///< empty when the metric belongs to another mesh than the input
  /// Of the result. Empty where it was not measured: RunOptions::measure is off, or adapt() of a whole mesh
  /// was ended early and gave what it had at once. measures() takes them then.
  std::optional<Measures> after;
  /// Set where the mesh fitted its metric already, in all its parts, and so is the result as it was given.
  /// With a background of its own, on a CAD model, or where something of its boundary is to be completed, a
  /// mesh is adapted in any case, and so is one of less than 8,192 tets, or with RunOptions::force.
  std::optional<MetricFit> left_as_is;
  MeshCounts input_counts, output_counts;
  double target_complexity = 0;  ///< that was asked for, else that of the metric on its mesh
  bool complexity_asked = false;
  SizePrediction predicted;
  bool cancelled = false;
  /// Of a cancelled run: "interrupted", "time limit", "memory limit", or "out of memory" where an allocation
  /// failed.
  std::string ended_by;
  std::vector<Mend> mends;            ///< of the input (RunOptions::repair)
  std::vector<std::string> missed;    ///< why the goal was not met, as far as that is known without measures
  std::vector<std::string> warnings;  ///< such as boundary triangles that were missing and have been created
  std::vector<StageReport> stages;    ///< of one mesh
  OperationCounts operations;
  double surface_deviation = 0;  ///< largest distance of a boundary triangle's centroid to the surface; 0
                                 ///< where the mesh was left as it is
  double hausd = 0;              ///< the distance that was wanted at most
  SurfaceLimit surface_limit;    ///< what GeometryOptions::limit_metric has done
  /// Of one mesh: where the surface needs shorter edges than the metric asks for, by reference.
  std::vector<SurfaceDemand> surface_demands;
  std::shared_ptr<const ModelAccount>
      model;  ///< of one mesh: how it lies on the CAD model; null: there is none
  std::shared_ptr<const DistributedStats> distributed;  ///< null: the mesh was adapted as one
  std::shared_ptr<const CheckpointStats> checkpoints;   ///< of one mesh; null: nothing to tell
  std::vector<ComponentAccount> field_accounts;         ///< of the fields carried along
  TransferMethod transfer = TransferMethod::linear;  ///< their; linear too where the caller cancelled another
  StageTimes times;
  int threads = 1;
  double peak_memory = 0;  ///< bytes, of this process; of ranks the largest

  /// Whether it is known to be met: by measures.
  bool goal_met() const { return after && missed.empty(); }
};

/// The readable account: what the command prints.
WEFT_API std::string summary(const Report& report);
/// The same for programs, JSON of schema "weft-report-1".
WEFT_API std::string to_json(const Report& report);
WEFT_API std::string to_json(const Measures& measures);

// ---------------------------------------------------------------------------------------------------------------
// Adaptation of one mesh

struct Result : Report {
  Mesh mesh;
  Metric metric;  ///< at the vertices of `mesh`
  Fields fields;  ///< those that were to be carried along, at the vertices of `mesh`
};

/// The measures of a result: those of its run, else taken now and kept, with what they say of the goal.
WEFT_API const Measures& measures(Result& result);

/// Adapts `mesh` to `metric`, at its vertices, processed as options.metric says (scaled, limited, graded).
/// `fields` are carried along. Throws InputError for a mesh that does not conform and a metric of the wrong
/// length.
WEFT_API Result adapt(const Mesh& mesh, const Metric& metric, const Options& options = {},
                      const Fields& fields = {});

/// To the metric that options.metric makes.
WEFT_API Result adapt(const Mesh& mesh, const Options& options, const Fields& fields = {});

/// To a metric that belongs to another mesh of the same domain.
WEFT_API Result adapt(const Mesh& mesh, const Mesh& background, const Metric& metric, const Options& options,
                      const Fields& fields = {});
/// To the metric that options.metric makes on that other mesh: its solutions are at the vertices there.
WEFT_API Result adapt(const Mesh& mesh, const Mesh& background, const Options& options,
                      const Fields& fields = {});

// ---------------------------------------------------------------------------------------------------------------
// Adaptation of a mesh in parts

/// What one rank has of a mesh in parts. Every tet is on one rank; vertices of a partition's boundary are on
/// all ranks that have tets at them, under the same id.
struct Part {
  /// Indices are local. Triangles, edges, corners and required entities may be given by any rank that has
  /// their vertices, by several too; triangles by none (they are then made where tets end) or all of the
  /// boundary's.
  Mesh mesh;
  std::vector<std::uint64_t> ids;  ///< of mesh.points: the same number wherever the vertex is
  std::vector<std::uint64_t>
      tet_ids;    ///< optional: fixes the order of the tets, else that of ranks and arrays does
  Fields fields;  ///< at mesh.points

  // Of results only. Ids count from 0 without gaps. With ghosts, ghost tets and vertices come last.
  std::vector<int> owners;        ///< of mesh.points: the rank that owns the vertex
  std::size_t num_own_tets = 0;   ///< the tets from this one on are ghosts
  std::vector<int> ghost_owners;  ///< of the ghost tets: the rank that has the tet
};

struct PartResult : Report {
  Part part;
  Metric metric;  ///< at the vertices of `part`
};

/// Adapts a mesh in parts. All ranks of the communicator call it; any rank may be empty. MPI has been
/// initialised by the caller, is used by the calling thread only, and is not finalised. `metric`: at the
/// vertices of the part. The result's tets are spread evenly over the ranks. With options.run.threads = 1 it
/// does not depend on the number of ranks nor, with tet_ids, on who had which tets. Fields are carried along
/// as options.transfer says; where ranks have different values at a vertex, those of the lowest count. A
/// result that was ended early is measured all the same: it takes all ranks. Throws the same InputError on
/// all ranks, naming the rank, the entity and the reason: ids that mean different points, holes between
/// parts, wrong lengths, and whatever adapt() refuses.
WEFT_API PartResult adapt(MPI_Comm communicator, const Part& part, const Metric& metric,
                          const Options& options = {});

/// To a metric at the vertices of another mesh of the same domain, which is in parts too: any tets of it may
/// be on any rank. options.metric.solutions are at its vertices.
WEFT_API PartResult adapt(MPI_Comm communicator, const Part& part, const Part& background,
                          const Metric& metric, const Options& options);
/// To the metric that options.metric makes on that other mesh.
WEFT_API PartResult adapt(MPI_Comm communicator, const Part& part, const Part& background,
                          const Options& options);

/// To the metric that options.metric makes: of solutions at the vertices of the parts, for instance.
WEFT_API PartResult adapt(MPI_Comm communicator, const Part& part, const Options& options);

/// For programs that check data of their own before a call that all ranks make together. All ranks of the
/// communicator call it; returns on all ranks the error text of the lowest rank whose `error` is not empty,
/// and that rank (-1: all are empty).
struct RankError {
  int rank = -1;
  std::string text;
};
WEFT_API RankError first_error(MPI_Comm communicator, const std::string& error);

// ---------------------------------------------------------------------------------------------------------------
// From files to files

/// What `weft adapt` is told beside the options.
struct Files {
  std::string input, output;
  std::string background;           ///< the mesh that the metric belongs to; empty: the input
  std::vector<std::string> fields;  ///< --field: at the vertices of the input, carried along
  std::string report;               ///< folder for report.json, profile.json and report.html; empty: none
  bool page = true;                 ///< --no-page: report.json alone, with less to keep during the run
  std::string case_name;            ///< published figures to show beside (published_cases())
  std::string graph;  ///< file for the executed task graph; empty: none. In subdomains, as `trace`
  std::string trace;  ///< file for a timeline, of more than 64 ranks that of 64; empty: none
  std::vector<std::string> arguments;  ///< of the command line, for the report
};

struct FilesResult : Report {
  std::string input, metric_name;    ///< what it was made from
  std::string mesh, metric, fields;  ///< the files that were written
  std::string report;                ///< report.json; empty: none, or not all of what belongs to it
  std::string report_error;          ///< what could not be written, or measured, beside the mesh, and why
  bool first = true;                 ///< this is rank 0, which says what there is to say
};

/// Reads, adapts, measures, writes; files appear whole or not at all. Under mpirun it works on all ranks of
/// the world (and starts and ends MPI, unless the caller has started it, without whom there is one such call
/// in the life of a process): every rank reads its share where formats and metric allow. Where it has started
/// MPI itself and a rank dies or MPI fails, it ends all ranks by MPI_Abort with status 2, the only way out of
/// MPI then.
WEFT_API FilesResult adapt_files(const Files& files, const Options& options = {});
/// Whether adapt_files works in subdomains: asked to, or under mpirun.
WEFT_API bool in_subdomains(const Options& options);
/// Whether this process was started by mpirun, srun or the like.
WEFT_API bool under_mpirun();
/// The readable account with the names of the files.
WEFT_API std::string summary(const FilesResult& result);
/// The names that Files::case_name may have.
WEFT_API std::vector<std::string> published_cases();

// ---------------------------------------------------------------------------------------------------------------
// Metrics of meshes and solutions

struct MadeMetric {
  Metric metric;
  std::vector<std::string> warnings;
};
/// The metric that options ask for, at the vertices of `mesh` (called `name` in errors). `threads`: 0 is all
/// cores.
WEFT_API MadeMetric make_metric(const Mesh& mesh, const MetricOptions& options, const std::string& name = {},
                                int threads = 0);
/// The same with the boundary's curvature from the CAD model of `geometry`, if it names one.
WEFT_API MadeMetric make_metric(const Mesh& mesh, const MetricOptions& options,
                                const GeometryOptions& geometry, const std::string& name = {},
                                int threads = 0);
/// The same with a metric in memory as one more source.
WEFT_API MadeMetric make_metric(const Mesh& mesh, const Metric& source, const MetricOptions& options,
                                const std::string& name = {}, int threads = 0);
WEFT_API MadeMetric make_metric(const Mesh& mesh, const Metric& source, const MetricOptions& options,
                                const GeometryOptions& geometry, const std::string& name = {},
                                int threads = 0);
/// The integral of sqrt(det M): about half the vertices of a mesh that conforms to the metric.
WEFT_API double complexity(const Mesh& mesh, const Metric& metric);

// ---------------------------------------------------------------------------------------------------------------
// Measures, checks, fields

/// Quality and lengths in a metric.
WEFT_API Measures measure(const Mesh& mesh, const Metric& metric);
/// Shapes, without a metric.
WEFT_API ShapeMeasures measure_shape(const Mesh& mesh);
/// What can be said of a mesh without a metric.
struct Geometry {
  Point min, max;  ///< of the bounding box
  ShapeMeasures shape;
  std::map<std::int32_t, double> volume_by_ref, area_by_ref;  ///< of tets and triangles by their references
};
WEFT_API Geometry measure_geometry(const Mesh& mesh);
/// What `weft stat` tells of a mesh.
struct MeshFigures {
  MeshCounts counts;
  std::uint64_t corners = 0, ridges = 0, required_vertices = 0, required_edges = 0, required_triangles = 0;
  Geometry geometry;
  std::optional<Measures> measures;         ///< in a metric, where one is given
  std::optional<ModelAccount> model;        ///< on a CAD model, where one is named
  std::vector<std::string> model_warnings;  ///< of the model, and of how the mesh lies on it
};
/// `metric`: at the vertices of the mesh; null: none. `geometry`: names a CAD model, or none.
WEFT_API MeshFigures measure_all(const Mesh& mesh, const Metric* metric = nullptr,
                                 const GeometryOptions& geometry = {}, const std::string& name = {},
                                 int threads = 0);
/// JSON of schema "weft-stat-1".
WEFT_API std::string to_json(const MeshFigures& figures);
/// Classifies the boundary of `mesh` on the CAD model that `geometry` names and measures how it lies there.
/// `deviations`: for each vertex, the largest distance from the model of the centroids of the boundary
/// triangles around it; NaN at those that have none on the model. `warnings`: what is odd about the model,
/// and what of the mesh lies on none of it. Throws InputError where the model cannot be read or is another
/// body's.
WEFT_API ModelAccount measure_on_model(const Mesh& mesh, const GeometryOptions& geometry,
                                       const std::string& name = {}, int threads = 0,
                                       std::vector<double>* deviations = nullptr,
                                       std::vector<std::string>* warnings = nullptr);
/// The account as text, a line for each entity of the model.
WEFT_API std::string summary(const ModelAccount& account);
WEFT_API std::string to_json(const ModelAccount& account);
/// The full check of a mesh with exact arithmetic; names at most `max_problems`.
WEFT_API CheckReport verify(const Mesh& mesh, int max_problems = 20);
/// In what two meshes of the same domain differ, a sentence each: volumes and areas by reference by more than
/// 1e-9 of them, and where the bodies touch themselves. Empty where they agree.
WEFT_API std::vector<std::string> differences(const CheckReport& mesh, const CheckReport& other);
/// Fields at the vertices of `from`, at those of `to`. Throws InputError, which calls the meshes by these
/// names, where one has no tets or one without volume.
WEFT_API Transfer interpolate(const Mesh& from, const Fields& fields, const Mesh& to,
                              TransferMethod method = TransferMethod::linear, int threads = 0,
                              const std::string& from_name = {},
                              const std::string& to_name = "the mesh that the fields are wanted on");

/// Mends what can be mended of a mesh that adapt() would refuse, and says what it did: duplicate and unused
/// vertices, coordinates that are no numbers, tets with repeated vertices, of no volume, twice in the mesh or
/// inverted, vertices that lie on edges or faces of tets that do not have them, triangles that are doubled or
/// missing, entities that contradict each other. `fields` at its vertices follow. Throws InputError for what
/// cannot be mended.
WEFT_API std::vector<Mend> repair(Mesh& mesh, Fields* fields = nullptr);
/// The same for a metric in `fields` (tensors or sizes): values that are not finite or not positive definite
/// become means of their neighbours'.
WEFT_API std::vector<Mend> repair_metric(const Mesh& mesh, Fields& fields);
/// The same for triangles that are to bound a volume: vertices that are nearly one are merged, doubled and
/// degenerate triangles removed, small gaps closed, orientations made to agree.
WEFT_API std::vector<Mend> repair_surface(Mesh& surface);
/// The account of mends, a line each; empty for none.
WEFT_API std::string mends_text(std::span<const Mend> mends);

// ---------------------------------------------------------------------------------------------------------------
// Files

/// Everything that a mesh file of any format holds.
struct MeshFile {
  Mesh mesh;
  Fields fields;
  RefNames names;
  std::vector<Dropped> dropped;       ///< what of the file has no place here
  std::uint64_t foreign_volumes = 0;  ///< volume elements among these: the mesh has holes then
};
/// Reads a mesh of any format. A file with volume elements other than linear tets is refused.
WEFT_API Mesh read_mesh(const std::string& path, RefNames* names = nullptr);
/// Reads everything, and says what it had to leave out.
WEFT_API MeshFile read_mesh_file(const std::string& path);
/// The pieces of a .pvtu, numbered by the references of their tets.
WEFT_API Mesh read_mesh_by_piece(const std::string& path);
/// Reads .solb, .sol, or the fields in a mesh file that has some.
WEFT_API Fields read_fields(const std::string& path);
/// All fields of several files, at the vertices of a mesh; one without a name gets that of its file. Throws
/// InputError naming file, field and vertex for the fields of another mesh (`mesh_name` has `num_points`) and
/// values that are not finite.
WEFT_API Fields read_fields(const std::vector<std::string>& paths, std::size_t num_points,
                            const std::string& mesh_name = {});
/// How many vertices a file has, as far as it says so without being held: of a mesh in several pieces, whose
/// vertices are joined, the largest piece and the sum of all are bounds.
struct VertexCount {
  std::uint64_t least = 0, most = 0;
};
/// Reads of a volume mesh the numbers that it begins with, or all of it block by block where it has none.
WEFT_API VertexCount count_vertices(const std::string& mesh);
/// Checks a file of fields at the vertices of a mesh (`mesh_name` has `vertices`) as read_fields() does, and
/// returns kinds and names alone: values are looked at block by block (those of .ply all at once).
WEFT_API Fields check_field_file(const std::string& path, const VertexCount& vertices,
                                 const std::string& mesh_name = {});
/// Reads a metric for `mesh`.
WEFT_API Metric read_metric(const std::string& path, const Mesh& mesh);
/// Writes a mesh; fields go into the file where its format holds them, else into a .solb (.sol) beside it.
/// Whole or not at all.
WEFT_API void write_mesh(const std::string& path, const Mesh& mesh, const Fields& fields = {},
                         const RefNames& names = {});
/// Writes what an adaptation gives: OUT.meshb, its metric OUT.solb and, where there are any, OUT-fields.solb
/// (.sol beside a .mesh); a format that holds fields gets all of them too. The others appear only once the
/// mesh has. OUT.pvtu has nothing beside it but its pieces.
WEFT_API void write_result(const std::string& path, const Mesh& mesh, const Metric& metric,
                           const Fields& fields = {}, const RefNames& names = {});
/// The names of these files; all of them OUT.pvtu where the pieces hold everything.
struct ResultFiles {
  std::string mesh, metric, fields;
};
WEFT_API ResultFiles result_files(const std::string& path);
/// Writes a mesh without a file of fields beside; returns what has no place in the format.
WEFT_API std::vector<Dropped> write_mesh_file(const std::string& path, const MeshFile& contents,
                                              const WriteOptions& options = {});
struct Converted {
  MeshCounts counts;
  std::vector<Dropped> dropped;  ///< what of the input has no place here, and of that what the format has not
};
/// From file to file as `weft convert` does. `solution`: a file of fields at the vertices; empty: none. These
/// and the input's own are written into the result, or beside it where its format holds none. Throws
/// OptionError where the result would replace a file that is read, other than the mesh itself.
WEFT_API Converted convert(const std::string& input, const std::string& output,
                           const std::string& solution = {}, const WriteOptions& options = {});
/// Writes .solb or .sol, whole or not at all.
WEFT_API void write_fields(const std::string& path, const Fields& fields);
/// Writes a text, whole or not at all. Throws InputError.
WEFT_API void write_text(const std::string& path, const std::string& text);

/// Throws InputError unless a file can be created at `path`.
WEFT_API void check_writable(const std::string& path);
/// The file of fields that belongs beside a mesh file: OUT.sol for OUT.mesh, else OUT.solb.
WEFT_API std::string fields_beside(const std::string& mesh);
/// Whether the extension is that of a mesh format; of one that holds tets; of one that holds fields.
WEFT_API bool is_mesh_name(const std::string& path);
WEFT_API bool holds_volumes(const std::string& path);
WEFT_API bool holds_fields(const std::string& path);
/// ".meshb, .mesh, ... or .obj", for messages; those that hold tets.
WEFT_API std::string mesh_extensions();
WEFT_API std::string volume_extensions();

// ---------------------------------------------------------------------------------------------------------------
// Initial meshes

struct FillOptions {
  double growth = 1.3;               ///< of neighbouring edges away from the surface
  double size = 0;                   ///< largest size; 0: no limit
  bool materials = false;            ///< a shell within a volume bounds a material; else a hole, unless a
                                     ///< body of the CAD model fills it
  double merge = 1e-9;               ///< points nearer than this share of the diagonal are one
  bool remesh_surface = false;       ///< let the surface be adapted; else its triangles stay
  const Mesh* background = nullptr;  ///< with `metric` at its vertices: sizes to use instead of the surface's
  const Metric* metric = nullptr;
  GeometryOptions geometry;
  RunOptions run;
};
struct FillResult {
  Mesh mesh;
  Metric metric;  ///< that it was made for
  std::uint64_t regions = 0;
  std::vector<std::string> warnings;  ///< what was mended
  std::vector<Mend> mends;            ///< of the surface (RunOptions::repair)
  double deviation = 0;               ///< of repair: largest distance of the mended surface from the input's
  std::vector<std::string> missed;    ///< where it lies on the CAD model worse than the surface did
  bool cancelled = false;
  std::string ended_by;  ///< of a cancelled one, as Report::ended_by
  double grid_seconds = 0, fill_seconds = 0;
};
/// Whether the extension is one of a CAD model; those that are.
WEFT_API bool is_model_name(const std::string& path);
WEFT_API std::string model_extensions();
struct TessellationOptions {
  /// Largest distance of an edge from the model; 0: 0.1 % of the diagonal, and what a face's size and
  /// curvature bear.
  double sagitta = 0;
  double angle = 20;  ///< degrees that the normal turns along an edge
};
/// Triangles on a CAD model, conforming across its edges, with the ids of faces and edges as references and
/// the nodes as corners, and associated with the model. Throws InputError naming the entity where they would
/// not be watertight.
WEFT_API Mesh tessellate(const GeometryOptions& geometry, const TessellationOptions& options = {});
/// Fills the volumes that closed triangles bound with tets. Throws InputError naming triangles (1-based), and
/// RunError where it is cancelled before there is a mesh.
WEFT_API FillResult fill(const Mesh& surface, const FillOptions& options = {});

/// A structured box of tets; the surfaces of simple bodies.
WEFT_API Mesh box(const BoxOptions& options);
WEFT_API Mesh ball_surface(const BallOptions& options);
WEFT_API Mesh cylinder_surface(const CylinderOptions& options);
WEFT_API Mesh delta_wing_surface(const DeltaWingOptions& options);

/// A text on one line, without what could command a terminal: names from files may hold anything.
WEFT_API std::string printable(const std::string& text);

// ---------------------------------------------------------------------------------------------------------------
// Pictures, task graphs and reports

/// A picture of a mesh, by the words of `weft view`.
struct PictureOptions {
  std::string color_by = "none";  ///< none, ref, subdomain, quality, length, nonconforming, field
  std::string size = "1600x1200", from = "iso", up, clip, focus, range, title;
  std::vector<std::int32_t> only;
  double zoom = 1, line_width = 1;
  bool dark = false, flip = false, slice = false, edges = true, legend = true, axes = true;
};
struct PictureSource {
  const Mesh& mesh;
  const Metric* metric = nullptr;
  std::span<const double> field = {};  ///< one value a vertex, for color_by field
  std::string field_name = {};
  const RefNames* names = nullptr;
};
/// The width and height in pixels.
struct PictureSize {
  int width = 0, height = 0;
};
/// Whether the extension is one of a picture: .png, .pdf, .svg.
WEFT_API bool is_picture_name(const std::string& path);
/// Throws OptionError for words that mean nothing.
WEFT_API PictureSize check_picture(const PictureOptions& options);
/// Draws into a file: .png, .pdf or .svg.
WEFT_API void draw(const std::string& path, const PictureSource& source, const PictureOptions& options = {});
/// Histograms of quality and length as a figure.
struct HistogramText {
  std::string title, tets, edges;  ///< over all, over the plots of quality and over those of length
};
WEFT_API void draw_histograms(const std::string& path, const Measures& measures, const HistogramText& text);
/// The same with counts, qualities and lengths over the plots. Throws InputError where there are no tets.
WEFT_API void draw_histograms(const std::string& path, const Measures& measures, const std::string& title);

/// What of a task graph is shown.
struct GraphFilter {
  std::optional<std::uint64_t> round, subdomain;  ///< only runs of this one
  std::string collapse =
      "none";  ///< a vertex for each run (none), node and round (rounds) or subdomain (subdomains)
  bool critical_path = false;  ///< only that
  bool plan = false;           ///< the planned graph, which is the same for every subdomain
};
/// The graph of a run in `path` (graph.json, profile.json, what Files::graph names as .json), as text in a
/// format: dot, graphml, json, or svg (needs Graphviz). Throws InputError, and OptionError for filters of a
/// plan and for JSON that is to be collapsed.
WEFT_API std::string graph_text(const std::string& path, const std::string& format,
                                const GraphFilter& filter = {});
/// The format that a file's extension names; empty for another.
WEFT_API std::string graph_format(const std::string& path);

/// Writes the page of a run's profile.json.
WEFT_API void write_report_page(const std::string& profile, const std::string& page);
/// What got slower from run `a` to run `b` (profile.json or report.json), and how the meshes differ, as text;
/// and as a page where one is named.
WEFT_API std::string compare_reports(const std::string& a, const std::string& b,
                                     const std::string& page = {});

}  // namespace weft
