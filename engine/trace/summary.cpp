// Summaries: from a trace, of all ranks, and their consistency.
#include "engine/trace/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

#include "engine/json/json.h"

namespace weft::engine {
namespace {

double seconds(std::int64_t nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

MessageCount& operator+=(MessageCount& sum, const MessageCount& more) {
  sum.messages += more.messages;
  sum.bytes += more.bytes;
  return sum;
}
Volume& operator+=(Volume& sum, const Volume& more) {
  sum.sent += more.sent;
  sum.received += more.received;
  return sum;
}
TimeSummary& operator+=(TimeSummary& sum, const TimeSummary& more) {
  sum.compute += more.compute;
  sum.unpack += more.unpack;
  sum.copy += more.copy;
  sum.help += more.help;
  sum.idle += more.idle;
  sum.pack += more.pack;
  sum.communication += more.communication;
  return sum;
}

bool is_empty(const Volume& volume) { return volume.sent.messages == 0 && volume.received.messages == 0; }

/// Bytes. getrusage() would do, were its peak not that of whoever started this process if that was larger.
std::uint64_t peak_rss_of_process() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes * 1024;
  }
  return 0;
}

TimeSummary times_of(const Trace& trace, const RunFacts& facts) {
  TimeSummary times;
  for (int i = 0; i < trace.workers(); ++i) {
    const Lane& lane = trace.worker_lane(i);
    times.compute += seconds(lane.time(Activity::compute).total);
    times.unpack += seconds(lane.time(Activity::unpack).total);
    times.copy += seconds(lane.time(Activity::pack).total);  // what workers pack are copies for snapshots
  }
  for (int i = 0; i < trace.helpers(); ++i)
    times.help += seconds(trace.helper_lane(i).time(Activity::help).total);
  times.idle = std::max(0.0, trace.workers() * facts.wall - times.computed() - times.unpack - times.copy);
  times.pack = seconds(trace.communication_lane().time(Activity::pack).total);
  times.communication = facts.communication;
  return times;
}

/// Method `name` (or Span::kNoName) in all lanes; nothing if it neither ran nor had messages.
std::optional<MethodSummary> method_of(const Trace& trace, std::uint32_t name) {
  MethodSummary method;
  for (const Lane& lane : trace.lanes()) {
    const TimeCount time = lane.compute_time(name);
    method.count += time.count;
    method.seconds += seconds(time.total);
    method.longest = std::max(method.longest, seconds(time.longest));
    method.volume += lane.volume(name);
  }
  if (method.count == 0 && is_empty(method.volume)) return std::nullopt;
  return method;
}

std::vector<MethodSummary> methods_of(const Trace& trace, const std::vector<std::string>& names) {
  std::uint32_t count = 0;
  for (const Lane& lane : trace.lanes()) count = std::max(count, lane.num_methods());
  std::vector<MethodSummary> methods;
  for (std::uint32_t name = 0; name < count; ++name) {
    auto method = method_of(trace, name);
    if (!method) continue;
    method->name = name < names.size() ? names[name] : fmt::format("method {}", name);
    methods.push_back(std::move(*method));
  }
  if (auto unnamed = method_of(trace, Span::kNoName)) methods.push_back(std::move(*unnamed));
  return methods;
}

std::vector<PeerSummary> peers_of(const Trace& trace) {
  std::map<Rank, Volume> volumes;
  for (const Lane& lane : trace.lanes()) {
    lane.volumes_by_peer().each([&](std::size_t rank, const Volume& volume) {
      if (!is_empty(volume)) volumes[Rank(static_cast<int>(rank))] += volume;
    });
  }
  std::vector<PeerSummary> peers;
  for (const auto& [rank, volume] : volumes) peers.push_back({rank, volume});
  return peers;
}

void add_lane(RankSummary& summary, const Lane& lane) {
  for (std::size_t i = 0; i < kTraffics; ++i) summary.traffic[i] += lane.volume(static_cast<Traffic>(i));
  summary.dropped_spans += lane.spans().dropped() + lane.departures().dropped();
}

void add(MethodSummary& sum, const MethodSummary& more) {
  sum.count += more.count;
  sum.seconds += more.seconds;
  sum.longest = std::max(sum.longest, more.longest);
  sum.volume += more.volume;
}

/// By name: ranks list only the methods that they met, so indices do not agree.
void add_methods(std::vector<MethodSummary>& sums, const std::vector<MethodSummary>& more) {
  for (const MethodSummary& method : more) {
    const auto known = std::find_if(sums.begin(), sums.end(),
                                    [&](const MethodSummary& sum) { return sum.name == method.name; });
    if (known == sums.end()) {
      sums.push_back(method);
    } else {
      add(*known, method);
    }
  }
}

/// Of the ranks' mean compute seconds per worker, the largest over the mean of all workers: ranks with fewer
/// workers ought to compute less.
double load_imbalance_of(const RunSummary& run) {
  return run.times.computed() > 0 ? run.most_compute * run.workers / run.times.computed() : 1;
}

double idle_share_of(const RunSummary& run) { return run.available > 0 ? run.times.idle / run.available : 0; }

double balance_saving_of(const RunSummary& run) {
  if (run.workers == 0 || run.wall <= 0) return 0;
  return std::max(0.0, 1 - run.times.computed() / run.workers / run.wall);
}

/// An odd number for the messages from one rank to another.
std::uint64_t mark_of(Rank from, Rank to) {
  std::uint64_t x = static_cast<std::uint64_t>(static_cast<std::uint32_t>(from.value)) << 32 |
                    static_cast<std::uint32_t>(to.value);
  x = (x + 0x9E3779B97F4A7C15ull) * 0xBF58476D1CE4E5B9ull;  // the finish of splitmix64
  x = (x ^ x >> 27) * 0x94D049BB133111EBull;
  return (x ^ x >> 31) | 1;
}

/// Counts wrap around, so the order is free.
MessageCount on_the_way_of(const RankSummary& rank) {
  MessageCount sum;
  for (const auto& [peer, volume] : rank.peers) {
    const std::uint64_t out = mark_of(rank.rank, peer), in = mark_of(peer, rank.rank);
    sum.messages += out * volume.sent.messages - in * volume.received.messages;
    sum.bytes += out * volume.sent.bytes - in * volume.received.bytes;
  }
  return sum;
}

Consistency consistency_of(const RunSummary& run) {
  Consistency consistent;
  for (const Volume& volume : run.traffic) {
    consistent.messages &= volume.sent.messages == volume.received.messages;
    consistent.bytes &= volume.sent.bytes == volume.received.bytes;
  }
  consistent.pairs = run.on_the_way.messages == 0 && run.on_the_way.bytes == 0;
  return consistent;
}

/// What follows from the sums.
void conclude(RunSummary& run) {
  run.load_imbalance = load_imbalance_of(run);
  run.idle_share = idle_share_of(run);
  run.balance_saving = balance_saving_of(run);
  run.consistent = consistency_of(run);
}

void join(std::map<std::string, Spread>& all, const std::map<std::string, Spread>& more) {
  for (const auto& [name, spread] : more) {
    const auto [known, is_new] = all.try_emplace(name, spread);
    if (is_new) continue;
    known->second = {known->second.sum + spread.sum, std::min(known->second.min, spread.min),
                     std::max(known->second.max, spread.max)};
  }
}

using Json = nlohmann::ordered_json;

Json json_of(const MessageCount& count) { return {{"messages", count.messages}, {"bytes", count.bytes}}; }

void put(Json& json, const Volume& volume) {
  json["sent"] = json_of(volume.sent);
  json["received"] = json_of(volume.received);
}

void put(Json& json, const TimeSummary& times) {
  json["compute"] = times.compute;
  json["unpack"] = times.unpack;
  json["copy"] = times.copy;
  json["help"] = times.help;
  json["idle"] = times.idle;
  json["pack"] = times.pack;
  json["communication"] = times.communication;
}

Json json_of(const std::vector<MethodSummary>& methods) {
  Json list = Json::array();
  for (const MethodSummary& method : methods) {
    Json json = {{"name", method.name},
                 {"count", method.count},
                 {"seconds", method.seconds},
                 {"longest", method.longest}};
    put(json, method.volume);
    list.push_back(std::move(json));
  }
  return list;
}

Json json_of(const TrafficSummary& traffic) {
  Json json = Json::object();
  for (std::size_t i = 0; i < kTraffics; ++i) put(json[name_of(static_cast<Traffic>(i))], traffic[i]);
  return json;
}

Json json_of(const std::vector<PeerSummary>& peers) {
  Json list = Json::array();
  for (const PeerSummary& peer : peers) {
    Json json = {{"rank", peer.rank.value}};
    put(json, peer.volume);
    list.push_back(std::move(json));
  }
  return list;
}

/// A map or a list of pairs as an object: a Json made of them would be a list.
template <class Pairs>
Json object_of(const Pairs& pairs) {
  Json json = Json::object();
  for (const auto& [name, value] : pairs) json[name] = value;
  return json;
}

Json json_of(const std::map<std::string, Spread>& counters) {
  Json json = Json::object();
  for (const auto& [name, spread] : counters) {
    json[name] = {{"sum", spread.sum}, {"min", spread.min}, {"max", spread.max}};
  }
  return json;
}

Json json_of(const Consistency& consistent) {
  return {{"messages", consistent.messages}, {"bytes", consistent.bytes}, {"pairs", consistent.pairs}};
}

Json json_of(const std::vector<RankSummary>& ranks) {
  Json list = Json::array();
  for (const RankSummary& rank : ranks) list.push_back(engine::json_of(rank));
  return list;
}

}  // namespace

RankSummary summarize(const Trace& trace, const RunFacts& facts) {
  RankSummary summary;
  summary.rank = trace.rank();
  summary.workers = trace.workers();
  summary.wall = facts.wall;
  summary.times = times_of(trace, facts);
  for (int i = 0; i < trace.workers(); ++i) {
    summary.worker_compute.push_back(seconds(trace.worker_lane(i).time(Activity::compute).total));
  }
  summary.methods = methods_of(trace, facts.method_names);
  summary.peers = peers_of(trace);
  for (const Lane& lane : trace.lanes()) add_lane(summary, lane);
  summary.network_calls = facts.network_calls;
  summary.collective_calls = facts.collective_calls;
  summary.counters = facts.counters;
  if (!VirtualTime::of_thread()) summary.peak_rss = peak_rss_of_process();  // simulated ranks share a process
  return summary;
}

Exchanged exchanged_between(const RankSummary& before, const RankSummary& after) {
  Exchanged exchanged;
  auto known = before.peers.begin();  // both ascend by rank
  for (const PeerSummary& peer : after.peers) {
    while (known != before.peers.end() && known->rank < peer.rank) ++known;
    const bool is_known = known != before.peers.end() && known->rank == peer.rank;
    const Volume old = is_known ? known->volume : Volume{};
    const std::uint64_t sent = peer.volume.sent.messages - old.sent.messages;
    exchanged.messages += sent;
    exchanged.peers += sent > 0 || peer.volume.received.messages > old.received.messages;
  }
  return exchanged;
}

RunSummary run_of(RankSummary rank, bool keep_rank) {
  RunSummary run;
  run.num_ranks = 1;
  run.workers = rank.workers;
  run.wall = rank.wall;
  run.times = rank.times;
  run.methods = rank.methods;
  run.traffic = rank.traffic;
  for (const auto& [name, calls] : rank.network_calls) run.network_calls[name] += calls;
  run.collective_calls = rank.collective_calls;
  for (const auto& [name, value] : rank.counters) run.counters[name] = {value, value, value};
  run.peak_rss_sum = run.peak_rss_max = rank.peak_rss;
  run.dropped_spans = rank.dropped_spans;
  run.most_compute = rank.times.computed() / std::max(1, rank.workers);
  run.available = rank.workers * rank.wall;
  run.on_the_way = on_the_way_of(rank);
  if (keep_rank) run.ranks.push_back(std::move(rank));
  conclude(run);
  return run;
}

RunSummary join(RunSummary a, RunSummary b) {
  a.num_ranks += b.num_ranks;
  a.workers += b.workers;
  a.wall = std::max(a.wall, b.wall);
  a.times += b.times;
  add_methods(a.methods, b.methods);
  for (std::size_t i = 0; i < kTraffics; ++i) a.traffic[i] += b.traffic[i];
  for (const auto& [name, calls] : b.network_calls) a.network_calls[name] += calls;
  a.collective_calls += b.collective_calls;
  join(a.counters, b.counters);
  a.peak_rss_sum += b.peak_rss_sum;
  a.peak_rss_max = std::max(a.peak_rss_max, b.peak_rss_max);
  a.dropped_spans += b.dropped_spans;
  a.most_compute = std::max(a.most_compute, b.most_compute);
  a.available += b.available;
  a.on_the_way += b.on_the_way;
  std::move(b.ranks.begin(), b.ranks.end(), std::back_inserter(a.ranks));
  std::ranges::sort(a.ranks, {}, &RankSummary::rank);
  conclude(a);
  return a;
}

RunSummary merge(std::vector<RankSummary> ranks) {
  std::ranges::sort(ranks, {}, &RankSummary::rank);
  RunSummary run;
  for (RankSummary& rank : ranks) {
    std::vector<RankSummary> before = std::exchange(run.ranks, {});
    run = join(std::move(run), run_of(rank, false));
    run.ranks = std::move(before);
    run.ranks.push_back(std::move(rank));
  }
  return run;
}

std::string RunSummary::verdict() const {
  return fmt::format("perfect balance would save {:.0f} % of {:.3g} s", 100 * balance_saving, wall);
}

nlohmann::ordered_json json_of(const RankSummary& summary) {
  Json json = {{"rank", summary.rank.value}, {"workers", summary.workers}, {"wall", summary.wall}};
  put(json, summary.times);
  json["worker_compute"] = summary.worker_compute;
  json["methods"] = json_of(summary.methods);
  json["traffic"] = json_of(summary.traffic);
  json["peers"] = json_of(summary.peers);
  json["network_calls"] = object_of(summary.network_calls);
  json["collective_calls"] = summary.collective_calls;
  json["counters"] = object_of(summary.counters);
  json["peak_rss"] = summary.peak_rss;
  json["dropped_spans"] = summary.dropped_spans;
  return json;
}

nlohmann::ordered_json json_of(const RunSummary& summary) {
  Json json = {{"schema", "weft-engine-1"},
               {"ranks", summary.num_ranks},
               {"workers", summary.workers},
               {"wall", summary.wall}};
  put(json, summary.times);
  json["load_imbalance"] = summary.load_imbalance;
  json["idle_share"] = summary.idle_share;
  json["balance_saving"] = summary.balance_saving;
  json["verdict"] = summary.verdict();
  json["methods"] = json_of(summary.methods);
  json["traffic"] = json_of(summary.traffic);
  json["network_calls"] = object_of(summary.network_calls);
  json["collective_calls"] = summary.collective_calls;
  json["counters"] = json_of(summary.counters);
  json["peak_rss"] = {{"sum", summary.peak_rss_sum}, {"max", summary.peak_rss_max}};
  json["dropped_spans"] = summary.dropped_spans;
  json["consistent"] = json_of(summary.consistent);
  json["per_rank"] = json_of(summary.ranks);
  return json;
}

}  // namespace weft::engine
