// Decomposition, one run of the engine, and what it leaves.
#include "graph/adaptation/distributed_adaptation.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/base/virtual_time.h"
#include "graph/adaptation/phase_plan.h"
#include "graph/adaptation/resume.h"
#include "meshing/base/error.h"
#include "meshing/base/freed_memory.h"
#include "meshing/base/parallel.h"
#include "meshing/metric/expectations.h"
#include "meshing/operators/surface_fit.h"
#include "partition/communication/agreement.h"
#include "partition/communication/reduce.h"
#include "partition/coordinate/boundary_coordinate.h"
#include "partition/fields/own_background.h"
#include "partition/output/piece_share.h"
#include "partition/subdomain/adapt_subdomain.h"
#include "partition/verify/check_subdomains.h"

namespace weft::graph::adaptation {

using partition::Subdomain;
using partition::SubdomainId;
using partition::SubdomainStart;

namespace {

double seconds_since(engine::TimePoint t) { return 1e-9 * static_cast<double>(engine::now() - t); }

/// Of the adapted subdomain.
double predicted_tets(const SubdomainStart& s) {
  std::vector<double> densities;
  densities.reserve(s.log_metrics.size());
  for (const meshing::LogMetric& l : s.log_metrics) densities.push_back(std::exp(0.5 * trace(l)));
  double complexity = 0;
  for (const auto& t : s.tets) {
    double density = 0;
    for (const std::uint32_t v : t) density += 0.25 * densities[v];
    const auto& p = s.points;
    const double six_volume = dot(p[t[1]] - p[t[0]], cross(p[t[2]] - p[t[0]], p[t[3]] - p[t[0]]));
    complexity += density / 6 * std::max(0.0, six_volume);  // a flat tet may compute a negative one
  }
  return meshing::kTetsPerComplexity * complexity;
}

/// What is made at the start of a run.
struct Made {
  std::vector<Neighbours> neighbours;  ///< who borders on whom, or is to be a part of whom
  std::vector<std::pair<SubdomainTask::Ref, engine::Seconds>> tasks;
  std::vector<SubdomainTask::Ref> parts;  ///< that have no tets until others divide
};

/// A subdomain that is no task yet.
struct NewSubdomain {
  Subdomain subdomain;
  double predicted;      ///< predicted_tets()
  std::size_t num_tets;  ///< of its start
};

/// Uses up the starts, several at a time (TBB, in the caller's arena).
std::vector<NewSubdomain> make_subdomains(std::vector<SubdomainStart>&& starts) {
  std::vector<NewSubdomain> made(starts.size());
  meshing::for_each_large(starts.size(), [&](std::size_t i) {
    const double predicted = predicted_tets(starts[i]);
    const std::size_t num_tets = starts[i].tets.size();
    made[i] = {Subdomain(starts[i], partition::tet_slots_for(predicted, num_tets)), predicted, num_tets};
    starts[i] = {};
  });
  return made;
}

Made make_tasks(engine::Context& context, std::vector<NewSubdomain>&& subdomains,
                dataflow::Recording recording, const AdaptationPlan& plan) {
  Made made;
  for (auto& [subdomain, predicted, num_tets] : subdomains) {
    const SubdomainId id = subdomain.id;
    const auto others = subdomain.interface.neighbours();
    made.neighbours.push_back({id, {others.begin(), others.end()}});
    const PartsOf family = plan.parts_with(id);
    for (std::uint32_t part = family.first.value + 1; part < family.first.value + family.count; ++part)
      if (id == family.first) made.neighbours.back().others.emplace_back(part);
    if (id != family.first) made.neighbours.back().others.push_back(family.first);
    const auto ref =
        dataflow::create<SubdomainTask>(context, SubdomainTask(std::move(subdomain), predicted), recording);
    if (ref.id != object_of(plan, context.ranks(), id).id)
      throw std::logic_error("subdomain " + std::to_string(id.value) +
                             " is not the object that others expect");
    if (id != family.first) {
      made.parts.push_back(ref);
    } else {
      const double coarseness = plan.phases[0].coarseness;
      const double to_adapt = std::max(plan.is_coarse(0) ? static_cast<double>(num_tets) : 0,
                                       predicted / std::pow(coarseness, 3));
      made.tasks.emplace_back(ref, SubdomainTask::seconds_to_adapt(to_adapt));
    }
  }
  return made;
}

void start_tasks(engine::Context& context, const Made& made, const AdaptationPlan& plan) {
  for (const SubdomainTask::Ref& ref : made.parts)
    dataflow::start<&SubdomainTask::await_division>(context, ref, *plan.division);
  for (const auto& [ref, seconds] : made.tasks)
    dataflow::start<&SubdomainTask::adapt_interior>(context, ref, 0, {}, seconds);
}

/// A run with pauses, in which everything is checked.
class CheckedRun {
 public:
  CheckedRun(engine::Runtime& runtime, EnginePeers& peers, const RankData& rank,
             const DistributedOptions& options)
      : runtime_(runtime), peers_(peers), rank_(rank), options_(options) {}

  /// After make_tasks(). Returns the number of checks. `begins`: called before anything is adapted.
  std::uint32_t run(const Made& made, const std::function<void()>& begins) {
    begin_with(here());
    begins();
    runtime_.run([&](engine::Context& context) { start_tasks(context, made, rank_.plan); });
    return go_on_to_the_end();
  }

  /// Before a checkpoint is restored: what its run began with is what must stay. Uses up the starts.
  void expect_of(std::vector<partition::SubdomainStart>& starts) {
    std::vector<Subdomain> subdomains;
    for (partition::SubdomainStart& start : starts) {
      const std::size_t num_tets = start.tets.size();
      subdomains.emplace_back(start, partition::tet_slots_for(0, num_tets));
      start = {};
    }
    starts.clear();
    std::vector<const Subdomain*> mine;
    for (const Subdomain& s : subdomains) mine.push_back(&s);
    begin_with(mine);
  }

  /// After a checkpoint has been restored. Returns the number of checks.
  std::uint32_t resume() {
    runtime_.run();
    return go_on_to_the_end();
  }

 private:
  /// Where subdomains on any rank pause: all that do are at the same place. Empty: all rest.
  std::optional<Pause> next_pause() {
    std::uint64_t next = 0;  // none
    dataflow::visit<SubdomainTask>(runtime_, [&](SubdomainTask::Ref, SubdomainTask& task) {
      if (const auto& pause = task.paused())
        next = std::max(next, 2 * pause->round + 2 - pause->begins_phase);
    });
    next = partition::max(peers_, next);
    if (next == 0) return {};
    return Pause{(next - 1) / 2, next % 2 == 1};
  }

  std::uint32_t go_on_to_the_end() {
    while (const std::optional<Pause> pause = next_pause()) {
      const bool after_interiors = !pause->begins_phase && rank_.plan.begins_phase(pause->round);
      const bool after_division = pause->begins_phase && rank_.plan.division == pause->round - 1;
      check(here(), after_interiors  ? "after the adaptation of the interiors"
                    : after_division ? "after the division"
                                     : "after shift " + std::to_string(pause->round));
      go_on();
    }
    return checks_;
  }

  std::vector<const Subdomain*> here() {
    std::vector<const Subdomain*> mine;
    dataflow::visit<SubdomainTask>(runtime_, [&](SubdomainTask::Ref, SubdomainTask& task) {
      if (options_.on_check) options_.on_check(task.subdomain());
      mine.push_back(&task.subdomain());
    });
    return mine;
  }

  /// What must stay is what there is after the decomposition.
  void begin_with(const std::vector<const Subdomain*>& mine) {
    const partition::PiecesReport at_first = check(mine, "after the decomposition");
    double deviation = 0;
    for (const Subdomain* s : mine)
      deviation = std::max(
          deviation, meshing::largest_surface_deviation(*s->mesh, rank_.geometry->surface.part(s->surface)));
    totals_ = totals_to_keep(at_first, *rank_.geometry, rank_.plan.hausd + partition::max(peers_, deviation));
  }

  partition::PiecesReport check(const std::vector<const Subdomain*>& mine, const std::string& when) {
    partition::PiecesReport report = check_subdomains(peers_, mine, *rank_.geometry, totals_);
    throw_if_violated(report, when);
    ++checks_;
    return report;
  }

  void go_on() {
    std::vector<std::pair<SubdomainTask::Ref, Pause>> released;
    dataflow::visit<SubdomainTask>(runtime_, [&](SubdomainTask::Ref ref, SubdomainTask& task) {
      if (const auto pause = task.release()) released.emplace_back(ref, *pause);
    });
    runtime_.run([&](engine::Context& context) {
      for (const auto& [ref, pause] : released)
        pause.begins_phase ? dataflow::start<&SubdomainTask::adapt_interior>(context, ref, pause.round)
                           : dataflow::start<&SubdomainTask::propose>(context, ref, pause.round);
    });
  }

  engine::Runtime& runtime_;
  EnginePeers& peers_;
  const RankData& rank_;
  const DistributedOptions& options_;
  std::optional<partition::ExpectedTotals> totals_;
  std::uint32_t checks_ = 0;
};

/// All ranks: says when the limit of shifts has ended the run.
void warn_of_limit(engine::Runtime& runtime, EnginePeers& peers, const AdaptationPlan& plan,
                   std::vector<std::string>& warnings) {
  std::vector<std::uint64_t> wanting(2, 0);  // subdomains, vertices
  dataflow::visit<SubdomainTask>(runtime, [&](SubdomainTask::Ref, SubdomainTask& task) {
    wanting[0] += task.wanted_at_limit() > 0;
    wanting[1] += task.wanted_at_limit();
  });
  wanting = partition::sum(peers, wanting);
  if (wanting[0] == 0) return;
  warnings.push_back("the run ended by its limit of " + std::to_string(plan.most_shifts) +
                     (plan.most_shifts == 1 ? " shift: " : " shifts: ") + std::to_string(wanting[0]) +
                     " of " + std::to_string(plan.subdomains) + " subdomains wanted " +
                     std::to_string(wanting[1]) + (wanting[1] == 1 ? " more vertex" : " more vertices") +
                     " to be freed");
}

/// All ranks: what the partitioner says where the first subdomains are divided later than the mesh.
void warn_of_division(engine::Runtime& runtime, EnginePeers& peers, const AdaptationPlan& plan,
                      std::vector<std::string>& warnings) {
  if (plan.seeds.empty()) return;
  std::string mine;
  dataflow::visit<SubdomainTask>(runtime, [&](SubdomainTask::Ref, SubdomainTask& task) {
    if (mine.empty()) mine = task.division_warning();
  });
  const std::string first = partition::first_text(peers, mine);
  if (!first.empty()) warnings.push_back(first);
}

/// The subdomains have been made pieces of: their vertices and boundary faces have these numbers.
void account_on_model(engine::Runtime& runtime, EnginePeers& peers, const meshing::Surface& surface,
                      DistributedResult& result) {
  const std::vector<partition::PieceShare> shares = partition::shares_of(peers, result.pieces);
  std::size_t p = 0;
  dataflow::visit<SubdomainTask>(runtime, [&](SubdomainTask::Ref, SubdomainTask& task) {
    const Subdomain& s = task.subdomain();
    const partition::PieceShare& share = shares[p++];
    meshing::ModelShare mine{share.on_nodes, share.on_model, share.triangles};
    for (const auto& more : {share.on_edges, share.on_faces})
      mine.records.insert(mine.records.end(), more.begin(), more.end());
    result.on_model.push_back({s.id, meshing::sum_on_model(*s.mesh, surface.part(s.surface), mine)});
  });
}

/// Of each vertex, in the order of the piece.
std::vector<std::uint8_t> was_interface(const meshing::TetMesh& mesh) {
  std::vector<std::uint8_t> was;
  for (std::uint32_t i = 0; i < mesh.vertex_slots(); ++i)
    if (const meshing::VertexId v(i); mesh.alive(v))
      was.push_back(mesh.frozen(v) || mesh.flags(v) & partition::kWasInterface);
  return was;
}

void take_pieces(engine::Runtime& runtime, EnginePeers& peers, const partition::Geometry& geometry,
                 DistributedResult& result) {
  std::vector<Subdomain*> subdomains;
  dataflow::visit<SubdomainTask>(runtime, [&](SubdomainTask::Ref, SubdomainTask& task) {
    subdomains.push_back(&task.subdomain());
    result.shifts.push_back(task.shifts());
    result.counts += task.counts();
  });
  result.pieces.resize(subdomains.size());
  result.was_interface.resize(subdomains.size());
  std::vector<double> deviations(subdomains.size());
  const auto order = result.cut_by_runs ? partition::PieceOrder::kept_if_good : partition::PieceOrder::anew;
  meshing::for_each_large(subdomains.size(), [&](std::size_t p) {
    Subdomain& s = *subdomains[p];
    result.pieces[p] = make_piece(s, geometry.surface, geometry.patch_required, order);
    result.was_interface[p] = was_interface(*s.mesh);
    deviations[p] = meshing::largest_surface_deviation(*s.mesh, geometry.surface.part(s.surface));
    if (!geometry.surface.model()) s = {};
  });
  for (const double deviation : deviations)
    result.surface_deviation = std::max(result.surface_deviation, deviation);
  if (!geometry.surface.model()) return;
  account_on_model(runtime, peers, geometry.surface, result);
  dataflow::visit<SubdomainTask>(runtime,
                                 [&](SubdomainTask::Ref, SubdomainTask& task) { task.subdomain() = {}; });
}

/// Folders are numbered on from those that are there: rank 0 looks.
void begin_checkpoints(EnginePeers& peers, const AdaptationPlan& plan, std::uint64_t hash,
                       CheckpointWriter& writer) {
  std::uint64_t last = 0;
  partition::agree_on(peers, [&] {
    if (peers.rank() != 0) return;
    writer.lock();
    last = last_number(writer.folder());
  });
  last = partition::max(peers, last);
  writer.begin({hash, plan.subdomains, plan.home_ranks, last, {}});
}

/// The same on all ranks.
void check_same_run(const CheckpointPlace& place, const AdaptationPlan& plan, std::uint64_t hash) {
  if (place.manifest.run == hash && place.manifest.subdomains == plan.subdomains) return;
  throw meshing::InputError(place.folder.string(), "",
                            "is a checkpoint of another run: the input, the metric or an option is not the "
                            "same, or the program is another");
}

/// The latest that is not damaged; there is a warning of each that is. Throws what is wrong with the latest
/// where all are.
const CheckpointPlace& restore_latest(engine::Runtime& runtime, EnginePeers& peers,
                                      const AdaptationPlan& plan, const std::vector<CheckpointPlace>& places,
                                      std::vector<std::string>& warnings) {
  std::exception_ptr latest;
  for (const CheckpointPlace& place : places) {
    try {
      restore_subdomains(runtime, peers, plan, place);
      return place;
    } catch (const meshing::InputError& error) {
      if (!latest) latest = std::current_exception();
      warnings.emplace_back(error.what());
    }
  }
  std::rethrow_exception(latest);
}

/// What no rank writes to any more can be told to be unfinished. Of a run that was interrupted it stays: its
/// mesh is not to wait for a disk.
void end_checkpoints(EnginePeers& peers, CheckpointWriter& writer, bool interrupted) {
  writer.end();
  const bool all_have = partition::max(peers, interrupted ? 1 : 0) == 0;
  if (all_have && peers.rank() == 0) writer.remove_unfinished();
}

/// All ranks: what slabs are to be cut along, where it is no axis. Returns a warning, or none.
std::string find_coordinate(EnginePeers& peers, const partition::MeshSlice& slice,
                            partition::DecompositionOptions& decomposition) {
  if (!decomposition.partitioner.coordinate.asked()) return {};
  partition::CoordinateValues found =
      partition::boundary_coordinate(peers, slice, decomposition.partitioner.coordinate);
  decomposition.coordinate = std::move(found.values);
  return found.warning;
}

/// The complexity is that of the metric on its own mesh. `uncovered`: by that.
partition::Distributed distribute_on_background(EnginePeers& peers, partition::MeshSlice&& slice,
                                                const DistributedOptions& options,
                                                const partition::DecompositionOptions& decomposition,
                                                meshing::Uncovered& uncovered) {
  if (!options.background) return partition::distribute(peers, std::move(slice), decomposition);
  const partition::OwnBackground background(peers, std::move(*options.background), slice);
  partition::DecompositionOptions mine = decomposition;
  mine.parts_at_first = [&](partition::InputMeasures input) {
    input.complexity = background.complexity();
    return decomposition.parts_at_first(input);
  };
  partition::Distributed d = partition::distribute(peers, std::move(slice), mine);
  background.deliver(d.starts);
  d.complexity = background.complexity();
  uncovered = background.uncovered();
  return d;
}

std::vector<Neighbours> neighbours_here(engine::Runtime& runtime) {
  std::vector<Neighbours> all;
  dataflow::visit<SubdomainTask>(runtime, [&](SubdomainTask::Ref, SubdomainTask& task) {
    const auto others = task.subdomain().interface.neighbours();
    all.push_back({task.subdomain().id, {others.begin(), others.end()}});
  });
  return all;
}

}  // namespace

void register_adaptation(engine::Registry& registry) {
  EnginePeers::register_types(registry);
  dataflow::register_blueprint<SubdomainTask>(registry);
}

DistributedResult adapt_distributed(engine::Runtime& runtime, EnginePeers& peers, RankData& rank,
                                    partition::MeshSlice&& slice, const DistributedOptions& options) {
  DistributedResult result;
  const engine::TimePoint begin = engine::now();
  const std::uint64_t input_tets = slice.num_tets;
  partition::DecompositionOptions decomposition = options.decomposition;
  decomposition.parts_at_first = [&](const partition::InputMeasures& input) {
    return parts_at_first(input, {decomposition.num_subdomains, options.most_shifts,
                                  decomposition.partitioner, options.tets_of_seed});
  };
  const std::string of_coordinate = find_coordinate(peers, slice, decomposition);
  partition::Distributed d =
      distribute_on_background(peers, std::move(slice), options, decomposition, result.uncovered);
  result.warnings = d.warnings;
  result.input_on_model = d.geometry->on_model;
  result.cut_by_runs = d.cut_by_runs;
  if (!of_coordinate.empty()) result.warnings.push_back(of_coordinate);
  result.decomposition_seconds = seconds_since(begin);

  AdaptationPlan& plan = rank.plan;
  plan.subdomains = options.decomposition.num_subdomains;
  plan.first_object = EnginePeers::kObjects + 1;
  plan.most_shifts = options.most_shifts;
  plan.shift = options.shift;
  plan_phases(d, input_tets, plan);
  plan.division_options = {1, options.decomposition.partitioner, options.decomposition.equal_tets};
  // Splits that nobody judges turn needles of the interface into many, which nothing but swaps mends; without
  // them shifts free the interface, and the kernel judges.
  plan.refine_interface = options.refine_interface && options.allowed.insert && options.allowed.swap;
  plan.allowed = options.allowed;
  plan.tets_at_frozen_stay = options.tets_at_frozen_stay;
  plan.hausd = options.hausd > 0 ? options.hausd : meshing::kHausdOfDiagonal * norm(d.box.size());
  plan.details = options.hausd > 0 ? meshing::kUnbounded : 1;
  plan.expected_complexity = d.complexity;
  plan.threads = std::max(1, options.threads);
  plan.pauses = options.check;
  plan.home_ranks = options.resume.empty() ? peers.ranks() : options.resume[0].manifest.home_ranks;
  rank.geometry = d.geometry;
  rank.shared = std::make_shared<SharedByRank>();
  static FreedMemory freed;
  if (!engine::VirtualTime::of_thread()) rank.freed = &freed;
  rank.interrupt = options.interrupt;
  rank.out_of_memory = options.out_of_memory;
  rank.news = options.news;

  // Of the decomposition: subdomains' arrays do not lie where that did.
  if (rank.freed) meshing::give_back_freed_memory();
  if (options.on_plan) options.on_plan();
  if (options.on_start) options.on_start();
  const engine::TimePoint middle = engine::now();
  const bool keeps_state = options.checkpoints || !options.resume.empty();
  const std::uint64_t hash = keeps_state ? hash_of_run(peers, d.starts, plan, options.program) : 0;
  const auto begin_writing = [&] {
    if (options.checkpoints) begin_checkpoints(peers, plan, hash, *options.checkpoints);
  };
  if (!options.resume.empty()) {
    begin_writing();
    check_same_run(options.resume[0], plan, hash);
    CheckedRun checked(runtime, peers, rank, options);
    if (plan.pauses) checked.expect_of(d.starts);
    d.starts.clear();
    result.resumed = restore_latest(runtime, peers, plan, options.resume, result.warnings).folder;
    dataflow::visit<SubdomainTask>(runtime,
                                   [&](SubdomainTask::Ref, SubdomainTask& task) { task.tell_first(rank); });
    result.planned = neighbours_here(runtime);
    if (plan.pauses)
      result.checks = checked.resume();
    else
      runtime.run();
  } else {
    Made made;
    std::vector<NewSubdomain> subdomains = make_subdomains(std::move(d.starts));
    if (!plan.pauses) begin_writing();
    runtime.run([&](engine::Context& context) {
      made = make_tasks(context, std::move(subdomains), options.recording, plan);
      if (!plan.pauses) start_tasks(context, made, plan);
    });
    // Nothing goes on by itself from subdomains that have not been started.
    if (plan.pauses) result.checks = CheckedRun(runtime, peers, rank, options).run(made, begin_writing);
    result.planned = std::move(made.neighbours);
  }
  if (options.on_end) options.on_end();
  if (options.checkpoints)
    end_checkpoints(peers, *options.checkpoints, options.interrupt != nullptr && *options.interrupt);
  if (const auto lines = dataflow::incomplete<SubdomainTask>(runtime); !lines.empty())
    throw std::logic_error("the subdomains have not finished: " + lines.front());
  result.adaptation_seconds = seconds_since(middle);
  warn_of_limit(runtime, peers, plan, result.warnings);
  warn_of_division(runtime, peers, plan, result.warnings);
  take_pieces(runtime, peers, *rank.geometry, result);
  return result;
}

dataflow::ExecutionLog execution_log(engine::Runtime& runtime) {
  return dataflow::log_of<SubdomainTask>(runtime);
}

}  // namespace weft::graph::adaptation
