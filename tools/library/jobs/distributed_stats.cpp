// Sums over ranks, rounds and nodes.
#include "tools/library/jobs/distributed_stats.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "partition/communication/reduce.h"
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

/// Of the nodes that ran on each rank, as far as `log` knows; at the end of each, their sum. Empty: none did.
std::vector<std::vector<double>> seconds_in_nodes(const graph::dataflow::ExecutionLog& log, int ranks) {
  static const graph::dataflow::GraphDescription graph = SubdomainTask::blueprint().description();
  std::vector<report::OperationSeconds> of_nodes(static_cast<std::size_t>(ranks));
  std::vector<std::vector<double>> seconds(of_nodes.size());
  for (const graph::dataflow::NodeRun& run : log.runs) {
    const std::size_t rank = run.rank.index();
    const double took = static_cast<double>(run.end - run.begin) * 1e-9;
    report::BesideSeconds beside;
    for (std::size_t i = 0; i < beside.size(); ++i) beside[i] = log.counter(run, report::kBeside[i].counter);
    report::add_seconds(graph.nodes[run.node].name, took, beside, of_nodes.at(rank));
    seconds[rank].resize(report::kOperations.size() + 1, 0);
    seconds[rank].back() += took;
  }
  for (std::size_t r = 0; r < seconds.size(); ++r)
    if (!seconds[r].empty()) std::ranges::copy(of_nodes[r], seconds[r].begin());
  return seconds;
}

/// By round; a rank that has taken part in fewer rounds has a shorter list.
std::vector<ShiftStats> sum_shifts(partition::Peers& peers, const std::vector<ShiftRecord>& records) {
  std::vector<ShiftStats> rounds;
  for (const ShiftRecord& r : records) {
    if (r.round >= rounds.size()) rounds.resize(r.round + 1);
    ShiftStats& a = rounds[r.round];
    a.wanted += r.wanted;
    a.moved += r.received;
    a.receivers += r.received > 0;
    a.thawed += r.thawed;
  }
  const auto add = [](partition::Bytes& sum, const partition::Bytes& more) {
    auto all = partition::values_of<ShiftStats>(sum);
    const auto others = partition::values_of<ShiftStats>(more);
    if (others.size() > all.size()) all.resize(others.size());
    for (std::size_t i = 0; i < others.size(); ++i) {
      all[i].wanted += others[i].wanted;
      all[i].moved += others[i].moved;
      all[i].receivers += others[i].receivers;
      all[i].thawed += others[i].thawed;
    }
    sum = partition::bytes_of(all);
  };
  std::vector<ShiftStats> result;
  const auto all = partition::values_of<ShiftStats>(peers.reduce(partition::bytes_of(rounds), add));
  for (std::size_t round = 0; round < all.size(); ++round) {
    if (all[round].moved == 0 && all[round].wanted == 0) continue;
    result.push_back(all[round]);
    result.back().round = round;
  }
  return result;
}

/// For accounts only: what real numbers add up to depends on the order, and that on the number of ranks.
std::vector<double> sum_of_times(partition::Peers& peers, const std::vector<double>& mine) {
  return partition::reduce(peers, mine, [](double a, double b) { return a + b; });
}

std::vector<double> plain_seconds(const RankStats& rank) {
  std::vector<double> seconds;
  for (const OperationTime& t : rank.operations) seconds.push_back(t.seconds);
  return seconds;
}

std::vector<OperationTime> named(const std::vector<double>& seconds) {
  std::vector<OperationTime> result;
  const std::vector<std::string> names = operation_names();
  for (std::size_t i = 0; i < names.size(); ++i) result.push_back({names[i], seconds.at(i)});
  return result;
}

/// The loops at which threads help are nearly all of adaptation's.
bool is_adaptation(const std::string& operation) {
  return operation == "interior adaptation" || operation == "MII adaptation" ||
         operation == "interface refinement" || operation == "help";
}

}  // namespace

/// An instance's log goes where it goes: what ran here may be known elsewhere.
RankStats seconds_of_rank(partition::Peers& peers, const graph::dataflow::ExecutionLog& log,
                          const engine::RankSummary& summary) {
  std::vector<double> here(report::kOperations.size() + 1, 0);
  for (const std::vector<double>& known : partition::all_to_all(peers, seconds_in_nodes(log, peers.ranks())))
    for (std::size_t o = 0; o < known.size(); ++o) here[o] += known[o];
  report::OperationSeconds of_workers{};
  std::copy_n(here.begin(), of_workers.size(), of_workers.begin());
  report::add_beside_nodes(summary, here.back(), of_workers);
  std::map<std::string, double> seconds;
  for (std::size_t o = 0; o < of_workers.size(); ++o)
    seconds[std::string(report::kOperations[o])] = of_workers[o];
  seconds["conversion"] += summary.times.pack;
  seconds["communication"] = std::max(0.0, summary.times.communication - summary.times.pack);
  return {summary.rank.value, in_order(seconds)};
}

DistributedStats account_for(partition::Peers& peers, const RankStats& mine,
                             const std::vector<ShiftRecord>& shifts, bool by_rank) {
  DistributedStats account;
  const std::vector<double> seconds = plain_seconds(mine);
  if (by_rank) {
    const auto all = partition::allgather(peers, seconds);
    for (std::size_t r = 0; r < all.size(); ++r)
      account.by_rank.push_back({static_cast<int>(r), named(all[r])});
  }
  account.sum = named(sum_of_times(peers, seconds));
  double busy = 0, adapting = 0;
  for (const OperationTime& t : account.sum) {
    if (t.name == "idle") continue;
    busy += t.seconds;
    if (is_adaptation(t.name)) adapting += t.seconds;
  }
  account.beside_adaptation = busy > 0 ? 1 - adapting / busy : 0;
  account.shifts = sum_shifts(peers, shifts);
  account.ranks = peers.ranks();
  return account;
}

void add_engine(engine::RunSummary summary, DistributedStats& account) {
  auto all = std::make_shared<engine::RunSummary>(std::move(summary));
  for (const engine::Volume& v : all->traffic) {
    account.messages += v.sent.messages;
    account.bytes += v.sent.bytes;
  }
  account.collective_calls = static_cast<std::uint64_t>(all->collective_calls);
  account.verdict = all->verdict();
  account.engine = std::move(all);
}

ExchangeStats sum_exchanges(partition::Peers& peers, const engine::Exchanged& mine) {
  struct Sums {
    std::uint64_t messages, most_messages, peers, most_peers;
  };
  const Sums all =
      partition::reduce(peers, std::vector<Sums>{{mine.messages, mine.messages, mine.peers, mine.peers}},
                        [](const Sums& a, const Sums& b) {
                          return Sums{a.messages + b.messages, std::max(a.most_messages, b.most_messages),
                                      a.peers + b.peers, std::max(a.most_peers, b.most_peers)};
                        })[0];
  const auto ranks = static_cast<double>(peers.ranks());
  return {static_cast<double>(all.messages) / ranks, static_cast<double>(all.peers) / ranks,
          all.most_messages, all.most_peers};
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
  const bool was_divided = std::ranges::any_of(
      a.shifts, [&](const ShiftStats& s) { return s.round == a.division && s.moved > 0; });
  if (a.divided_from > 0 && was_divided)
    text += fmt::format("a coarse mesh was made in {} subdomain{} first, and divided\n", a.divided_from,
                        a.divided_from == 1 ? "" : "s");
  else if (a.divided_from == 1 && a.subdomains > 1)
    text += "a fifth of the tets or more is poor in the metric, so one subdomain kept the mesh\n";
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
  if (a.ranks > 1) {
    const auto line = [](const ExchangeStats& e) {
      return fmt::format("{} to {}", grouped(e.most_messages), grouped(e.most_peers));
    };
    text += fmt::format(
        "messages of a rank, and others it has them with, at most: {} before the loop, {} in "
        "it, {} after\n",
        line(a.exchanged_before), line(a.exchanged_in_loop), line(a.exchanged_after));
  }
  if (a.former_interface.num_tets > 0)
    text += fmt::format("former interface: Q mean {:.4f}, 1 % {:.4f}, min {:.4f}; unit edges {}\n",
                        a.former_interface.quality_mean, a.former_interface.quality_q01,
                        a.former_interface.quality_min, percent(a.former_interface.edges_unit));
  return text;
}

}  // namespace weft::tools
