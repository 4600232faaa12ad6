#include "tools/report/operations.h"

#include <algorithm>
#include <utility>

namespace weft::report {

OperationIndex operation_of_node(std::string_view name) {
  static constexpr std::pair<std::string_view, OperationIndex> kNodes[] = {
      {"adapt interior", 0}, {"adapt shifted", 1},  {"register interface", 2},
      {"propose", 3},        {"wake", 3},           {"gather", 4},
      {"divide", 4},         {"await division", 4}, {"scatter", 5},
      {"update topology", 6}};
  const auto found = std::find_if(std::begin(kNodes), std::end(kNodes),
                                  [&](const auto& entry) { return entry.first == name; });
  return found == std::end(kNodes) ? kMisc : found->second;
}

void add_seconds(std::string_view node, double took, const BesideSeconds& beside, OperationSeconds& seconds) {
  for (std::size_t i = 0; i < beside.size(); ++i) {
    const double part = std::min(beside[i], took);
    seconds[kBeside[i].operation] += part;
    took -= part;
  }
  seconds[operation_of_node(node)] += took;
}

BesideSeconds beside_seconds(const graph::dataflow::GraphDump& graph, const graph::dataflow::DumpedRun& run) {
  BesideSeconds seconds{};
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    const auto name = std::ranges::find(graph.counter_names, kBeside[i].counter);
    const auto place = static_cast<std::size_t>(name - graph.counter_names.begin());
    if (place < run.counters.size()) seconds[i] = run.counters[place];
  }
  return seconds;
}

OperationSeconds seconds_of_rank(const engine::RankSummary& summary,
                                 const graph::dataflow::GraphDump& graph) {
  OperationSeconds seconds{};
  double in_nodes = 0;
  for (const graph::dataflow::DumpedRun& run : graph.runs) {
    if (run.rank != summary.rank) continue;
    const double took = 1e-9 * static_cast<double>(run.end - run.begin);
    add_seconds(graph.description.nodes[run.node].name, took, beside_seconds(graph, run), seconds);
    in_nodes += took;
  }
  add_beside_nodes(summary, in_nodes, seconds);
  return seconds;
}

void add_beside_nodes(const engine::RankSummary& summary, double in_nodes, OperationSeconds& seconds) {
  const double beside = std::max(0.0, summary.times.compute - in_nodes);
  const auto counter = summary.counters.find("core_wait_seconds");
  const double waited = counter == summary.counters.end() ? 0 : std::min(beside, counter->second);
  seconds[kConversion] += summary.times.unpack + summary.times.copy;
  seconds[kMisc] += beside - waited;
  seconds[kHelp] += summary.times.help;
  seconds[kIdle] += summary.times.idle + waited;
}

}  // namespace weft::report
