// Sums over ranks, rounds and nodes.
#include "tools/library/jobs/distributed_stats.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tools/common/text.h"
#include "tools/report/operations.h"

namespace weft::tools {
namespace {

using graph::adaptation::ShiftRecord;
using graph::adaptation::SubdomainTask;

/// The report's operations, and what the communication thread does.
std::vector<std::string> operation_names() {
  std::vector<std::string> names(report::kOperations.begin(), report::kOperations.end());
  names.push_back("communication");
  return names;
}

std::vector<OperationTime> in_order(const std::map<std::string, double>& seconds) {
  std::vector<OperationTime> result;
  for (const std::string& name : operation_names()) {
    const auto at = seconds.find(name);
    result.push_back({name, at == seconds.end() ? 0 : at->second});
  }
  return result;
}

/// Seconds by operation of one rank: nodes from the log, the rest from the engine.
std::map<std::string, double> seconds_of(const graph::dataflow::ExecutionLog& log,
                                         const engine::RankSummary& summary) {
  static const graph::dataflow::GraphDescription graph = SubdomainTask::blueprint().description();
  report::OperationSeconds of_nodes{};
  double in_nodes = 0;
  for (const graph::dataflow::NodeRun& run : log.runs) {
    if (run.rank != summary.rank) continue;
    const double took = static_cast<double>(run.end - run.begin) * 1e-9;
    report::BesideSeconds beside;
    for (std::size_t i = 0; i < beside.size(); ++i) beside[i] = log.counter(run, report::kBeside[i].counter);
    report::add_seconds(graph.nodes[run.node].name, took, beside, of_nodes);
    in_nodes += took;
  }
  std::map<std::string, double> seconds;
  for (std::size_t o = 0; o < of_nodes.size(); ++o)
    seconds[std::string(report::kOperations[o])] = of_nodes[o];
  seconds["conversion"] = summary.times.unpack + summary.times.pack;
  seconds["misc"] = std::max(0.0, summary.times.compute - in_nodes);
  seconds["idle"] = summary.times.idle;
  seconds["communication"] = std::max(0.0, summary.times.communication - summary.times.pack);
  return seconds;
}

std::vector<ShiftStats> sum_shifts(const std::vector<ShiftRecord>& records) {
  std::map<std::uint64_t, ShiftStats> rounds;
  for (const ShiftRecord& r : records) {
    ShiftStats& a = rounds[r.round];
    a.round = r.round;
    a.wanted += r.wanted;
    a.moved += r.received;
    a.receivers += r.received > 0;
    a.thawed += r.thawed;
  }
  std::vector<ShiftStats> result;
  for (const auto& [round, account] : rounds)
    if (account.moved > 0 || account.wanted > 0) result.push_back(account);
  return result;
}

bool is_adaptation(const std::string& operation) {
  return operation == "interior adaptation" || operation == "MII adaptation" ||
         operation == "interface refinement";
}

}  // namespace

DistributedStats account_for(const graph::dataflow::ExecutionLog& log,
                             std::vector<engine::RankSummary> summaries,
                             const std::vector<ShiftRecord>& shifts) {
  DistributedStats account;
  std::map<std::string, double> sum;
  for (const engine::RankSummary& summary : summaries) {
    const std::map<std::string, double> seconds = seconds_of(log, summary);
    for (const auto& [name, s] : seconds) sum[name] += s;
    account.by_rank.push_back({summary.rank.value, in_order(seconds)});
  }
  account.sum = in_order(sum);
  double busy = 0, adapting = 0;
  for (const OperationTime& t : account.sum) {
    if (t.name == "idle") continue;
    busy += t.seconds;
    if (is_adaptation(t.name)) adapting += t.seconds;
  }
  account.beside_adaptation = busy > 0 ? 1 - adapting / busy : 0;
  account.shifts = sum_shifts(shifts);
  account.ranks = static_cast<int>(summaries.size());
  auto all = std::make_shared<engine::RunSummary>(engine::merge(std::move(summaries)));
  for (const engine::Volume& v : all->traffic) {
    account.messages += v.sent.messages;
    account.bytes += v.sent.bytes;
  }
  account.collective_calls = static_cast<std::uint64_t>(all->collective_calls);
  account.verdict = all->verdict();
  account.engine = std::move(all);
  return account;
}

std::string checkpoints_text(const CheckpointStats& c) {
  std::string text;
  if (!c.resumed.empty()) text += fmt::format("gone on from checkpoint {}\n", c.resumed);
  if (c.written > 0)
    text += fmt::format("checkpoints: {}, the latest of {}; {:.2f} s of all workers for copies\n", c.written,
                        bytes_text(c.bytes), c.seconds);
  return text;
}

std::string subdomains_text(const DistributedStats& a) {
  std::string text = fmt::format("{} subdomains by {} on {} rank{}, {} layers\n", a.subdomains, a.partitioner,
                                 a.ranks, a.ranks == 1 ? "" : "s", a.layers);
  double total = 0;
  for (const OperationTime& t : a.sum) total += t.seconds;
  for (const OperationTime& t : a.sum)
    text += fmt::format("  {:<28}{:>10.2f} s{:>8}\n", t.name, t.seconds,
                        percent(total > 0 ? t.seconds / total : 0));
  text += fmt::format("{} of the busy time is not adaptation; {}\n", percent(a.beside_adaptation), a.verdict);
  text += fmt::format("{:<8}{:>16}{:>14}{:>12}{:>16}\n", "shift", "vertices wanted", "tets moved",
                      "receivers", "vertices freed");
  for (const ShiftStats& s : a.shifts) {
    const bool coarse = s.round<a.coarse_shifts, division = a.divided_from> 0 && s.round == a.division;
    text += fmt::format("  {:<6}{:>16}{:>14}{:>12}{:>16}{}\n", s.round + 1, grouped(s.wanted),
                        grouped(s.moved), grouped(s.receivers), grouped(s.thawed),
                        division ? "  division"
                        : coarse ? "  coarse"
                                 : "");
  }
  if (a.divided_from > 0)
    text += fmt::format("a coarse mesh was made in {} subdomain{} first, and divided\n", a.divided_from,
                        a.divided_from == 1 ? "" : "s");
  if (a.coarse_shifts > (a.divided_from > 0 ? a.division + 1 : 0))
    text += "adapted to coarser metrics first, so that interfaces follow the metric and the boundary too\n";
  if (a.checks > 0)
    text += fmt::format(
        "all invariants checked {} times, and held: after the decomposition, the interior adaptation and "
        "each "
        "shift\n",
        a.checks);
  text += checkpoints_text(a.checkpoints);
  text += fmt::format("messages: {} with {}; collective calls in the loop: {}\n", grouped(a.messages),
                      bytes_text(static_cast<double>(a.bytes)), a.collective_calls);
  text += fmt::format("former interface: Q mean {:.4f}, 1 % {:.4f}, min {:.4f}; unit edges {}\n",
                      a.former_interface.quality_mean, a.former_interface.quality_q01,
                      a.former_interface.quality_min, percent(a.former_interface.edges_unit));
  return text;
}

}  // namespace weft::tools
