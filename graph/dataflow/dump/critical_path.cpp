// Longest paths over the runs in an order in which none comes before what it waits for.
#include "graph/dataflow/dump/critical_path.h"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>

namespace weft::graph::dataflow {
namespace {

using engine::TimePoint;

constexpr std::uint32_t kNoRun = std::numeric_limits<std::uint32_t>::max();

/// Who waits for whom.
struct Order {
  std::vector<RunIndex> before;                  ///< the run before in the same instance, or kNoRun
  std::vector<RunIndex> after;                   ///< the run after in the same instance, or kNoRun
  std::vector<std::uint32_t> first_use;          ///< GraphDump::uses are by target: those of run r
  std::vector<std::vector<std::uint32_t>> sent;  ///< indices of the uses that leave a run

  explicit Order(const GraphDump& dump)
      : before(dump.runs.size(), kNoRun),
        after(dump.runs.size(), kNoRun),
        first_use(dump.runs.size() + 1, 0),
        sent(dump.runs.size()) {
    std::vector<RunIndex> last(dump.instances.size(), kNoRun);
    for (RunIndex r = 0; r < dump.runs.size(); ++r) {
      RunIndex& previous = last.at(dump.runs[r].instance);
      before[r] = previous;
      if (previous != kNoRun) after[previous] = r;
      previous = r;
    }
    for (std::uint32_t u = 0; u < dump.uses.size(); ++u) {
      ++first_use[dump.uses[u].to + 1];
      sent[dump.uses[u].from].push_back(u);
    }
    for (std::size_t r = 0; r < dump.runs.size(); ++r) first_use[r + 1] += first_use[r];
  }
};

/// The runs, each after those that it waits for (Kahn).
std::vector<RunIndex> sorted(const GraphDump& dump, const Order& order) {
  std::vector<std::uint32_t> waits(dump.runs.size());
  std::vector<RunIndex> ready;
  for (RunIndex r = 0; r < dump.runs.size(); ++r) {
    waits[r] = order.first_use[r + 1] - order.first_use[r] + (order.before[r] != kNoRun ? 1 : 0);
    if (waits[r] == 0) ready.push_back(r);
  }
  const auto done_with = [&](RunIndex r) {
    if (--waits[r] == 0) ready.push_back(r);
  };
  for (std::size_t i = 0; i < ready.size(); ++i) {
    const RunIndex run = ready[i];
    if (order.after[run] != kNoRun) done_with(order.after[run]);
    for (const std::uint32_t use : order.sent[run]) done_with(dump.uses[use].to);
  }
  if (ready.size() != dump.runs.size())
    throw std::invalid_argument("runs of the graph " + dump.description.name +
                                " wait for each other in a circle");
  return ready;
}

/// How much of the chain that ends at a run lies before it, and what the run waits for.
struct ChainEnd {
  TimePoint before = 0;
  RunIndex previous = kNoRun;
  std::uint32_t use = kNoRun;
};

class ChainFinder {
 public:
  ChainFinder(const GraphDump& dump, const Order& order) : dump_(dump), ends_(dump.runs.size()) {
    for (const RunIndex r : sorted(dump, order)) {
      if (order.before[r] != kNoRun) offer(r, order.before[r], kNoRun, dump.runs[order.before[r]].end);
      for (std::uint32_t u = order.first_use[r]; u < order.first_use[r + 1]; ++u)
        offer(r, dump.uses[u].from, u, dump.uses[u].time);
    }
  }

  CriticalPath longest() const {
    CriticalPath path;
    RunIndex last = kNoRun;
    for (RunIndex r = 0; r < ends_.size(); ++r) {
      const DumpedRun& run = dump_.runs[r];
      path.wall = std::max(path.wall, run.end);
      const TimePoint length = ends_[r].before + run.end - run.begin;
      if (last != kNoRun && length <= path.length) continue;
      path.length = length, last = r;
    }
    TimePoint end = path.length;
    for (RunIndex r = last; r != kNoRun; r = ends_[r].previous) {
      const ChainEnd& chain = ends_[r];
      path.steps.push_back({r, end - chain.before, {}});
      if (chain.use != kNoRun) path.steps.back().arrived_by = chain.use;
      end = chain.before;
    }
    std::reverse(path.steps.begin(), path.steps.end());
    return path;
  }

 private:
  /// `left`: when the chain leaves the previous run. What lies before a run is never longer than the time
  /// that has passed: where clocks say otherwise, they are wrong by the difference.
  void offer(RunIndex run, RunIndex previous, std::uint32_t use, TimePoint left) {
    const TimePoint begin = dump_.runs[run].begin;
    const TimePoint before = ends_[previous].before;
    if (begin < before) return;
    const TimePoint candidate = std::min(before + left - dump_.runs[previous].begin, begin);
    if (ends_[run].previous != kNoRun && candidate <= ends_[run].before) return;
    ends_[run] = {candidate, previous, use};
  }

  const GraphDump& dump_;
  std::vector<ChainEnd> ends_;
};

}  // namespace

CriticalPath critical_path(const GraphDump& dump) { return ChainFinder(dump, Order(dump)).longest(); }

std::vector<PathShare> shares_of(const GraphDump& dump) {
  std::map<NodeIndex, PathShare> shares;
  for (const CriticalPath::Step& step : dump.critical_path.steps) {
    const NodeIndex node = dump.runs[step.run].node;
    PathShare& share = shares.try_emplace(node, PathShare{node, 0, 0}).first->second;
    ++share.runs;
    share.worked += step.worked;
  }
  std::vector<PathShare> list;
  for (const auto& [node, share] : shares) list.push_back(share);
  return list;
}

std::vector<Wait> waits_of(const GraphDump& dump) {
  const Order order(dump);
  std::vector<Wait> waits;
  for (RunIndex r = 0; r < dump.runs.size(); ++r) {
    if (dump.description.nodes[dump.runs[r].node].kind != NodeKind::event) continue;
    if (order.before[r] == kNoRun || order.first_use[r] == order.first_use[r + 1]) continue;
    const DumpedUse& last = dump.uses[order.first_use[r + 1] - 1];
    const TimePoint waited = std::min(last.time, dump.runs[r].begin) - dump.runs[order.before[r]].end;
    if (waited > 0) waits.push_back({r, last.from, waited});
  }
  return waits;
}

}  // namespace weft::graph::dataflow
