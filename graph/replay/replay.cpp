// The program that does a recorded graph again.
#include "graph/replay/replay.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/run/runtime.h"
#include "graph/dataflow/dump/critical_path.h"
#include "graph/replay/replay_plan.h"

namespace weft::graph::replay {
namespace {

using dataflow::GraphDump;
using engine::Blob;
using engine::Context;
using engine::MobilePtr;
using engine::Payload;
using engine::Rank;
using engine::TimePoint;

/// So many bytes as nobody needs: all share one block, which is never written.
Blob filler(std::uint64_t bytes) {
  static constexpr std::size_t kMost = std::size_t{1} << 32;
  static std::size_t size = 0;
  static std::shared_ptr<std::byte[]> zeros;
  bytes = std::min<std::uint64_t>(bytes, kMost);
  if (bytes > size) {
    size = bytes;
    zeros = std::shared_ptr<std::byte[]>(new std::byte[size]);
  }
  return Blob::share({zeros.get(), bytes}, zeros);
}

Payload message_of(std::uint64_t bytes) {
  Payload payload;
  if (bytes > 0) payload.segments.push_back(filler(bytes));
  return payload;
}

/// What all ranks share: they are in one process, and one of them runs at a time.
struct Shared {
  const ReplayOptions& options;
  ReplayPlan plan;
  std::vector<HandlerIndex> place_of;  ///< of a handler in its instance
  GraphDump graph;
  std::vector<Rank> rank_of;                         ///< of each instance, now
  std::vector<std::uint64_t> objects, most_objects;  ///< by rank
  std::size_t handled = 0;                           ///< handlers that have run

  std::size_t size() const { return plan.instances.size(); }
  /// Blocks of instances, as subdomains are placed.
  std::size_t home(std::size_t instance) const {
    return instance * static_cast<std::size_t>(options.ranks) / size();
  }
  std::size_t first_of(std::size_t home) const {
    const auto ranks = static_cast<std::size_t>(options.ranks);
    return (size() * home + ranks - 1) / ranks;
  }
  engine::ObjectId object(std::size_t instance) const {
    return {Rank(static_cast<int>(home(instance))),
            static_cast<std::uint32_t>(instance - first_of(home(instance)) + 1)};
  }
  void seen(std::uint32_t instance, Rank on) {
    if (rank_of[instance] == on) return;
    if (rank_of[instance].valid()) --objects[rank_of[instance].index()];
    rank_of[instance] = on;
    most_objects[on.index()] = std::max(most_objects[on.index()], ++objects[on.index()]);
  }
};

void spend(TimePoint time) { engine::VirtualTime::of_thread()->spend(time); }

/// An instance: does its handlers in their order, each when its values have come.
class Actor {
 public:
  Actor() = default;
  Actor(std::uint32_t instance, std::size_t handlers, std::uint64_t bytes)
      : instance_(instance), arrived_(handlers), ballast_(message_of(bytes)) {}

  template <class Archive>
  void serialize(Archive& archive) {
    archive(instance_, next_, asked_, arrived_, ballast_);
  }

  void start(Context& context) {
    shared(context).seen(instance_, context.rank());
    ask(context);
  }

  void arrive(Context& context, HandlerIndex handler, Payload) {
    const Shared& all = shared(context);
    ++arrived_.at(all.place_of[handler]);
    if (const auto wakes = all.plan.handlers[handler].wakes) ++arrived_.at(all.place_of[*wakes]);
    ask(context);
  }

  void handle(Context& context) {
    Shared& all = shared(context);
    all.seen(instance_, context.rank());
    for (const PlannedRun& run : all.plan.handlers[all.plan.instances[instance_][next_]].runs)
      work(context, run);
    ++next_;
    ++all.handled;
    asked_ = false;
    ask(context);
  }

 private:
  /// What the engine calls constant is what moves with no object.
  static Shared& shared(const Context& context) { return *context.local<Shared*>(); }

  /// The handler that is next runs by a message of its own, as in a real run.
  void ask(Context& context) {
    const Shared& all = shared(context);
    const std::vector<HandlerIndex>& mine = all.plan.instances[instance_];
    if (asked_ || next_ == mine.size() || arrived_[next_] < all.plan.handlers[mine[next_]].values) return;
    asked_ = true;
    context.invoke_expecting<&Actor::handle>(engine::Seconds{all.plan.handlers[mine[next_]].expected},
                                             MobilePtr<Actor>{context.self()});
  }

  void work(Context& context, const PlannedRun& run) {
    Shared& all = shared(context);
    dataflow::DumpedRun& record = all.graph.runs[run.run];
    record.rank = context.rank();
    record.begin = engine::now();
    TimePoint worked = 0;
    for (const PlannedSend& send : run.sends) {
      spend(send.after - std::exchange(worked, send.after));
      context.invoke<&Actor::arrive>(MobilePtr<Actor>{all.object(send.to)}, send.handler,
                                     message_of(send.bytes));
    }
    spend(run.works - worked);
    record.end = engine::now();
  }

  std::uint32_t instance_ = 0;
  std::uint32_t next_ = 0;              ///< place of the handler that is not over
  bool asked_ = false;                  ///< it has been asked to run
  std::vector<std::uint32_t> arrived_;  ///< values, by place
  Payload ballast_;                     ///< what makes it heavy on its way
};

void act(Shared& shared, engine::Transport& transport, Replayed& result) {
  engine::Registry registry;
  registry.type<Actor>(shared.graph.description.name)
      .method<&Actor::start>("start")
      .method<&Actor::arrive>("value")
      .method<&Actor::handle>("work");
  Shared* const local = &shared;
  engine::RuntimeOptions options{.threads = shared.options.threads, .balancer = shared.options.balancer};
  options.local = &local;
  options.trace.spans = shared.options.timelines;
  engine::Runtime runtime(transport, registry, std::move(options));
  const std::size_t home = transport.rank().index();
  runtime.run([&](Context& context) {
    for (std::size_t i = shared.first_of(home); i < shared.first_of(home + 1); ++i) {
      const auto actor = context.create<Actor>(static_cast<std::uint32_t>(i), shared.plan.instances[i].size(),
                                               shared.options.object_bytes);
      context.invoke<&Actor::start>(actor);
    }
  });
  result.engine.ranks.push_back(runtime.summary());
  if (auto timeline = runtime.timeline()) result.timelines.push_back(*std::move(timeline));
}

/// Puts runs in the order of their begins, as in every dump.
void put_in_order(GraphDump& graph) {
  std::vector<dataflow::RunIndex> order(graph.runs.size()), place(graph.runs.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](dataflow::RunIndex a, dataflow::RunIndex b) {
    return graph.runs[a].begin < graph.runs[b].begin;
  });
  std::vector<dataflow::DumpedRun> runs;
  runs.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    place[order[i]] = static_cast<dataflow::RunIndex>(i);
    runs.push_back(std::move(graph.runs[order[i]]));
  }
  graph.runs = std::move(runs);
  for (auto& use : graph.uses) use.from = place[use.from], use.to = place[use.to];
  std::stable_sort(graph.uses.begin(), graph.uses.end(), [](const auto& a, const auto& b) {
    return std::tie(a.to, a.time) < std::tie(b.to, b.time);
  });
}

/// Times count from the first begin; uses happen when their runs do, which have counted seconds of their own.
void tidy(const GraphDump& recorded, GraphDump& graph) {
  if (graph.runs.empty()) return;
  TimePoint first = graph.runs.front().begin;
  for (const auto& run : graph.runs) first = std::min(first, run.begin);
  for (auto& run : graph.runs) run.begin -= first, run.end -= first;
  const SecondsCounters counters(graph.counter_names);
  for (dataflow::RunIndex r = 0; r < graph.runs.size(); ++r) {
    const auto &was = recorded.runs[r], &is = graph.runs[r];
    counters.scale(graph.runs[r], ratio_of(is.end - is.begin, was.end - was.begin));
  }
  for (auto& use : graph.uses) {
    const auto &was = recorded.runs[use.from], &is = graph.runs[use.from];
    const double share = was.end > was.begin ? static_cast<double>(use.time - was.begin) /
                                                   static_cast<double>(was.end - was.begin)
                                             : 1;
    const double into = std::clamp(share, 0.0, 1.0) * static_cast<double>(is.end - is.begin);
    use.time = is.begin + static_cast<TimePoint>(into);
  }
  put_in_order(graph);
  graph.critical_path = critical_path(graph);
}

double span_of(const GraphDump& graph) {
  TimePoint last = 0;
  for (const auto& run : graph.runs) last = std::max(last, run.end);
  return 1e-9 * static_cast<double>(last);
}

}  // namespace

Replayed replay(const GraphDump& recorded, const ReplayOptions& options) {
  const auto ranks = static_cast<std::size_t>(std::max(options.ranks, 0));
  Shared shared{options, plan_of(recorded, options.slowdown), {}, recorded, {}, {}, {}, 0};
  shared.rank_of.resize(shared.size());
  shared.objects.resize(ranks);
  shared.most_objects.resize(ranks);
  shared.place_of.resize(shared.plan.handlers.size());
  for (const auto& mine : shared.plan.instances)
    for (std::size_t i = 0; i < mine.size(); ++i) shared.place_of[mine[i]] = static_cast<HandlerIndex>(i);

  Replayed result;
  engine::SimulationOptions simulation;
  simulation.ranks = options.ranks;
  simulation.network = options.network;
  simulation.measured = false;
  simulation.stack_bytes = std::size_t{128} << 10;
  result.simulation =
      engine::simulate(simulation, [&](engine::Transport& transport) { act(shared, transport, result); });
  if (shared.handled != shared.plan.handlers.size())
    throw std::invalid_argument("has tasks that wait for each other for ever: " +
                                std::to_string(shared.plan.handlers.size() - shared.handled) +
                                " did not run");
  for (engine::RankSummary& rank : result.engine.ranks)  // not that of the process, which has them all
    rank.peak_rss = shared.most_objects[rank.rank.index()] * options.object_bytes;
  result.engine = engine::merge(std::move(result.engine.ranks));
  std::sort(result.timelines.begin(), result.timelines.end(),
            [](const auto& a, const auto& b) { return a.rank < b.rank; });
  tidy(recorded, shared.graph);
  result.graph = std::move(shared.graph);
  for (std::size_t i = 0; i < shared.size(); ++i) {
    result.graph.instances[i].object = shared.object(i);
    result.graph.instances[i].rank = shared.rank_of[i];
  }
  result.seconds = span_of(result.graph);
  result.work = 1e-9 * static_cast<double>(shared.plan.work);
  result.most_objects = std::move(shared.most_objects);
  return result;
}

}  // namespace weft::graph::replay
