// The nodes of a subdomain's graph, and the graph.
#include "graph/adaptation/subdomain_task.h"

#include <algorithm>
#include <utility>

#include "engine/base/text.h"
#include "meshing/metric/expectations.h"
#include "partition/distribute/distribute.h"
#include "partition/subdomain/adapt_subdomain.h"

namespace weft::graph::adaptation {

using dataflow::Arrival;
using dataflow::NodeContext;
using partition::SubdomainId;

namespace {

/// Of the tets of a subdomain, those that a shift of all its interface brings and makes worth looking at; and
/// what joining parcels without tets takes, as a share of adapting all.
constexpr double kShareShifted = 0.3, kShareWithoutShift = 0.01;

template <class Value>
std::vector<Value> values_of(std::vector<Arrival<Value>>& arrivals) {
  std::vector<Value> values;
  for (auto& a : arrivals) values.push_back(std::move(a.value));
  return values;
}

/// The first subdomain whose home is this rank.
std::uint32_t first_of(const AdaptationPlan& plan, int ranks, int home) {
  const std::uint64_t share = std::uint64_t{plan.subdomains} * static_cast<std::uint64_t>(home);
  return static_cast<std::uint32_t>((share + static_cast<std::uint64_t>(ranks) - 1) /
                                    static_cast<std::uint64_t>(ranks));
}

}  // namespace

const Phase& AdaptationPlan::phase_of(std::uint64_t round) const {
  const auto later = [](std::uint64_t r, const Phase& phase) { return r < phase.first_round; };
  return *std::prev(std::upper_bound(phases.begin(), phases.end(), round, later));
}

PartsOf AdaptationPlan::parts_with(SubdomainId subdomain) const {
  if (seeds.empty()) return {subdomain, 1};
  const auto next = std::ranges::upper_bound(seeds, subdomain);
  const std::uint32_t end = next == seeds.end() ? subdomains : next->value;
  return {*std::prev(next), end - std::prev(next)->value};
}

SubdomainTask::Ref object_of(const AdaptationPlan& plan, int ranks, SubdomainId subdomain) {
  if (plan.home_ranks > 0) ranks = plan.home_ranks;
  const int home = partition::home_rank(subdomain, plan.subdomains, ranks);
  return {engine::ObjectId{engine::Rank(home),
                           plan.first_object + (subdomain.value - first_of(plan, ranks, home))}};
}

std::optional<SubdomainId> subdomain_of(const AdaptationPlan& plan, int ranks, engine::ObjectId object) {
  if (plan.home_ranks > 0) ranks = plan.home_ranks;
  if (plan.first_object == 0 || object.number < plan.first_object) return {};  // 0: there is no plan yet
  const std::uint32_t subdomain =
      first_of(plan, ranks, object.home.value) + object.number - plan.first_object;
  if (subdomain >= first_of(plan, ranks, object.home.value + 1)) return {};
  return SubdomainId(subdomain);
}

SubdomainTask::SubdomainTask(partition::Subdomain subdomain, double predicted_tets)
    : subdomain_(std::move(subdomain)), predicted_tets_(predicted_tets) {
  news_.predicted_tets = predicted_tets;
}

std::string SubdomainTask::describe() const {
  const std::string step = news_.step == 0 ? "interior" : engine::text("shift ", news_.step);
  return engine::text(rests_ ? "at rest after " : "", step, ", ", news_.left.tets,
                      " tets after its last adaptation");
}

void SubdomainTask::tell(const RankData& rank) {
  if (!rank.news) return;
  rank.news->post(told_, news_);
  told_ = news_;
}

void SubdomainTask::tell_first(const RankData& rank) {
  told_.reset();
  tell(rank);
}

engine::Seconds SubdomainTask::seconds_to_adapt(double tets) {
  constexpr double kSecondsPerTet = 12e-6;
  return {kSecondsPerTet * tets};
}

dataflow::Blueprint<SubdomainTask> SubdomainTask::blueprint() {
  dataflow::Blueprint<SubdomainTask> g("subdomain");
  const auto interior = g.start<&SubdomainTask::adapt_interior>("adapt interior");
  const auto registered = g.event<&SubdomainTask::register_interface>("register interface");
  const auto division = g.node<&SubdomainTask::divide>("divide");
  g.start<&SubdomainTask::await_division>("await division");
  const auto proposal = g.start<&SubdomainTask::propose>("propose");
  const auto gathered = g.event<&SubdomainTask::gather>("gather");
  const auto woken = g.wakes<&SubdomainTask::wake>(gathered, "wake");
  const auto scattered = g.event<&SubdomainTask::scatter>("scatter");
  const auto shifted = g.node<&SubdomainTask::adapt_shifted>("adapt shifted");
  const auto updated = g.event<&SubdomainTask::update_topology>("update topology");
  g.remote<partition::InterfaceVertices>(interior, registered);
  g.local(registered, proposal);
  g.local(registered, division);
  g.remote<partition::Proposal>(proposal, gathered);
  g.local(woken, proposal);
  g.remote<partition::Parcel>(gathered, scattered);
  g.remote<partition::Parcel>(division, scattered);
  g.local(scattered, shifted);
  g.remote<partition::Notice>(scattered, updated);
  g.local(updated, proposal, dataflow::RoundStep::next);
  g.local(updated, interior, dataflow::RoundStep::next);
  g.local(updated, division, dataflow::RoundStep::next);
  return g;
}

const RankData& SubdomainTask::rank_data(NodeContext& context) const {
  return context.engine().local<RankData>();
}

std::vector<SubdomainTask::Ref> SubdomainTask::neighbours(NodeContext& context) const {
  std::vector<Ref> refs;
  for (const SubdomainId s : subdomain_.interface.neighbours())
    refs.push_back(object_of(rank_data(context).plan, context.ranks(), s));
  return refs;
}

/// A neighbour's proposal for this round wakes a subdomain that rests: the round has been released.
bool SubdomainTask::pauses_at(NodeContext& context, bool begins_phase) {
  const Pause here{context.round(), begins_phase};
  if (!rank_data(context).plan.pauses || here == released_ || woken_for_ == context.round()) return false;
  paused_ = here;
  return true;
}

std::optional<Pause> SubdomainTask::release() {
  if (paused_) released_ = *paused_;
  return std::exchange(paused_, std::nullopt);
}

/// What the subdomain is predicted to have in a round, for the balancer.
double SubdomainTask::tets_after(const RankData& rank, std::uint64_t round) const {
  const double factor = rank.plan.phase_of(round).coarseness;
  return predicted_tets_ / (factor * factor * factor);
}

/// All coarse phases and the first adaptation after them are one step for those who wait, which never goes
/// back.
void SubdomainTask::tell_done(const RankData& rank, std::uint64_t round, double done) {
  constexpr double kCoarsePart = 0.3;
  const std::uint64_t coarse_rounds = rank.plan.phases.back().first_round;
  if (coarse_rounds > 0 && news_.step == 0) {
    const double of_all = rank.plan.is_coarse(round) ? kCoarsePart * (static_cast<double>(round) + done) /
                                                           static_cast<double>(coarse_rounds)
                                                     : kCoarsePart + (1 - kCoarsePart) * done;
    done = std::max<double>(news_.done, of_all);
  }
  news_.done = static_cast<float>(done);
  tell(rank);
}

/// Before a later phase the interface has moved, and is as coarse as the mesh: it is refined like an input's.
void SubdomainTask::adapt_interior(NodeContext& context, BeginPhase) {
  if (pauses_at(context, true)) return;
  const RankData& rank = rank_data(context);
  const std::uint64_t round = context.round();
  if (round > 0) {
    partition::begin_next_phase(subdomain_);
    neighbourhood_wants_ = true;
  }
  tell(rank);
  partition::InterfaceRefinement refinement(subdomain_, *rank.geometry);
  meshing::BeforeLevel before_level;
  engine::TimePoint refining = 0;
  const bool makes_coarse = round == 0 && rank.plan.coarsens;
  if (rank.plan.refine_interface && !makes_coarse)
    before_level = [&](double long_edge, meshing::MetricMean mean) {
      const engine::TimePoint begin = engine::now();
      refinement.refine(partition::kLongAtInterface * long_edge, mean);
      refining += engine::now() - begin;
    };
  double coarseness = rank.plan.phase_of(round).coarseness;
  adapt(context, meshing::Extent::everything, coarseness, 0, before_level);
  while (coarseness > 1 && is_unfit_to_divide(rank.plan, round))
    adapt(context, meshing::Extent::everything, coarseness /= 2, 0, before_level);
  context.count("tets predicted", predicted_tets_);
  context.count("interface refinement, seconds", 1e-9 * static_cast<double>(refining));
  const std::vector<Ref> to = neighbours(context);
  std::vector<partition::InterfaceVertices> created = refinement.created();
  for (std::size_t i = 0; i < to.size(); ++i)
    context.send<&SubdomainTask::register_interface>(to[i], round, std::move(created[i]));
  context.expect<&SubdomainTask::register_interface>(round, to);
}

/// A coarse mesh of a thin domain, say, may fit no metric: its parts would have needles in their interfaces,
/// which would stay. One subdomain alone can do something about it, for none has to follow: it becomes finer,
/// and keeps all where that does not help.
bool SubdomainTask::is_unfit_to_divide(const AdaptationPlan& plan, std::uint64_t round) const {
  meshing::Nonconforming all = left_.plain;
  all += left_.flagged;
  return plan.division == round && plan.seeds.size() == 1 &&
         static_cast<double>(all.poor_tets) > meshing::kMisfitShare * static_cast<double>(all.tets);
}

std::variant<BeginShift, BeginDivision> SubdomainTask::register_interface(
    NodeContext& context, std::uint64_t round, std::vector<Arrival<partition::InterfaceVertices>> arrivals) {
  const RankData& rank = rank_data(context);
  partition::register_interface(subdomain_, *rank.geometry, values_of(arrivals));
  if (rank.plan.division == round) return BeginDivision{};
  return BeginShift{};
}

/// Hands parts of the mesh to the subdomains that wait for them. A round as of a shift, without proposals.
void SubdomainTask::divide(NodeContext& context, BeginDivision) {
  const AdaptationPlan& plan = rank_data(context).plan;
  const partition::Geometry& geometry = *rank_data(context).geometry;
  const std::uint64_t round = context.round();
  partition::DivisionOptions options = plan.division_options;
  options.num_parts = plan.parts_with(subdomain_.id).count;
  options.keeps_all = is_unfit_to_divide(plan, round);
  const std::vector<Ref> from = neighbours(context);
  shifts_.push_back({round});
  partition::Divided divided = partition::divide(subdomain_, options, &geometry.surface);
  division_warning_ = std::move(divided.warning);
  for (auto& [to, parcel] : divided.parcels) {
    shifts_.back().sent += parcel.tets.size();
    context.send<&SubdomainTask::scatter>(object_of(plan, context.ranks(), to), round, std::move(parcel));
  }
  context.expect<&SubdomainTask::scatter>(round, from);
  context.count("parts", options.num_parts);
  context.count("tets sent", static_cast<double>(shifts_.back().sent));
}

/// As a part of another subdomain, which has all until then.
void SubdomainTask::await_division(NodeContext& context, BeginDivision) {
  const AdaptationPlan& plan = rank_data(context).plan;
  subdomain_.phase = plan.index_of_phase(context.round());
  shifts_.push_back({context.round()});
  const Ref seed = object_of(plan, context.ranks(), plan.parts_with(subdomain_.id).first);
  context.expect<&SubdomainTask::scatter>(context.round(), {seed});
}

/// Poor tets at frozen vertices are repaired only where no later shift is to thaw them.
void SubdomainTask::adapt(NodeContext& context, meshing::Extent extent, double coarseness,
                          std::uint64_t next_shift, const meshing::BeforeLevel& before_level) {
  const RankData& rank = rank_data(context);
  const std::uint64_t round = context.round();
  const bool coarse = rank.plan.is_coarse(round);
  meshing::Limits limits;
  limits.hausd = rank.plan.hausd * coarseness * coarseness;  // as bulges of longer edges are
  limits.details = rank.plan.details * coarseness * coarseness;
  limits.largest_bulge *= coarseness;
  limits = limits.coarser(coarseness);
  meshing::AdaptOptions options;
  options.threads = rank.plan.threads;
  options.idle_threads = [&] { return context.engine().idle_workers(); };
  options.tets_at_frozen_stay = rank.plan.tets_at_frozen_stay;
  options.allowed = rank.plan.allowed;
  // An interface that is not to be moved soon would stay fine.
  options.coarsen = (rank.plan.coarsens && round == 0) || neighbours(context).empty();
  options.repair_at_frozen =
      !coarse && next_shift >= std::min<std::uint64_t>(rank.plan.most_shifts, partition::kRoundsForQuality);
  options.interrupt = rank.interrupt;
  options.out_of_memory = rank.out_of_memory;
  options.abandon = &context.stop_flag();
  std::optional<partition::InterfaceSnapshot> interface;
  if (rank.plan.pauses) interface.emplace(subdomain_);
  if (rank.news)  // to predict its work a mesh is looked at once more
    options.progress = [&](const std::string&, double done, std::uint64_t) { tell_done(rank, round, done); };
  partition::share_surface(subdomain_.surface, rank.shared->surface);
  subdomain_.background.share(rank.shared->background);
  if (rank.freed) rank.freed->give_back();
  const meshing::AdaptReport report =
      partition::adapt_subdomain(subdomain_, rank.geometry->surface, limits, extent, options, before_level);
  if (interface) interface->check(subdomain_);
  counts_ += report.counts;
  const bool same_tets = !shifts_.empty() && shifts_.back().sent + shifts_.back().received == 0;
  const engine::TimePoint begin = engine::now();
  if (!(same_tets && report.stages.empty())) left_ = partition::count_nonconforming(subdomain_);
  context.count("quality check, seconds", 1e-9 * static_cast<double>(engine::now() - begin));
  tell_log_what_is_left(context);
  if (!coarse) {
    news_.left = left_.plain;
    news_.left += left_.flagged;
  }
  tell_done(rank, round, 1);
}

/// The report shows it.
void SubdomainTask::tell_log_what_is_left(NodeContext& context) {
  const meshing::NonconformingParts& parts = left_;
  const auto count = [&](const char* name, std::uint64_t in_interior, std::uint64_t at_interface) {
    context.count(engine::text(name, ", interior"), static_cast<double>(in_interior));
    context.count(engine::text(name, ", interface"), static_cast<double>(at_interface));
  };
  count("tets", parts.plain.tets, parts.flagged.tets);
  count("poor tets", parts.plain.poor_tets, parts.flagged.poor_tets);
  count("long edges", parts.plain.long_edges, parts.flagged.long_edges);
  count("short edges", parts.plain.short_edges, parts.flagged.short_edges);
}

/// Who has more poor tets comes first, unless it has come to much more than its share of tets. Not while a
/// mesh becomes coarse, where a shift may hand over much of a subdomain, and in the two shifts after that
/// which move most: there it is who has fewest tets, and all become alike.
partition::Priority SubdomainTask::priority_in(const AdaptationPlan& plan, std::uint64_t round) const {
  constexpr std::uint64_t kShiftsOfMany = 2;
  constexpr double kFullFrom =
      2;  // times the prediction; 1.5 costs quality, 4 leaves subdomains of 4 times the work
  const bool fewest_first = plan.phases.size() > 1 && plan.shift_of(round) < kShiftsOfMany;
  const std::uint64_t tets = left_.plain.tets + left_.flagged.tets;
  if (fewest_first) return {~tets, subdomain_.id};
  const bool full = static_cast<double>(tets) > kFullFrom * predicted_tets_;
  return partition::priority_in(round, subdomain_.id, left_.plain.poor_tets + left_.flagged.poor_tets, full);
}

/// Tells the neighbours what this subdomain wants, unless neither it nor any of them wants anything: then it
/// rests.
void SubdomainTask::propose(NodeContext& context, BeginShift) {
  if (pauses_at(context, false)) return;
  const RankData& rank = rank_data(context);
  const std::uint64_t round = context.round(), shift = rank.plan.shift_of(round);
  const bool coarse = rank.plan.is_coarse(round);
  wants_.clear();
  const bool interrupted = rank.interrupt && rank.interrupt->load(std::memory_order_relaxed);
  const bool at_limit = !coarse && shift >= rank.plan.most_shifts;
  if (!interrupted) wants_ = partition::wanted(subdomain_, shift);
  if (at_limit) wanted_at_limit_ = std::exchange(wants_, {}).size();
  const bool goes_on = !wants_.empty() || neighbourhood_wants_ || woken_for_ == round;
  rests_ = at_limit || (!coarse && (!goes_on || subdomain_.interface.size() == 0));
  news_.rests = rests_;
  if (!rests_ && !coarse) news_.step = static_cast<std::uint32_t>(shift) + 1, news_.done = 0;
  tell(rank);
  if (rests_) return;
  priority_ = priority_in(rank.plan, round);
  std::vector<partition::Proposal> proposals = partition::propose(subdomain_, priority_, wants_);
  const std::vector<Ref> to = neighbours(context);
  for (std::size_t i = 0; i < to.size(); ++i)
    context.send<&SubdomainTask::gather>(to[i], round, std::move(proposals[i]));
  context.expect<&SubdomainTask::gather>(round, to);
  context.count("vertices wanted", static_cast<double>(wants_.size()));
}

/// What scattering and adapting take in a round that brings it the tets around so many vertices of its
/// interface. Most subdomains that give receive nothing, and are not worth moving to another rank.
engine::Seconds SubdomainTask::seconds_to_adapt_shifted(double tets, std::size_t vertices_received) const {
  const double share = static_cast<double>(vertices_received) /
                       static_cast<double>(std::max<std::size_t>(subdomain_.interface.size(), 1));
  return seconds_to_adapt((kShareWithoutShift + kShareShifted * share) * tets);
}

/// Where no phase ends. It has to be said: else the mean of the event's runs counts, and those that end
/// phases adapt all.
engine::Seconds SubdomainTask::seconds_to_update_topology() const {
  constexpr double kSeconds = 1e-5, kSecondsPerVertex = 3e-7;
  return {kSeconds + kSecondsPerVertex * static_cast<double>(subdomain_.interface.size())};
}

std::optional<BeginShift> SubdomainTask::wake(NodeContext&, std::uint64_t round) {
  woken_for_ = round;
  if (!rests_) return {};
  rests_ = false;
  return BeginShift{};
}

void SubdomainTask::gather(NodeContext& context, std::uint64_t round,
                           std::vector<Arrival<partition::Proposal>> arrivals) {
  const std::vector<partition::Proposal> proposals = values_of(arrivals);
  neighbourhood_wants_ = !wants_.empty();
  for (const partition::Proposal& p : proposals) neighbourhood_wants_ |= !p.wants.empty();
  const std::vector<Ref> to = neighbours(context);
  const RankData& rank = rank_data(context);
  const partition::ReceiverOrder order(priority_, partition::priorities_of(proposals));
  const engine::Seconds next = seconds_to_adapt_shifted(
      tets_after(rank, round), vertices_received(subdomain_, order, wants_, proposals));
  std::vector<partition::Parcel> parcels = partition::gather(
      subdomain_, priority_, wants_, proposals, rank.plan.shift.in_round(rank.plan.shift_of(round)));
  ShiftRecord record;
  record.round = round;
  record.wanted = wants_.size();
  for (std::size_t i = 0; i < to.size(); ++i) {
    record.sent += parcels[i].tets.size();
    context.send<&SubdomainTask::scatter>(to[i], round, std::move(parcels[i]));
  }
  shifts_.push_back(record);
  context.expect<&SubdomainTask::scatter>(round, to, next);
  context.count("tets sent", static_cast<double>(record.sent));
  context.count("colour", static_cast<double>(order.above_self()));
}

/// Nothing is adapted where all of it is to be next.
std::optional<engine::Nothing> SubdomainTask::scatter(NodeContext& context, std::uint64_t round,
                                                      std::vector<Arrival<partition::Parcel>> arrivals) {
  std::vector<partition::Parcel> parcels = values_of(arrivals);
  for (partition::Parcel& p : parcels) rank_data(context).shared->background.share(p.pieces);
  partition::Scattered result = partition::scatter(subdomain_, parcels);
  const RankData& rank = rank_data(context);
  const AdaptationPlan& plan = rank.plan;
  for (auto& [to, notice] : result.notices)
    context.send<&SubdomainTask::update_topology>(object_of(plan, context.ranks(), to), round,
                                                  std::move(notice));
  std::vector<Ref> from;
  for (const SubdomainId s : result.expected) from.push_back(object_of(plan, context.ranks(), s));
  const bool phase_ends = plan.begins_phase(round + 1);
  if (plan.division == round) predicted_tets_ = news_.predicted_tets = partition::predicted_tets(subdomain_);
  const engine::Seconds next =
      phase_ends ? seconds_to_adapt(tets_after(rank, round + 1)) : seconds_to_update_topology();
  context.expect<&SubdomainTask::update_topology>(round, from, next);
  shifts_.back().received = result.received;
  shifts_.back().thawed = result.thawed;
  context.count("tets received", static_cast<double>(result.received));
  if (phase_ends) return {};
  return engine::Nothing{};
}

void SubdomainTask::adapt_shifted(NodeContext& context) {
  const AdaptationPlan& plan = rank_data(context).plan;
  const std::uint64_t round = context.round();
  adapt(context, meshing::Extent::fresh, plan.phase_of(round).coarseness, plan.shift_of(round) + 1);
}

std::variant<BeginShift, BeginPhase, BeginDivision> SubdomainTask::update_topology(
    NodeContext& context, std::uint64_t round, std::vector<Arrival<partition::Notice>> arrivals) {
  context.count("vertices thawed",
                static_cast<double>(partition::update_topology(subdomain_, values_of(arrivals))));
  const AdaptationPlan& plan = rank_data(context).plan;
  if (plan.begins_phase(round + 1)) return BeginPhase{};
  if (plan.division == round + 1) return BeginDivision{};
  return BeginShift{};
}

}  // namespace weft::graph::adaptation
