// What a subdomain does: the task graph of the distributed method (the paper's figure of the algorithm), one
// instance a subdomain, which lives on whatever rank the balancer has put it.
//
//   adapt interior =>> register interface -> propose =>> gather =>> scatter -> adapt shifted
//        ^                                      ^                       =>>
//        |                                      +--- next shift --- update topology
//        +---------------- next phase --------------------------------+
//
// -> stays in the subdomain, =>> goes to its neighbours. A subdomain goes on as soon as its own neighbours'
// values are there: nothing is global. One that wants nothing, and whose neighbours want nothing, rests; a
// proposal for a later round wakes it. The run has ended when all rest.
//
// There is one phase; more where curved boundary is coarser than wanted, each finer than the one before,
// until the last is as one alone would be. All but the last have a fixed number of shifts, the same for all
// subdomains.
//
// Where the input has few tets, or is far from its metric, few subdomains have it at first. They make a
// coarse mesh of it, with their interface, which only shifts can make coarse, and divide:
//
//   update topology -> divide =>> scatter -> update topology -> adapt interior
//
// the last three in all subdomains: a division hands parts of a mesh to subdomains that have none ("await
// division"), as a shift does.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "graph/adaptation/freed_memory.h"
#include "graph/adaptation/progress.h"
#include "graph/dataflow/blueprint.h"
#include "partition/divide/divide.h"
#include "partition/refine/refine_interface.h"
#include "partition/shift/shift.h"
#include "partition/subdomain/geometry.h"
#include "partition/subdomain/shared_pieces.h"
#include "partition/subdomain/subdomain.h"
#include "partition/subdomain/surface_cover.h"
#include "partition/verify/check_subdomains.h"

namespace weft::graph::adaptation {

/// Rounds to one metric.
struct Phase {
  std::uint64_t first_round = 0;
  double coarseness = 1;  ///< how much longer than wanted its edges are; 1 in the last phase
};

/// A subdomain that is divided, and those with the next numbers: its parts.
struct PartsOf {
  partition::SubdomainId first;
  std::uint32_t count = 1;
};

/// Shifts at most, where the user says nothing.
inline constexpr std::uint32_t kMostShifts = 12;

/// How subdomains are adapted; the same on all ranks.
struct AdaptationPlan {
  std::uint32_t subdomains = 1;
  std::uint32_t first_object = 0;  ///< number of the first subdomain's object on every rank
  /// Ranks of the run that the subdomains were made in: their objects keep their names when it goes on from a
  /// checkpoint. 0: those of this run.
  int home_ranks = 0;
  std::uint32_t most_shifts = kMostShifts;
  partition::ShiftOptions shift;
  std::vector<Phase> phases{{0, 1}};
  bool coarsens = false;  ///< the first phase is coarser than the input
  /// Those that have tets at first, ascending; the others are parts of the one before them. Empty: all.
  std::vector<partition::SubdomainId> seeds;
  std::optional<std::uint64_t> division;        ///< the round, the last of a phase, in which the seeds divide
  partition::DivisionOptions division_options;  ///< but for the number of parts
  bool refine_interface = true;
  bool tets_at_frozen_stay = false;  ///< meshing::AdaptOptions
  meshing::AllowedOperations allowed = {};
  double hausd = 0;  ///< meshing::Limits, as `details`
  double details = 0;
  double expected_complexity = 0;  ///< of the whole result
  int threads = 1;                 ///< of this rank: an adaptation helps itself to those that are idle
  /// Every subdomain pauses after its interior adaptation and after every shift, until
  /// SubdomainTask::release: so a run of the engine ends there, and what subdomains have can be checked.
  bool pauses = false;

  const Phase& phase_of(std::uint64_t round) const;
  std::uint32_t index_of_phase(std::uint64_t round) const {
    return static_cast<std::uint32_t>(&phase_of(round) - phases.data());
  }
  /// The seed that the subdomain is a part of, or is.
  PartsOf parts_with(partition::SubdomainId subdomain) const;
  bool begins_phase(std::uint64_t round) const { return phase_of(round).first_round == round; }
  bool is_coarse(std::uint64_t round) const { return round < phases.back().first_round; }
  /// Of its phase, from 0.
  std::uint64_t shift_of(std::uint64_t round) const { return round - phase_of(round).first_round; }
};

/// Value of the start node of a phase.
struct BeginPhase {
  template <class Archive>
  void serialize(Archive&) {}
};
struct BeginShift {
  template <class Archive>
  void serialize(Archive&) {}
};
struct BeginDivision {
  template <class Archive>
  void serialize(Archive&) {}
};

/// Where a subdomain pauses: before it begins a phase or a shift.
struct Pause {
  std::uint64_t round = 0;
  bool begins_phase = true;
  friend bool operator==(const Pause&, const Pause&) = default;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(round, begins_phase);
  }
};

/// What several subdomains of a rank have, in one copy.
struct SharedByRank {
  partition::SharedPieces<meshing::SurfacePiece> surface;
  partition::SharedPieces<partition::BackgroundPiece> background;
};

/// What all subdomains of a rank read (engine::RuntimeOptions::local).
struct RankData {
  AdaptationPlan plan;
  std::shared_ptr<const partition::Geometry> geometry;
  std::shared_ptr<SharedByRank> shared;          ///< the pieces that its subdomains have
  FreedMemory* freed = nullptr;                  ///< of its process; null where ranks take turns in one
  const std::atomic<bool>* interrupt = nullptr;  ///< when true, subdomains finish with what they have
  std::function<void()> out_of_memory;           ///< sets `interrupt`
  ProgressBoard* news = nullptr;                 ///< where subdomains tell how far they are; null: nowhere
};

/// One round of one subdomain, for the report.
struct ShiftRecord {
  std::uint64_t round = 0;
  std::uint64_t wanted = 0;    ///< vertices that this subdomain wanted to be freed
  std::uint64_t sent = 0;      ///< tets
  std::uint64_t received = 0;  ///< tets
  std::uint64_t thawed = 0;    ///< vertices
};

class SubdomainTask {
 public:
  using Ref = dataflow::Ref<SubdomainTask>;

  SubdomainTask() = default;
  /// `predicted_tets`: of the adapted subdomain, for the balancer.
  SubdomainTask(partition::Subdomain subdomain, double predicted_tets);

  partition::Subdomain& subdomain() { return subdomain_; }
  const std::vector<ShiftRecord>& shifts() const { return shifts_; }
  const meshing::OperationCounts& counts() const { return counts_; }
  /// Vertices of the interface that it would have freed had there been more shifts.
  std::uint64_t wanted_at_limit() const { return wanted_at_limit_; }
  /// What is to be said of the parts that it was divided into; empty: nothing.
  const std::string& division_warning() const { return division_warning_; }
  const std::optional<Pause>& paused() const { return paused_; }
  /// Ends the pause that it has made (AdaptationPlan::pauses), if any; to be started there.
  std::optional<Pause> release();
  /// Tells the rank's board how far it is, in place of what it has told there or elsewhere.
  void tell(const RankData& rank);
  /// The same of one that comes from a checkpoint: in this run it has told nothing.
  void tell_first(const RankData& rank);
  /// How far it is, in words.
  std::string describe() const;

  static dataflow::Blueprint<SubdomainTask> blueprint();
  /// A first guess of what a whole adaptation costs; the balancer corrects it. `tets`: of the result.
  static engine::Seconds seconds_to_adapt(double tets);

  template <class Archive>
  void serialize(Archive& archive) {
    archive(subdomain_, predicted_tets_, wants_, priority_, neighbourhood_wants_, rests_, woken_for_, shifts_,
            counts_, left_, news_, told_, wanted_at_limit_, division_warning_, released_, paused_);
  }

  // The nodes.
  void adapt_interior(dataflow::NodeContext& context, BeginPhase);
  std::variant<BeginShift, BeginDivision> register_interface(
      dataflow::NodeContext& context, std::uint64_t round,
      std::vector<dataflow::Arrival<partition::InterfaceVertices>> arrivals);
  void divide(dataflow::NodeContext& context, BeginDivision);
  void await_division(dataflow::NodeContext& context, BeginDivision);
  void propose(dataflow::NodeContext& context, BeginShift);
  std::optional<BeginShift> wake(dataflow::NodeContext& context, std::uint64_t round);
  void gather(dataflow::NodeContext& context, std::uint64_t round,
              std::vector<dataflow::Arrival<partition::Proposal>> arrivals);
  std::optional<engine::Nothing> scatter(dataflow::NodeContext& context, std::uint64_t round,
                                         std::vector<dataflow::Arrival<partition::Parcel>> arrivals);
  void adapt_shifted(dataflow::NodeContext& context);
  std::variant<BeginShift, BeginPhase, BeginDivision> update_topology(
      dataflow::NodeContext& context, std::uint64_t round,
      std::vector<dataflow::Arrival<partition::Notice>> arrivals);

 private:
  const RankData& rank_data(dataflow::NodeContext& context) const;
  std::vector<Ref> neighbours(dataflow::NodeContext& context) const;
  bool pauses_at(dataflow::NodeContext& context, bool begins_phase);
  void adapt(dataflow::NodeContext& context, meshing::Extent extent, double coarseness,
             std::uint64_t next_shift, const meshing::BeforeLevel& before_level = {});
  bool is_unfit_to_divide(const AdaptationPlan& plan, std::uint64_t round) const;
  double tets_after(const RankData& rank, std::uint64_t round) const;
  void tell_done(const RankData& rank, std::uint64_t round, double done);
  engine::Seconds seconds_to_adapt_shifted(double tets, std::size_t vertices_received) const;
  engine::Seconds seconds_to_update_topology() const;
  partition::Priority priority_in(const AdaptationPlan& plan, std::uint64_t round) const;
  void tell_log_what_is_left(dataflow::NodeContext& context);

  static constexpr std::uint64_t kNever = ~std::uint64_t{0};

  partition::Subdomain subdomain_;
  double predicted_tets_ = 0;
  std::vector<partition::GlobalId> wants_;  ///< of this round
  partition::Priority priority_;            ///< of this round
  bool neighbourhood_wants_ = true;         ///< this subdomain or a neighbour wanted something last
  bool rests_ = false;
  std::uint64_t woken_for_ =
      kNever;  ///< a round that a neighbour has proposed while this one was in the last
  std::vector<ShiftRecord> shifts_;
  meshing::OperationCounts counts_;
  meshing::NonconformingParts left_;  ///< after the last adaptation
  SubdomainProgress news_;
  std::optional<SubdomainProgress> told_;  ///< the latest, on whatever rank
  std::uint64_t wanted_at_limit_ = 0;
  std::string division_warning_;
  Pause released_;               ///< the latest that it need not make any more: the first is over
  std::optional<Pause> paused_;  ///< now
};

/// The object of a subdomain: made on its home rank, in the order of their ids.
SubdomainTask::Ref object_of(const AdaptationPlan& plan, int ranks, partition::SubdomainId subdomain);
/// The subdomain of an object; none for an object that is no subdomain.
std::optional<partition::SubdomainId> subdomain_of(const AdaptationPlan& plan, int ranks,
                                                   engine::ObjectId object);

}  // namespace weft::graph::adaptation
