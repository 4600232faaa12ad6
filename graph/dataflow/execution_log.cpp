// Counting, joining and summing up.
#include "graph/dataflow/execution_log.h"

#include <algorithm>
#include <utility>

#include "engine/run/runtime.h"
#include "graph/dataflow/common_clock.h"
#include "graph/dataflow/rank_exchange.h"

namespace weft::graph::dataflow {
namespace {

/// The name's index, which it gets if it has none.
std::uint32_t intern(std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  const auto index = static_cast<std::uint32_t>(found - names.begin());
  if (found == names.end()) names.emplace_back(name);
  return index;
}

template <class T>
void append_to(std::vector<T>& all, const std::vector<T>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

void ExecutionLog::count(std::string_view name, double amount) {
  const std::uint32_t index = intern(counter_names, name);
  const auto same = std::find_if(counters.begin() + runs.back().first_counter, counters.end(),
                                 [&](const Counter& counter) { return counter.name == index; });
  if (same != counters.end()) {
    same->value += amount;
  } else {
    counters.push_back({index, amount});
    ++runs.back().counters;
  }
}

double ExecutionLog::counter(const NodeRun& run, std::string_view name) const {
  for (std::uint32_t i = run.first_counter; i < run.first_counter + run.counters; ++i) {
    if (counter_names[counters[i].name] == name) return counters[i].value;
  }
  return 0;
}

void ExecutionLog::append(ExecutionLog&& other) {
  const auto first_run = static_cast<std::ptrdiff_t>(runs.size());
  const auto first_counter = static_cast<std::uint32_t>(counters.size());
  std::vector<std::uint32_t> old_to_new;
  for (const std::string& name : other.counter_names) old_to_new.push_back(intern(counter_names, name));
  for (Counter& counter : other.counters) counter.name = old_to_new[counter.name];
  append_to(runs, other.runs);
  append_to(uses, other.uses);
  append_to(counters, other.counters);
  for (auto run = runs.begin() + first_run; run != runs.end(); ++run) run->first_counter += first_counter;
  other = {};
}

std::vector<NodeSum> sums_of(const GraphDescription& graph, const ExecutionLog& log) {
  std::vector<NodeSum> sums;
  for (const NodeDescription& node : graph.nodes) sums.push_back({node.name, 0, 0, 0});
  for (const NodeRun& run : log.runs) {
    NodeSum& sum = sums.at(run.node);
    const double seconds = static_cast<double>(run.end - run.begin) * 1e-9;
    ++sum.count;
    sum.seconds += seconds;
    sum.longest = std::max(sum.longest, seconds);
  }
  return sums;
}

ExecutionLog gather_log(RankExchange& exchange, ExecutionLog mine) {
  engine::Runtime& runtime = exchange.runtime();
  runtime.gather_sums();  // compares the clocks
  engine::TimePoint offset = runtime.clock_offset();
  std::vector<engine::Payload> to_each(static_cast<std::size_t>(runtime.ranks()));
  engine::Packer packer(true);
  packer(offset, mine);
  to_each[0] = packer.take();
  ExecutionLog all;
  std::vector<engine::TimePoint> offset_of_rank;
  for (engine::Payload& payload : exchange.exchange(std::move(to_each))) {
    if (runtime.rank().value > 0) continue;  // all went to rank 0
    ExecutionLog part;
    engine::Unpacker unpacker(std::move(payload));
    unpacker(offset, part);
    unpacker.finish();
    offset_of_rank.push_back(offset);
    all.append(std::move(part));
  }
  to_common_clock(offset_of_rank, all);
  return all;
}

}  // namespace weft::graph::dataflow
