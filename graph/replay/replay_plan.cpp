// Runs to handlers, uses to what handlers wait for.
#include "graph/replay/replay_plan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "engine/base/text.h"
#include "graph/replay/duration_model.h"

namespace weft::graph::replay {

using dataflow::DumpedRun;
using dataflow::DumpedUse;
using dataflow::EdgeKind;
using dataflow::GraphDump;
using dataflow::RunIndex;
using engine::TimePoint;

namespace {

/// Of an instance's values to one neighbour in `kCrossing` goes to the next copy.
constexpr std::uint32_t kCrossing = 8;

TimePoint scaled(TimePoint time, double factor) { return within_limits(static_cast<double>(time) * factor); }

/// Whatever is computed with them later fits.
void check_times(const GraphDump& dump) {
  for (const DumpedRun& run : dump.runs)
    if (static_cast<double>(run.end) > 1e9 * kMostSeconds)
      throw std::invalid_argument(
          "has a task that ends " + engine::text(1e-9 * static_cast<double>(run.end)) +
          " s after the first one began: more than " + engine::text(kMostSeconds) + " s cannot be replayed");
}

/// Whether each run follows locally, within the handler, from the run before it in its instance.
std::vector<bool> followers(const GraphDump& dump) {
  std::vector<bool> follows(dump.runs.size());
  for (const DumpedUse& use : dump.uses)
    if (dump.description.edges[use.edge].kind == EdgeKind::local) follows[use.to] = true;
  return follows;
}

class Planner {
 public:
  Planner(const GraphDump& dump, double slowdown) : dump_(dump), slowdown_(slowdown) {}

  ReplayPlan plan() {
    add_handlers();
    for (const DumpedUse& use : dump_.uses)
      if (dump_.description.edges[use.edge].kind == EdgeKind::remote) add_send(use, handler_of_[use.to]);
    add_wakes();
    for (PlannedHandler& handler : plan_.handlers) {
      for (PlannedRun& run : handler.runs)
        std::stable_sort(run.sends.begin(), run.sends.end(),
                         [](const PlannedSend& a, const PlannedSend& b) { return a.after < b.after; });
    }
    expect();
    return std::move(plan_);
  }

 private:
  void add_handlers() {
    const std::vector<bool> follows = followers(dump_);
    plan_.instances.resize(dump_.instances.size());
    handler_of_.resize(dump_.runs.size());
    place_of_.resize(dump_.runs.size());
    for (RunIndex r = 0; r < dump_.runs.size(); ++r) {
      const DumpedRun& run = dump_.runs[r];
      std::vector<HandlerIndex>& mine = plan_.instances[run.instance];
      if (!follows[r] || mine.empty()) {
        mine.push_back(static_cast<HandlerIndex>(plan_.handlers.size()));
        plan_.handlers.emplace_back();
      }
      PlannedHandler& handler = plan_.handlers[mine.back()];
      handler_of_[r] = mine.back();
      place_of_[r] = handler.runs.size();
      handler.runs.push_back({r, scaled(run.end - run.begin, slowdown_), {}});
      plan_.work += handler.runs.back().works;
      if (static_cast<double>(plan_.work) > 1e9 * kMostSeconds)
        throw std::invalid_argument("has tasks that take more than " + engine::text(kMostSeconds) +
                                    " s together, as slow or large as is asked for: too much to replay");
    }
  }

  void add_send(const DumpedUse& use, HandlerIndex to) {
    PlannedRun& from = plan_.handlers[handler_of_[use.from]].runs[place_of_[use.from]];
    const TimePoint after = scaled(use.time - dump_.runs[use.from].begin, slowdown_);
    from.sends.push_back(
        {std::clamp<TimePoint>(after, 0, from.works), dump_.runs[use.to].instance, to, use.bytes});
    ++plan_.handlers[to].values;
  }

  /// The run of a wake node happens at whichever value for its event in its round comes first.
  void add_wakes() {
    std::map<std::tuple<std::uint32_t, dataflow::NodeIndex, std::uint64_t>, HandlerIndex> events;
    for (RunIndex r = 0; r < dump_.runs.size(); ++r)
      events[{dump_.runs[r].instance, dump_.runs[r].node, dump_.runs[r].round}] = handler_of_[r];
    for (RunIndex r = 0; r < dump_.runs.size(); ++r) {
      const DumpedRun& run = dump_.runs[r];
      for (const auto& edge : dump_.description.edges) {
        if (edge.kind != EdgeKind::wake || edge.to != run.node) continue;
        const auto event = events.find({run.instance, edge.from, run.round});
        if (event == events.end() || plan_.handlers[event->second].values == 0) continue;
        plan_.handlers[event->second].wakes = handler_of_[r];
        plan_.handlers[handler_of_[r]].values = 1;
      }
    }
  }

  /// An application knows what a step takes on average, not what it will take this time.
  void expect() {
    std::map<std::pair<dataflow::NodeIndex, std::uint64_t>, std::pair<double, double>> sums;
    const auto key = [&](const PlannedHandler& handler) {
      const DumpedRun& first = dump_.runs[handler.runs.front().run];
      return std::pair(first.node, first.round);
    };
    const auto seconds = [](const PlannedHandler& handler) {
      double sum = 0;
      for (const PlannedRun& run : handler.runs) sum += 1e-9 * static_cast<double>(run.works);
      return sum;
    };
    for (const PlannedHandler& handler : plan_.handlers) {
      auto& [sum, count] = sums[key(handler)];
      sum += seconds(handler);
      count += 1;
    }
    for (PlannedHandler& handler : plan_.handlers) {
      const auto& [sum, count] = sums[key(handler)];
      handler.expected = sum / count;
    }
  }

  const GraphDump& dump_;
  double slowdown_;
  ReplayPlan plan_;
  std::vector<HandlerIndex> handler_of_;  ///< by run
  std::vector<std::size_t> place_of_;     ///< of a run in its handler
};

}  // namespace

ReplayPlan plan_of(const GraphDump& dump, double slowdown) {
  if (!dump.executed()) throw std::invalid_argument("contains a planned graph: there is nothing to replay");
  check_times(dump);
  return Planner(dump, slowdown).plan();
}

SecondsCounters::SecondsCounters(const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].ends_with(", seconds")) places_.push_back(i);
}

void SecondsCounters::scale(DumpedRun& run, double factor) const {
  for (const std::size_t place : places_)
    if (place < run.counters.size()) run.counters[place] *= factor;
}

double ratio_of(TimePoint is, TimePoint was) {
  return was > 0 ? static_cast<double>(is) / static_cast<double>(was) : 1;
}

void take_processor_times(GraphDump& dump) {
  const auto name =
      std::find(dump.counter_names.begin(), dump.counter_names.end(), dataflow::kProcessorSeconds);
  if (name == dump.counter_names.end())
    throw std::invalid_argument("contains no processor times: it was recorded by an older version");
  const auto place = static_cast<std::size_t>(name - dump.counter_names.begin());
  check_times(dump);
  SecondsCounters counters(dump.counter_names);
  counters.leave_out(place);  // it is what the others become parts of
  std::vector<double> factors(dump.runs.size(), 1);
  for (RunIndex r = 0; r < dump.runs.size(); ++r) {
    DumpedRun& run = dump.runs[r];
    const double seconds = place < run.counters.size() ? run.counters[place] : 0;
    if (!(seconds >= 0 && seconds <= kMostSeconds))
      throw std::invalid_argument("runs.counters[\"" + *name + "\"][" + std::to_string(r) + "] is " +
                                  engine::text(seconds) + ": it is not between 0 and " +
                                  engine::text(kMostSeconds));
    const auto took = static_cast<TimePoint>(1e9 * seconds);
    factors[r] = ratio_of(took, run.end - run.begin);
    counters.scale(run, factors[r]);
    run.end = run.begin + took;
  }
  for (DumpedUse& use : dump.uses) {
    const TimePoint begin = dump.runs[use.from].begin;
    use.time = std::min(dump.runs[use.from].end, begin + scaled(use.time - begin, factors[use.from]));
  }
  std::stable_sort(dump.uses.begin(), dump.uses.end(), [](const DumpedUse& a, const DumpedUse& b) {
    return std::tie(a.to, a.time) < std::tie(b.to, b.time);
  });
}

namespace {

/// Adds instances to a copy of a recording.
class Enlarger {
 public:
  Enlarger(const GraphDump& dump, const Enlargement& enlargement)
      : dump_(dump),
        enlargement_(enlargement),
        durations_(dump),
        counters_(dump.counter_names),
        surface_(std::pow(growth(), 2.0 / 3)),
        random_(enlargement.seed) {}

  GraphDump enlarge() {
    large_.description = dump_.description;
    large_.counter_names = dump_.counter_names;
    for (std::uint32_t c = 0; c < copies(); ++c) add_copy(c);
    for (std::uint32_t c = 0; c < copies(); ++c) add_uses(c);
    std::stable_sort(large_.uses.begin(), large_.uses.end(), [](const DumpedUse& a, const DumpedUse& b) {
      return std::tie(a.to, a.time) < std::tie(b.to, b.time);
    });
    large_.network = dataflow::network_of(large_);
    if (growth() != 1) forget_counts();
    return std::move(large_);
  }

 private:
  std::uint32_t copies() const { return enlargement_.copies * enlargement_.split; }
  double growth() const { return enlargement_.grow / enlargement_.split; }
  bool is_split() const { return enlargement_.split > 1; }
  bool is_recording(std::uint32_t copy) const { return copy == 0 && growth() == 1 && !is_split(); }

  void add_copy(std::uint32_t copy) {
    const auto instances = static_cast<std::uint32_t>(dump_.instances.size());
    if (copy % enlargement_.split == 0) hard_parts_ = choose_hard_parts(instances);
    std::vector<double> sizes = durations_.sizes();
    for (std::uint32_t i = 0; i < instances; ++i) {
      dataflow::DumpedInstance instance = dump_.instances[i];
      instance.number += std::uint64_t{copy} * instances;
      if (copy > 0) instance.object = {engine::Rank(0), copy * instances + instance.object.number + 1};
      large_.instances.push_back(instance);
      if (!is_split()) sizes[i] = durations_.sizes()[random_() % instances];
      sizes[i] *= growth();
    }
    for (DumpedRun run : dump_.runs) {
      if (is_split())
        take(run, time_of_part(run, copy), sizes[run.instance]);
      else if (!is_recording(copy))
        take(run, durations_.draw(run.node, run.round, sizes[run.instance], random_), sizes[run.instance]);
      run.instance += copy * instances;
      large_.runs.push_back(std::move(run));
    }
  }

  /// Of each recorded instance which of its parts have what is hard of it: about the cube root of their
  /// number, the first of them at random.
  struct HardParts {
    std::uint32_t first, count;
  };
  std::vector<HardParts> choose_hard_parts(std::uint32_t instances) {
    std::vector<HardParts> chosen;
    const double count = std::cbrt(enlargement_.split), whole = std::floor(count);
    std::bernoulli_distribution one_more(count - whole);
    for (std::uint32_t i = 0; i < instances; ++i)
      chosen.push_back({static_cast<std::uint32_t>(random_() % enlargement_.split),
                        static_cast<std::uint32_t>(whole) + one_more(random_)});
    return chosen;
  }

  TimePoint time_of_part(const DumpedRun& run, std::uint32_t copy) const {
    const HardParts& hard = hard_parts_[run.instance];
    const std::uint32_t split = enlargement_.split;
    const bool is_hard = (copy % split + split - hard.first) % split < hard.count;
    const double grown = std::pow(enlargement_.grow, durations_.exponent(run.node));
    return within_limits(grown * static_cast<double>(durations_.of_part(run, {split, hard.count, is_hard})));
  }

  void take(DumpedRun& run, TimePoint takes, double size) {
    counters_.scale(run, ratio_of(takes, run.end - run.begin));
    const std::size_t place = durations_.size_counter();
    if (place < run.counters.size() && run.counters[place] > 0) run.counters[place] = size;
    run.end = run.begin + takes;
    run.bytes_received = on_surface(run.bytes_received);
  }

  /// Those of subdomains of another size would have been others.
  void forget_counts() {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < dump_.counter_names.size(); ++i)
      if (i == durations_.size_counter() || counters_.has(i)) kept.push_back(i);
    std::vector<std::string> names;
    for (const std::size_t i : kept) names.push_back(dump_.counter_names[i]);
    for (DumpedRun& run : large_.runs) {
      std::vector<double> counters;
      for (const std::size_t i : kept) counters.push_back(i < run.counters.size() ? run.counters[i] : 0);
      run.counters = std::move(counters);
    }
    large_.counter_names = std::move(names);
  }

  std::uint64_t on_surface(std::uint64_t bytes) const {
    return static_cast<std::uint64_t>(within_limits(static_cast<double>(bytes) * surface_));
  }

  void add_uses(std::uint32_t copy) {
    const auto runs = static_cast<RunIndex>(dump_.runs.size());
    for (std::uint32_t u = 0; u < dump_.uses.size(); ++u) {
      DumpedUse use = dump_.uses[u];
      const bool remote = dump_.description.edges[use.edge].kind == EdgeKind::remote;
      const std::uint32_t target = remote && u % kCrossing == 0 ? (copy + 1) % copies() : copy;
      const DumpedRun& was = dump_.runs[use.from];
      use.from += copy * runs;
      use.to += target * runs;
      use.bytes = on_surface(use.bytes);
      // It was sent after the same share of the work.
      const DumpedRun& is = large_.runs[use.from];
      const double share = was.end > was.begin ? static_cast<double>(use.time - was.begin) /
                                                     static_cast<double>(was.end - was.begin)
                                               : 0;
      use.time = is.begin + scaled(is.end - is.begin, std::clamp(share, 0.0, 1.0));
      large_.uses.push_back(use);
    }
  }

  const GraphDump& dump_;
  Enlargement enlargement_;
  DurationModel durations_;
  SecondsCounters counters_;
  double surface_;
  std::mt19937_64 random_;
  std::vector<HardParts> hard_parts_;  ///< of this copy
  GraphDump large_;
};

}  // namespace

GraphDump enlarged(const GraphDump& dump, const Enlargement& enlargement) {
  const double copies = static_cast<double>(enlargement.copies) * enlargement.split;
  const auto most = static_cast<double>(std::max({dump.instances.size(), dump.runs.size(), std::size_t{1}}));
  if (copies < 1 || !(enlargement.grow > 0)) throw std::invalid_argument("there is no graph of no size");
  if (copies * most > kMostRuns)
    throw std::invalid_argument("has " + std::to_string(dump.runs.size()) +
                                " tasks: " + engine::text(copies) + " times as many are more than " +
                                engine::text(kMostRuns));
  check_times(dump);
  return Enlarger(dump, enlargement).enlarge();
}

}  // namespace weft::graph::replay
