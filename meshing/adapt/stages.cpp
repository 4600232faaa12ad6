// The stages of an adaptation: the order of operations of the paper's requirement 6 (collapse, create points,
// reconnect, smooth; quality improvement last) over work lists.
#include "meshing/adapt/stages.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <new>
#include <string>
#include <type_traits>
#include <vector>

#include "meshing/adapt/check_whole.h"
#include "meshing/adapt/passes.h"
#include "meshing/adapt/work.h"
#include "meshing/kernel/renumber.h"
#include "meshing/kernel/tet_batch.h"
#include "meshing/metric/expectations.h"
#include "meshing/operators/surface_fit.h"

namespace weft::meshing {
namespace {

/// A mesh with this mean quality has nothing worth keeping, and is made coarse first. Meshes that were
/// adapted to a metric like the wanted one have 0.8 and more (0.85 gains some quality, and loses a sixth of
/// the time).
constexpr double kFarMean = 0.75;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

// Tets worse than this are tried for swaps. Above it nearly no swap is found: on cube-polar2 at 50,000, 0.9
// and 0.95 cost 40 % more time for 0.0005 more mean quality.
constexpr double kSwapBelow = 0.8;
// At frozen vertices what is not bad is left until they are thawed: it would be tried again and again, for
// what lies beside the interface changes with all around it. On cube-polar2 to 500,000 in 128 subdomains that
// saves a seventh of all time; Q 1 % is 0.726 instead of 0.730.
constexpr double kSwapBelowAtFrozen = 0.6;
// While points are created only bad tets are swapped: the next splits change the rest anyway.
constexpr double kSwapBelowWhileCreating = 0.5;
// A mesh with this mean quality is left alone where nothing is wrong; below, everything is worth smoothing.
constexpr double kGoodMean = 0.85;
// A mesh is coarse when this share of its tets has edges to be split.
constexpr double kCoarse = 0.7;
constexpr int kMostRestarts = 2;

/// One adaptation from the first mark to the last improvement.
class Adaptation {
 public:
  Adaptation(Kernel& kernel, const AdaptOptions& options, Extent extent, AdaptReport& report,
             const BeforeLevel& before_level)
      : kernel_(kernel),
        mesh_(kernel.mesh),
        workers_(kernel, std::max(1, options.threads), options.interrupt, options.abandon,
                 options.idle_threads),
        options_(options),
        extent_(extent),
        report_(report),
        before_level_(before_level) {
    if (options.resume) go_on_from(*options.resume);
  }

  void run() {
    kernel_.policy.frozen = frozen_policy();
    kernel_.policy.allowed = options_.allowed;
    pass([] {});  // tells how large the mesh is at first
    if (options_.progress) predict();
    if (kernel_.surface.model() && extent_ == Extent::everything)
      stage("snap to model", [&] {
        judge_by(kernel_.policy.mean);
        snap_to_model();
      });
    stage("collapse", [&] { start(); });
    stage("create points", [&] { create_points(); });
    stage("reconnect and smooth", [&] { reconnect_and_smooth(); });
    for (int i = 0; i < kMostRestarts && fits_badly(); ++i) stage("start again", [&] { start_again(); });
    stage("improve", [&] { improve_quality(); });
    if (kernel_.surface.model()) snap_to_model();
    if (next_level_ >= 1) announce_level(1);  // an interruption has left some out
    kernel_.policy.frozen = FrozenPolicy::claimable;
    if (lacks_order()) renumber();
    report_.in_order = !was_renumbered_ && !leaves_at_once();
    report_.interrupted = interrupted();
    if (mesh_.is_full())
      report_.warnings.push_back("the mesh has room for " + std::to_string(mesh_.tet_capacity()) +
                                 " tets and " + std::to_string(mesh_.vertex_capacity()) +
                                 " vertices only: it is valid, but coarser than the metric asks for");
  }

 private:
  template <class F>
  void stage(const char* name, F f) {
    if (interrupted()) return;
    stage_ = name;
    begin_pass(0);
    stage_begin_ = Clock::now();
    f();
    const std::size_t index = report_.stages.size();
    report_.stages.push_back(index < done_before_.size() ? done_before_[index] : account_of_stage());
    report_.counts += report_.stages.back().counts;
  }

  StageReport account_of_stage() {
    StageReport s;
    s.name = stage_;
    s.seconds = seconds_of_stage();
    s.tets = workers_.live_tets();
    s.vertices = workers_.live_vertices();
    s.counts = workers_.take_counts();
    return s;
  }

  double seconds_of_stage() const {
    const bool began_before = report_.stages.size() == done_before_.size();
    return seconds_since(stage_begin_) + (began_before ? seconds_before_ : 0);
  }

  // --- Passes: all that changes the mesh, and all that the order of what follows reads of it

  /// Makes a pass and returns what it returns, if anything. A pass that was made before the state that this
  /// adaptation goes on from is not made again: what it has returned is told.
  template <class F>
  double pass(F f) {
    if (replays()) return passes_[next_pass_++].value;
    const double value = make(f);
    if (options_.states) note(value);
    return value;
  }

  template <class F>
  static double value_of(F f) {
    if constexpr (std::is_void_v<std::invoke_result_t<F>>)
      return f(), 0;
    else
      return static_cast<double>(f());
  }

  /// A pass that lacked room is made once more with more of it; measures take none. An allocation that fails
  /// ends the adaptation, but loses nothing: operators take what they need before they change anything.
  template <class F>
  double make(F f) try {
    const bool was_full = mesh_.is_full() && !mesh_.grow();
    double value = value_of(f);
    while (!was_full && mesh_.is_full() && mesh_.grow()) value += value_of(f);
    return value;
  } catch (const std::bad_alloc&) {
    if (!options_.out_of_memory || !links_hold(mesh_)) throw;
    options_.out_of_memory();
    return 0;
  }

  bool replays() const { return next_pass_ < passes_.size(); }

  /// While passes are told: of the one that was told last, as the mesh is that of the end.
  const PassResult& told() const { return passes_[next_pass_ > 0 ? next_pass_ - 1 : 0]; }
  std::uint64_t live_tets() const { return replays() ? told().tets : workers_.live_tets(); }
  std::uint64_t tet_slots() const { return replays() ? told().tet_slots : mesh_.tet_slots(); }
  bool interrupted() const { return !replays() && workers_.interrupted(); }

  /// A pass that an interruption has cut short is none to go on from.
  void note(double value) {
    passes_.push_back({value, workers_.live_tets(), mesh_.tet_slots()});
    next_pass_ = passes_.size();
    if (!workers_.interrupted() && options_.states->wanted())
      options_.states->keep([this] { return state(); });
  }

  AdaptationState state() const {
    AdaptationState state;
    state.mesh = to_arrays(mesh_);
    state.passes = passes_;
    for (const StageReport& s : report_.stages)
      state.stages.push_back({s.name, s.seconds, s.vertices, s.tets, s.counts});
    state.seconds = seconds_of_stage();
    workers_.save(state);
    return state;
  }

  void go_on_from(const AdaptationState& state) {
    passes_ = state.passes;
    for (const StageDone& s : state.stages)
      done_before_.push_back({s.name, s.seconds, s.vertices, s.tets, s.counts});
    seconds_before_ = state.seconds;
    workers_.restore(state);
  }

  std::uint64_t split() {
    return changes([&] { return split_pass(workers_); });
  }
  std::uint64_t collapse() {
    return changes([&] { return collapse_pass(workers_); });
  }
  std::uint64_t smooth() {
    return changes([&] { return smooth_pass(workers_); });
  }
  std::uint64_t smooth_and_collapse() {
    return changes([&] { return smooth_and_collapse_pass(workers_); });
  }
  std::uint64_t swap(double quality, double quality_at_frozen = 1) {
    return changes([&] { return swap_pass(workers_, quality, quality_at_frozen); });
  }
  template <class F>
  std::uint64_t changes(F f) {
    return static_cast<std::uint64_t>(pass(f));
  }

  // --- The order

  FrozenPolicy frozen_policy() const {
    return options_.tets_at_frozen_stay ? FrozenPolicy::untouchable : FrozenPolicy::claimable;
  }

  double tets() const { return static_cast<double>(live_tets()); }

  /// What is fresh is looked at in a mesh that has its size already.
  void predict() {
    expected_tets_ = extent_ == Extent::fresh  ? tets()
                     : options_.complexity > 0 ? kTetsOfUnitVolume * options_.complexity
                                               : count_wanted_tets();
    const PredictedWork work = predict_work(tets(), expected_tets_);
    meter_.spend(work.import);
    meter_.expect(work.sum() - work.import);
    workers_.watch([this](double share) { tell_progress(share); });
  }

  /// The pass before it is over. `work_of_tet`: predicted for each tet, in the units of work.h.
  void begin_pass(double work_of_tet) {
    end_pass();
    tets_before_pass_ = live_tets();
    pass_work_ = work_of_tet * tets();
    tell_progress(0);
  }

  void end_pass() {
    meter_.spend(pass_work_);
    pass_work_ = 0;
  }

  /// A hundred times in all rather than after every few tets.
  void tell_progress(double share_of_pass) {
    constexpr double kStep = 0.005;
    if (!options_.progress || replays()) return;
    const double share = meter_.share(share_of_pass * pass_work_);
    if (share_of_pass > 0 && share < told_share_ + kStep) return;
    told_share_ = share;
    options_.progress(stage_, share, tets_before_pass_);
  }

  /// What is left after the creation of points.
  double left_after_creation() const {
    const PredictedWork work = predict_work(tets(), std::max(expected_tets_, tets()));
    return work.reconnect + work.improve + work.output;
  }

  /// What is left of creation when `rounds` more are needed at this level, and of all that comes after it.
  void expect_rounds(double rounds, double level) {
    constexpr double kRoundsOfLevel = 2.5;
    double left = rounds * work::kRound * tets() + left_after_creation();
    for (double finer = level / 2; finer >= 1; finer /= 2)
      left += kRoundsOfLevel * work::kRound * std::max(tets(), expected_tets_ / (finer * finer * finer));
    meter_.expect(left);
  }

  void start() {
    if (extent_ == Extent::fresh) judge_poor();
    mark_what_is_wrong();
    const Limits wanted = kernel_.limits;
    times_too_coarse_ =
        share_long_ > kCoarse || first_level_ > 1 ? pass([&] { return coarseness_of_curved_boundary(); }) : 1;
    let_bulge(wanted, first_level_);
    if (share_long_ > kCoarse) resolve_curved_boundary();
    kernel_.limits = wanted;
    if (first_level_ > 1) judge_by(MetricMean::log_euclidean);
    begin_pass(predict_work(tets(), expected_tets_).collapse / std::max(1.0, tets()));
    collapse();
    end_pass();
    collapse();
    close_holes();
    const PredictedWork left = predict_work(tets(), std::max(expected_tets_, tets()));
    meter_.expect(left.create + left.reconnect + left.improve + left.output);
  }

  /// Vertices of the input may be off the model; those in the way of which a tet is at first come later.
  void snap_to_model() {
    constexpr int kMostRounds = 4;
    for (int round = 0; round < kMostRounds && !interrupted(); ++round)
      if (pass([&] { return snap_pass(workers_); }) == 0) return;
  }

  /// A coarse mesh on a curved boundary first gets its boundary right, judged by plain shapes: in the metric
  /// its tets are still needles, and splits along the boundary would be refused for making them thinner
  /// still.
  void resolve_curved_boundary() {
    constexpr int kMostRounds = 15;
    judge_by(MetricMean::euclidean);
    bool any = false;
    for (int round = 0; round < kMostRounds && !interrupted(); ++round) {
      if (pass([&] { return resolve_curved_pass(workers_); }) == 0) break;
      any = true;
      swap(kSwapBelowWhileCreating);
      smooth();
    }
    judge_by(MetricMean::arithmetic);
    if (any) mark_what_is_wrong();
  }

  /// Longest edges first: levels of twice the wanted size, four times and so on come before it, each with its
  /// points well spread, so that a mesh that is far too coarse in one direction never becomes a heap of
  /// needles. Where the mesh is far from the metric and too fine for a level, it is made as coarse as that:
  /// in few tets the directions of the metric are found quickly (a uniform box of 83,000 tets to polar-2 at
  /// 100,000: half the time, Q 1 % 0.72 instead of 0.70).
  void create_points() {
    const Limits wanted = kernel_.limits;
    renumbered_at_ = tet_slots();
    for (double level = first_level_; level >= 1 && !interrupted(); level *= 0.5) {
      announce_level(level);
      kernel_.limits.long_edge = wanted.long_edge * level;
      kernel_.limits.split_shortest = wanted.split_shortest * level;
      kernel_.limits.collapse_longest = wanted.collapse_longest * level;
      let_bulge(wanted, level);
      if (level < first_level_) retry_curved_boundary();
      if (level == 1 && first_level_ > 1) judge_by(MetricMean::arithmetic);
      const bool coarsens = level > 1 && is_too_fine_for(level);
      if (coarsens) coarsen(wanted.short_edge * level);
      refine_to_level(level);
      if (coarsens) polish(work::kReconnect[0]);
      if (level > 2) mend_while_few();
      kernel_.limits.short_edge = wanted.short_edge;
      if (level > 1) mark_later();
    }
    kernel_.limits = wanted;
  }

  /// Needles that a coarse level leaves are refined by all later ones into a heap that nothing mends any
  /// more; among the few tets of that level it is quickly mended. The delta wing's mesh of 326 tets to the
  /// Mach number: in 7 of 12 complexities from 5,000 to 45,000 there was a heap, Q min .01 to .2 and up to
  /// four times the time; now in none.
  void mend_while_few() {
    constexpr double kFew = 1.0 / 32, kMostPoor = 0.05;  // of the wanted tets; of those there are
    constexpr int kMostRounds = 3;
    if (tets() >= kFew * pass([&] { return count_wanted_tets(); })) return;
    for (int round = 0; round < kMostRounds && !interrupted(); ++round) {
      if (pass([&] { return count_poor(kRepairBelow); }) <= kMostPoor * tets()) return;
      polish(work::kReconnect[0]);
    }
  }

  /// The boundary is as exact as edges of a level's length make it, and not yet as exact as wanted: its
  /// triangles would stand beside long chords. But where long edges are so in one direction only, nothing is
  /// gained: later it is divided among needles. A boundary that is little too coarse is exact before the last
  /// level.
  void let_bulge(const Limits& wanted, double level) {
    constexpr double kLittle = 2;
    const double exact_from = times_too_coarse_ < kLittle ? 2 : 1;
    const double times = level > exact_from ? std::min(level, times_too_coarse_) : 1;
    kernel_.limits.hausd = wanted.hausd * times * times;
    kernel_.limits.details = wanted.details * times * times;
    kernel_.limits.largest_bulge = wanted.largest_bulge * times;
  }

  /// How many times an edge of curved boundary is as long as the largest size wanted at its ends; at least 1,
  /// and 1 where most of it is exact already, and must stay so.
  double coarseness_of_curved_boundary() const {
    constexpr double kFew = 0.02, kClearly = 1.5;
    double off = 0, all = 0;
    const auto largest_size = [&](VertexId v) {
      const Eigen3 e = eigen_decomposition(mesh_.metric(v));
      return 1 / std::sqrt(*std::min_element(e.values.begin(), e.values.end()));
    };
    double most = 1;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i) {
      const TetId t(i);
      if (!mesh_.alive(t)) continue;
      for (int f = 0; f < 4; ++f) {
        const PatchId patch = mesh_.patch(t, f);
        if (!patch.valid() || kernel_.surface.patches()[patch.value].planar) continue;
        off += surface_deviation(mesh_, kernel_.surface, patch, t, f) > kClearly * kernel_.hausd(patch);
        ++all;
        for (int k = 0; k < 3; ++k) {
          const VertexId a = mesh_.vertex(t, kTetFaces[f][k]), b = mesh_.vertex(t, kTetFaces[f][(k + 1) % 3]);
          most = std::max(most,
                          norm(mesh_.point(b) - mesh_.point(a)) / std::min(largest_size(a), largest_size(b)));
        }
      }
    }
    return off > kFew * all ? most : 1;
  }

  /// Not where few tets would be left: they could not follow the domain.
  bool is_too_fine_for(double level) const {
    constexpr double kFewTets = 100;
    const double tets_of_level = wanted_tets_ / (level * level * level);
    return tets_of_level > kFewTets && tets_of_level < tets_of_far_mesh_;
  }

  void coarsen(double short_edge) {
    kernel_.limits.short_edge = short_edge;
    pass([&] {
      for (std::uint32_t i = 0; i < mesh_.vertex_slots(); ++i)
        if (mesh_.alive(VertexId(i))) mesh_.mark(VertexId(i), kCheckShort);
    });
    collapse();
    collapse();
    close_holes();
  }

  /// What is left of a mesh that has become much coarser is far apart in memory.
  void close_holes() {
    if (leaves_at_once() || !many_holes()) return;
    renumber();
    renumbered_at_ = tet_slots();
  }

  void announce_level(double level) {
    if (level > next_level_) return;  // it was, before this adaptation has started again
    next_level_ = level / 2;
    if (!before_level_) return;
    before_level_(kernel_.limits.finest_long_edge * level, kernel_.policy.mean);
  }

  void refine_to_level(double level) {
    constexpr int kMostRounds = 10;
    for (int round = 0; round < kMostRounds && !interrupted(); ++round) {
      begin_pass(work::kSplit);
      const std::uint64_t splits = split();
      end_pass();
      if (splits * 50 < live_tets()) return;
      if (level == 1) expected_tets_ = tets();  // most of the splits there are have been made
      expect_rounds(work::rounds_after(splits, tets()) + 1 - work::kSplit / work::kRound, level);
      begin_pass(work::kCollapse);
      collapse();
      begin_pass(work::kSwap);
      swap(kSwapBelowWhileCreating);
      begin_pass(work::kSmoothAndCollapse);
      smooth_and_collapse();
      end_pass();
      renumber_if_grown(kGrown);
    }
  }

  void reconnect_and_smooth() {
    constexpr std::size_t kRoundsWithLengths = 4;
    // A vertex near a long edge of curved boundary would keep it from being split for ever, most often a
    // circle at which two subdomains met: the new vertex takes the near one in, in the rounds that follow.
    constexpr std::size_t kCrowdedSplitsFrom = 1;
    constexpr double kOfCrowded = 0.2;
    const double shortest_at_curved = kernel_.limits.shortest_at_curved;
    renumber_if_grown(kGrownALittle);
    for (std::size_t round = 0; round < work::kReconnect.size() && !interrupted(); ++round) {
      end_pass();
      const PredictedWork last = predict_work(tets(), tets());
      meter_.expect(work::reconnection(round, tets()) + last.improve + last.output);
      if (round == kCrowdedSplitsFrom) kernel_.limits.shortest_at_curved *= kOfCrowded;
      if (round < kRoundsWithLengths)
        polish(work::kReconnect[round]);
      else
        polish_quality(work::kReconnect[round]);
    }
    kernel_.limits.shortest_at_curved = shortest_at_curved;
  }

  void polish(double work_of_tet) {
    begin_pass(0.45 * work_of_tet);
    swap_for_quality();
    begin_pass(0.5 * work_of_tet);
    smooth_and_collapse();
    retry_curved_boundary();
    begin_pass(0.05 * work_of_tet);
    split();
  }

  void polish_quality(double work_of_tet) {
    begin_pass(0.5 * work_of_tet);
    swap_for_quality();
    begin_pass(0.5 * work_of_tet);
    smooth();
  }

  void swap_for_quality() { swap(kSwapBelow, extent_ == Extent::everything ? kSwapBelowAtFrozen : 1); }

  /// Boundary edges that curve too much may have been refused where the tets were poor; now they are better.
  void retry_curved_boundary() {
    const auto patches = kernel_.surface.patches();
    if (std::all_of(patches.begin(), patches.end(), [](const Patch& p) { return p.planar; })) return;
    for_all_tets([&](TetId t) {
      if (on_curved_boundary(mesh_.vertices(t))) mesh_.mark(t, kCheckLong);
    });
  }

  /// Tets at frozen vertices can be left to the adaptation that finds them thawed: among them are those that
  /// the frozen boundary makes poor whatever is done (a fifth of the time, 77,000 changes in vain, on
  /// cube-polar2 to 500,000 in 128 subdomains). Where most of the mesh is poor, no mesh fits the metric, and
  /// the time is that of one round.
  void improve_quality() {
    constexpr int kMostRounds = 6;
    constexpr double kMostLooks = 0.5;  // at poor tets, as a share of all
    if (!options_.repair_at_frozen) kernel_.policy.frozen = FrozenPolicy::untouchable;
    kernel_.policy.mean = MetricMean::log_euclidean;
    for_all_tets([&](TetId t) { mark_if_poor(t); });
    double looks = 0;
    for (int round = 0; round < kMostRounds && looks < kMostLooks * tets() && !interrupted(); ++round) {
      looks += pass([&] { return count_poor(kRepairBelow); });
      if (pass([&] { return improve_pass(workers_, kRepairBelow); }) == 0) return;
      pass([&] { return smooth_poor(workers_, kRepairBelow); });
      collapse();
    }
  }

  /// Where a coarse mesh has met a metric that turns from one place to the next, points have been created
  /// along wrong directions, and stand in each other's way. Where most tets are at frozen vertices it is
  /// these that nothing fits, and another start meets them again (cube-polar2 to 200,000 in 1,024 subdomains:
  /// .31 s instead of .14 for the worst of them, the same quality in the end).
  bool fits_badly() {
    if (extent_ != Extent::everything || interrupted()) return false;
    if (pass([&] { return count_poor(kShiftBelow); }) <= kMisfitShare * tets()) return false;
    return pass([&] { return count_at_frozen(); }) <= 0.5 * tets();
  }

  /// In a mesh that has its size about everywhere, each level finds the directions that the first time had to
  /// guess (a slab of 12 tets with random tensors, to 20,000: Q mean 0.78 instead of 0.53, in a quarter of
  /// the time, for there is less to improve).
  void start_again() {
    start();
    create_points();
    reconnect_and_smooth();
  }

  double count_poor(double quality) const {
    double poor = 0;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i)
      poor += mesh_.alive(TetId(i)) && mesh_.quality(TetId(i)) < quality;
    return poor;
  }

  double count_at_frozen() const {
    double at_frozen = 0;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i)
      at_frozen += mesh_.alive(TetId(i)) && mesh_.has_frozen(TetId(i));
    return at_frozen;
  }

  /// All has been judged before; the poor ones by the other mean, in the last improvement.
  void judge_poor() {
    kernel_.policy.mean = MetricMean::arithmetic;
    for_all_tets([&](TetId t) {
      if (mesh_.quality(t) < kRepairBelow + 0.1) cache_quality(t);
    });
  }

  /// Switches the judges' mean and brings all cached qualities up to date.
  void judge_by(MetricMean mean) {
    kernel_.policy.mean = mean;
    for_all_tets([&](TetId t) { cache_quality(t); });
  }

  /// The two means differ little: only tets that are poor or nearly so by the cheap one are judged by the
  /// exact one.
  void mark_if_poor(TetId t) {
    if (mesh_.quality(t) > kRepairBelow + 0.1) return;
    cache_quality(t);
    if (mesh_.quality(t) < kRepairBelow) mesh_.mark(t, kCheckPoor);
  }

  void cache_quality(TetId t) {
    mesh_.set_quality(t, static_cast<float>(judge_quality(kernel_.policy.mean, mesh_, mesh_.vertices(t))));
  }

  template <class F>
  void for_all_tets(F f) {
    pass([&] {
      if (leaves_at_once()) return;
      workers_.run([&] {
        tbb::parallel_for(0u, mesh_.tet_slots(), [&](std::uint32_t i) {
          if (mesh_.alive(TetId(i))) f(TetId(i));
        });
      });
    });
  }

  /// What was put off for a finer level is now to be looked at.
  void mark_later() {
    for_all_tets([&](TetId t) {
      if (mesh_.take_marks(t, kLongLater)) mesh_.mark(t, kCheckLong);
    });
  }

  /// The first work lists: long and short edges, tets that are not fair; everything where the mesh as a whole
  /// is not good.
  void mark_what_is_wrong() {
    if (extent_ == Extent::fresh)
      for_all_tets([&](TetId t) {
        if (mesh_.take_marks(t, kFresh)) mark_fresh(t);
      });
    else
      mark_wherever_wrong();
    first_level_ = pass([&] { return first_level(); });
    share_long_ = pass([&] { return count_wrong(); });
    report_.share_wrong = pass([&] { return report_.share_wrong; });
  }

  /// Returns the share with long edges, and notes that of all that are wrong.
  double count_wrong() {
    std::uint64_t with_long = 0, wrong = 0;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i) {
      with_long += (mesh_.marks(TetId(i)) & kCheckLong) != 0;
      wrong += is_marked_wrong(TetId(i));
    }
    const auto all = static_cast<double>(std::max<std::uint64_t>(workers_.live_tets(), 1));
    report_.share_wrong = static_cast<double>(wrong) / all;
    return static_cast<double>(with_long) / all;
  }

  /// Not only because it lies on a curved boundary, which is looked at in any case.
  bool is_marked_wrong(TetId t) const {
    const std::uint8_t marks = mesh_.marks(t);
    return marks & (kCheckSwap | kCheckPoor) ||
           (marks & kCheckLong && !on_curved_boundary(mesh_.vertices(t)));
  }

  double sum_of_qualities() const {
    double sum = 0;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i)
      if (mesh_.alive(TetId(i))) sum += mesh_.quality(TetId(i));
    return sum;
  }

  void mark_wherever_wrong() {
    look_at_all();
    const double sum = pass([&] { return sum_of_qualities(); });
    const double fair = sum < kGoodMean * tets() ? 2 : kFair;
    if (options_.coarsen && sum < kFarMean * tets()) {
      tets_of_far_mesh_ = tets();
      wanted_tets_ = pass([&] { return count_wanted_tets(); });
    }
    for_all_tets([&](TetId t) {
      if (mesh_.quality(t) < fair) mark_poor(t, mesh_.vertices(t));
    });
  }

  /// Caches all qualities by the arithmetic mean and marks what is too long or too short: one look at each.
  void look_at_all() {
    kernel_.policy.mean = MetricMean::arithmetic;
    pass([&] {
      if (leaves_at_once()) return;
      workers_.run([&] {
        tbb::parallel_for(
            tbb::blocked_range<std::uint32_t>(0, mesh_.tet_slots(), 1024), [&](const auto& range) {
              TetBatch batch(mesh_, kernel_.limits.short_edge, kernel_.limits.long_edge);
              const auto take = [&] { batch.take([&](const SeenTet& seen) { note_first_look(seen); }); };
              for (std::uint32_t i = range.begin(); i < range.end(); ++i) {
                if (!mesh_.alive(TetId(i))) continue;
                batch.add(TetId(i));
                if (batch.full()) take();
              }
              take();
            });
      });
    });
  }

  void note_first_look(const SeenTet& seen) {
    const TetVertices& v = seen.vertices;
    mesh_.set_quality(seen.tet, static_cast<float>(seen.quality));
    mesh_.take_marks(seen.tet, kFresh);
    mark_lengths(seen.tet, v, seen.has_long_edge, seen.short_edges);
  }

  /// Bit e of `short_edges`: kTetEdges[e].
  void mark_lengths(TetId t, const TetVertices& v, bool has_long_edge, unsigned short_edges) {
    for (const VertexId x : v) mesh_.take_marks(x, kStuck);
    if (has_long_edge || on_curved_boundary(v)) mesh_.mark(t, kCheckLong);
    for (std::size_t e = 0; short_edges >> e != 0; ++e)
      if (short_edges >> e & 1)
        for (int end = 0; end < 2; ++end) mesh_.mark(v[kTetEdges[e][end]], kCheckShort);
  }

  /// What a mesh that conforms has, where limits are those of a coarser one: that.
  double count_wanted_tets() const {
    const double coarseness = kernel_.limits.finest_long_edge / Limits().finest_long_edge;
    double volume = 0;
    for (std::uint32_t i = 0; i < mesh_.tet_slots(); ++i)
      if (mesh_.alive(TetId(i))) {
        const TetVertices v = mesh_.vertices(TetId(i));
        double density = 0;
        for (const VertexId x : v) density += 0.25 * std::exp(0.5 * trace(mesh_.log_metric(x)));
        volume += density / 6 *
                  six_volume(mesh_.point(v[0]), mesh_.point(v[1]), mesh_.point(v[2]), mesh_.point(v[3]));
      }
    return kTetsOfUnitVolume * volume / (coarseness * coarseness * coarseness);
  }

  /// As if a look at all had come upon it, in a mesh that is not good.
  void mark_fresh(TetId t) {
    const TetVertices v = mesh_.vertices(t);
    bool has_long_edge = false;
    unsigned short_edges = 0;
    for (unsigned e = 0; e < kTetEdges.size(); ++e) {
      const MetricLength length = edge_between(mesh_, v[kTetEdges[e][0]], v[kTetEdges[e][1]]);
      has_long_edge |= length.above(kernel_.limits.long_edge);
      if (length.below(kernel_.limits.short_edge)) short_edges |= 1u << e;
    }
    mark_lengths(t, v, has_long_edge, short_edges);
    mark_poor(t, v);
  }

  void mark_poor(TetId t, const TetVertices& v) {
    mesh_.mark(t, kCheckSwap | kCheckPoor);
    for (const VertexId x : v) mesh_.mark(x, kCheckPlace);
  }

  bool on_curved_boundary(const TetVertices& v) const {
    return std::count_if(v.begin(), v.end(), [&](VertexId x) { return mesh_.flags(x) & kOnCurved; }) > 1;
  }

  /// The power of two that makes the longest edge at most twice too long at the first level.
  double first_level() {
    const double longest = workers_.run([&] {
      return tbb::parallel_reduce(
          tbb::blocked_range<std::uint32_t>(0, mesh_.tet_slots()), 1.0,
          [&](const tbb::blocked_range<std::uint32_t>& r, double longest_yet) {
            for (std::uint32_t i = r.begin(); i < r.end(); ++i) {
              if (!(mesh_.marks(TetId(i)) & kCheckLong)) continue;
              const TetVertices v = mesh_.vertices(TetId(i));
              for (const auto& e : kTetEdges)
                longest_yet = std::max(longest_yet, length_between(mesh_, v[e[0]], v[e[1]]));
            }
            return longest_yet;
          },
          [](double a, double b) { return std::max(a, b); });
    });
    return std::exp2(std::clamp(std::floor(std::log2(longest / kernel_.limits.long_edge)), 0.0, 60.0));
  }

  /// New entities stand at the end of the arrays: once they are many, order is restored, before the rounds of
  /// reconnection once they are some.
  static constexpr double kGrown = 1.4, kGrownALittle = 1.1;
  void renumber_if_grown(double factor) {
    if (leaves_at_once() || static_cast<double>(tet_slots()) < factor * static_cast<double>(renumbered_at_))
      return;
    renumber();
    renumbered_at_ = tet_slots();
  }

  /// A mesh in good order in which little was changed stays in it, with some holes. Records of a model's
  /// vertices go by places without holes.
  bool keeps_order() const {
    constexpr double kLittle = 0.02;
    if (kernel_.surface.model()) return false;
    std::uint64_t changes = 0;
    for (const Operator op : {Operator::split, Operator::collapse, Operator::swap_edge, Operator::swap_face})
      changes += report_.counts(op, Verdict::accepted);
    return static_cast<double>(changes) < kLittle * static_cast<double>(workers_.live_tets()) &&
           is_in_order(mesh_);
  }

  bool lacks_order() {
    if (extent_ != Extent::everything) return many_holes();
    if (leaves_at_once() && !kernel_.surface.model()) return false;
    return !pass([&] { return keeps_order(); });
  }

  /// Whoever ends a run early waits for the mesh: nothing is done any more that does not make it valid. Parts
  /// of a mesh may be gone on with, by somebody who has ended this adaptation only.
  bool leaves_at_once() const { return extent_ == Extent::everything && interrupted(); }

  bool many_holes() const { return tet_slots() > live_tets() + live_tets() / 4; }

  void renumber() {
    was_renumbered_ = true;
    pass([&] {
      workers_.run([&] {
        renumber_along_curve(mesh_);
        workers_.forget_free_slots();
      });
    });
  }

  Kernel& kernel_;
  TetMesh& mesh_;
  WorkerPool workers_;
  const AdaptOptions& options_;
  const Extent extent_;
  AdaptReport& report_;
  const BeforeLevel& before_level_;
  std::string stage_;
  WorkMeter meter_;
  std::uint64_t tets_before_pass_ = 0;
  double pass_work_ = 0, told_share_ = 0;
  double expected_tets_ = 0;  ///< in the end, as far as is known now
  double first_level_ = 1, share_long_ = 0;
  double next_level_ = std::numeric_limits<double>::infinity();  ///< the coarsest that was not announced
  double times_too_coarse_ = 1;                                  ///< coarseness_of_curved_boundary()
  double tets_of_far_mesh_ = 0;  ///< at the start; 0 for a mesh that is not far from its metric
  double wanted_tets_ = 0;
  std::uint64_t renumbered_at_ = 0;
  bool was_renumbered_ = false;

  std::vector<PassResult> passes_;  ///< made, and kept as far as states are
  std::size_t next_pass_ = 0;       ///< of them, to be told; as many as there are: passes are made
  std::vector<StageReport> done_before_;
  double seconds_before_ = 0;  ///< of the stage that was not done
  Clock::time_point stage_begin_;
};

}  // namespace

void adapt_in_place(Kernel& kernel, const AdaptOptions& options, Extent extent, AdaptReport& report,
                    const BeforeLevel& before_level) {
  Adaptation(kernel, options, extent, report, before_level).run();
}

}  // namespace weft::meshing
