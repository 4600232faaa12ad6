// Replays of recorded graphs, and their accounts.
#include "weft/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "engine/base/text.h"
#include "engine/json/json.h"
#include "graph/dataflow/dump/critical_path.h"
#include "graph/replay/replay.h"
#include "graph/replay/replay_plan.h"
#include "tools/common/inputs.h"
#include "tools/library/api/require.h"
#include "tools/library/jobs/file_job.h"
#include "tools/library/jobs/outputs.h"
#include "tools/library/report/graph_file.h"
#include "tools/library/report/json_file.h"
#include "tools/library/report/report_json.h"
#include "tools/library/report/run_record.h"
#include "tools/report/profile.h"
#include "tools/report/report_page.h"

namespace weft {
namespace {

namespace fs = std::filesystem;
using graph::dataflow::GraphDump;
using Json = nlohmann::ordered_json;

constexpr std::uint64_t kUsualBytes = 1 << 20;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40;

template <class Call>
auto naming_option(const char* option, const Call& call) {
  try {
    return call();
  } catch (const std::invalid_argument& error) {
    throw OptionError(option, error.what());
  }
}

void require_ranks(int ranks, const char* option) {
  constexpr int kMostRanks = 30'000;  // two memory maps each
  require(ranks >= 1 && ranks <= kMostRanks, option,
          fmt::format("{} is not between 1 and {}", ranks, kMostRanks));
}

void require_factor(double factor, const char* option) {
  require(factor >= 1e-6 && factor <= 1e6, option, fmt::format("{} is not between 1e-6 and 1e6", factor));
}

graph::replay::ReplayOptions checked(const ReplayOptions& options) {
  require_ranks(options.ranks, "--ranks");
  require(options.threads >= 1 && options.threads <= 1024, "--threads",
          fmt::format("{} is not between 1 and 1024", options.threads));
  require_factor(options.slowdown, "--slowdown");
  require(options.copies >= 1, "--copies", fmt::format("{} is not at least 1", options.copies));
  require(options.split >= 1, "--split", fmt::format("{} is not at least 1", options.split));
  require_factor(options.grow, "--grow");
  require(options.subdomain_bytes <= kMostBytes, "--subdomain-bytes",
          fmt::format("{} is not between 0 and {}", options.subdomain_bytes, kMostBytes));
  graph::replay::ReplayOptions to;
  to.ranks = options.ranks;
  to.threads = options.threads;
  to.network = naming_option("--network", [&] { return engine::parse_network(options.network); });
  to.balancer = naming_option("--balancer", [&] { return engine::balancer_by_name(options.balancer); });
  to.slowdown = options.slowdown;
  to.timelines = !options.trace.empty() || !options.report.empty();
  return to;
}

fs::path beside(const std::string& graph, const char* name) { return fs::path(graph).parent_path() / name; }

/// The files that a replay writes: all different, none of the recording, and they can be written. Makes the
/// folder of the report, in which others may be.
void check_outputs(const std::string& graph, const ReplayOptions& options) {
  std::vector<tools::OutputFile> outputs;
  if (!options.report.empty())
    for (const char* name : {"replay.json", "graph.json", "profile.json", "report.html"})
      outputs.push_back({"--report", (fs::path(options.report) / name).string()});
  for (const auto& [option, file] : {std::pair{"--trace", options.trace}, {"--account", options.account}})
    if (!file.empty()) outputs.push_back({option, file});
  tools::keep_apart(outputs);
  const std::vector<std::string> recording = {graph, beside(graph, "profile.json").string(),
                                              beside(graph, "report.json").string()};
  for (const tools::OutputFile& output : outputs)
    tools::keep_inputs(output.path, output.path, recording, output.option);
  if (!options.report.empty()) tools::make_folder(options.report);
  for (const tools::OutputFile& output : outputs) tools::check_writable(output.path);
}

/// Of a recorded subdomain; empty where the profile does not tell.
std::optional<double> recorded_bytes(const Json& profile, std::size_t subdomains) {
  try {
    if (profile.contains("simulation") && profile.at("simulation").is_object()) {
      const Json& replayed = profile.at("simulation");
      if (replayed.at("subdomain_bytes_from") == "assumed") return std::nullopt;
      return replayed.at("subdomain_bytes").get<double>();
    }
    double bytes = profile.at("engine").at("peak_rss").at("sum").get<double>();  // 0: unknown
    for (const Json& rank : profile.at("memory")) bytes -= rank.at("bytes").at(0).get<double>();
    if (!(bytes > 0) || profile.at("memory").empty()) return std::nullopt;
    return bytes / static_cast<double>(subdomains);
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

/// The profile beside the recorded graph; null where there is none.
Json profile_beside(const std::string& graph) {
  const fs::path path = beside(graph, "profile.json");
  std::error_code ignored;
  return fs::exists(path, ignored) ? tools::read_json(path.string()) : Json();
}

struct SubdomainBytes {
  std::uint64_t bytes;
  const char* from;
};

/// `profile`: that the graph was in; null: it may lie beside `path`.
SubdomainBytes bytes_of_subdomain(const std::string& path, Json profile, std::size_t subdomains,
                                  const ReplayOptions& options) {
  if (options.subdomain_bytes > 0) return {options.subdomain_bytes, "given"};
  if (profile.is_null()) profile = profile_beside(path);
  const auto recorded = recorded_bytes(profile, subdomains);
  const double bytes = recorded.value_or(kUsualBytes) * options.grow / options.split;
  return {static_cast<std::uint64_t>(std::clamp(bytes, 1.0, static_cast<double>(kMostBytes))),
          recorded ? "recorded" : "assumed"};
}

double seconds_of(engine::TimePoint time) { return 1e-9 * static_cast<double>(time); }

/// From the first task's begin, which is 0, to the last one's end.
double span_of(const GraphDump& graph) {
  double last = 0;
  for (const auto& run : graph.runs) last = std::max(last, seconds_of(run.end));
  return last;
}

double largest_of(const GraphDump& graph) {
  std::vector<double> work(graph.instances.size());
  for (const auto& run : graph.runs) work[run.instance] += seconds_of(run.end - run.begin);
  return work.empty() ? 0 : *std::max_element(work.begin(), work.end());
}

void add_traffic(const graph::replay::Replayed& replayed, ReplayResult& result) {
  for (std::size_t i = 0; i < engine::kTraffics; ++i) {
    const engine::MessageCount& sent = replayed.engine.traffic[i].sent;
    const bool moves = static_cast<engine::Traffic>(i) == engine::Traffic::migrate;
    (moves ? result.migrations : result.messages) += sent.messages;
    (moves ? result.migrated_bytes : result.message_bytes) += sent.bytes;
  }
  result.packets = replayed.simulation.packets;
  result.packet_bytes = replayed.simulation.bytes;
}

ReplayResult result_of(const GraphDump& recorded, const graph::replay::Replayed& replayed,
                       const ReplayOptions& options, const graph::replay::ReplayOptions& used) {
  ReplayResult result;
  result.options = options;
  result.network = text_of(used.network);
  result.subdomains = recorded.instances.size();
  result.tasks = recorded.runs.size();
  result.seconds = replayed.seconds;
  result.work = replayed.work;
  result.critical_path = seconds_of(replayed.graph.critical_path.length);
  const double cores = static_cast<double>(options.ranks) * options.threads;
  result.efficiency = replayed.seconds > 0 ? replayed.work / (replayed.seconds * cores) : 1;
  result.idle_share = replayed.engine.idle_share;
  result.run_seconds = replayed.engine.wall;
  result.largest_subdomain = largest_of(replayed.graph);
  add_traffic(replayed, result);
  result.subdomain_bytes = used.object_bytes;
  for (const std::uint64_t objects : replayed.most_objects) {
    result.most_subdomains = std::max(result.most_subdomains, objects);
    result.memory.push_back(objects * used.object_bytes);
  }
  result.simulation_seconds = replayed.simulation.real_seconds;
  return result;
}

/// Without what was sent from each rank to each, which thousands of ranks have gigabytes of.
Json json_of(const ReplayResult& result, const std::string& path, engine::RunSummary engine) {
  for (engine::RankSummary& rank : engine.ranks) rank.peers.clear();
  const ReplayOptions& o = result.options;
  return {{"schema", "weft-replay-1"},
          {"graph", path},
          {"ranks", o.ranks},
          {"threads", o.threads},
          {"network", o.network},
          {"balancer", o.balancer},
          {"slowdown", o.slowdown},
          {"processor_times", o.processor_times},
          {"copies", o.copies},
          {"split", o.split},
          {"grow", o.grow},
          {"subdomains", result.subdomains},
          {"tasks", result.tasks},
          {"recorded_seconds", result.recorded_seconds},
          {"seconds", result.seconds},
          {"run_seconds", result.run_seconds},
          {"work_seconds", result.work},
          {"critical_path_seconds", result.critical_path},
          {"largest_subdomain_seconds", result.largest_subdomain},
          {"efficiency", result.efficiency},
          {"idle_share", result.idle_share},
          {"messages", {{"messages", result.messages}, {"bytes", result.message_bytes}}},
          {"packets", {{"packets", result.packets}, {"bytes", result.packet_bytes}}},
          {"migrations", {{"messages", result.migrations}, {"bytes", result.migrated_bytes}}},
          {"most_subdomains", result.most_subdomains},
          {"subdomain_bytes", result.subdomain_bytes},
          {"subdomain_bytes_from", result.subdomain_bytes_from},
          {"memory_by_rank", result.memory},
          {"simulation_seconds", result.simulation_seconds},
          {"engine", engine::json_of(engine)}};
}

engine::Annotations annotations_of(const graph::replay::Replayed& replayed) {
  const GraphDump& graph = replayed.graph;
  engine::Annotations annotations;
  annotations.ranks = replayed.engine.num_ranks;
  annotations.object_kind = graph.description.name;
  std::map<engine::ObjectId, std::uint64_t> numbers;
  for (const auto& instance : graph.instances) numbers[instance.object] = instance.number;
  annotations.number_of = [numbers](engine::ObjectId object) -> std::optional<std::uint64_t> {
    const auto found = numbers.find(object);
    return found == numbers.end() ? std::nullopt : std::optional(found->second);
  };
  return annotations;
}

void write_trace(const std::string& path, const graph::replay::Replayed& replayed) {
  std::ostringstream text = engine::text_stream();
  engine::write_chrome_trace(text, replayed.timelines, annotations_of(replayed));
  tools::write_text(path, text.str());
}

/// As a real run writes it, but for the mesh, which was not made. `text`: of the account.
void write_report(const std::string& folder, const Json& account, const std::string& text,
                  const graph::replay::Replayed& replayed) {
  tools::write_text((fs::path(folder) / "replay.json").string(), text);
  tools::write_graph((fs::path(folder) / "graph.json").string(), replayed.graph);
  Json simulation = account;
  for (const char* elsewhere : {"schema", "memory_by_rank", "engine"}) simulation.erase(elsewhere);
  const Json no_report;
  const Json profile = report::profile_json({.report = no_report,
                                             .simulation = &simulation,
                                             .engine = &replayed.engine,
                                             .graph = &replayed.graph,
                                             .timelines = replayed.timelines});
  tools::write_text((fs::path(folder) / "profile.json").string(), tools::text_of(profile) + "\n");
  tools::write_text((fs::path(folder) / "report.html").string(), report::report_page(profile));
}

engine::SimulationOptions checked(const SimulatedRanks& ranks, const Options& options) {
  constexpr const char* kRanks = "--simulate-ranks";
  require_ranks(ranks.ranks, kRanks);
  require_positive("--simulate-slowdown", ranks.slowdown);
  const CheckpointOptions& checkpoint = options.checkpoint;
  require(options.run.time_limit <= 0 && options.run.max_memory <= 0 && checkpoint.folder.empty() &&
              checkpoint.resume.empty(),
          kRanks, "is not possible with limits of time and memory, nor with checkpoints");
  require(!under_mpirun(), kRanks, "is not possible under mpirun");
  engine::SimulationOptions to;
  to.ranks = ranks.ranks;
  to.network = naming_option("--simulate-network", [&] { return engine::parse_network(ranks.network); });
  to.slowdown = ranks.slowdown;
  require(ranks.cores >= 0, "--simulate-cores", fmt::format("there cannot be {}", ranks.cores));
  to.cores = ranks.cores;
  return to;
}

}  // namespace

SimulatedFilesResult adapt_files_on(const SimulatedRanks& ranks, const Files& files, const Options& options) {
  validate(options);
  const engine::SimulationOptions simulation = checked(ranks, options);
  engine::SimulationResult simulated;
  SimulatedFilesResult result;
  static_cast<FilesResult&>(result) =
      tools::adapt_files_on_simulated_ranks(files, options, simulation, simulated);
  result.on = ranks;
  result.seconds = simulated.seconds;
  result.packets = simulated.packets;
  result.packet_bytes = simulated.bytes;
  result.simulation_seconds = simulated.real_seconds;
  return result;
}

std::string summary(const SimulatedFilesResult& r) {
  return summary(static_cast<const FilesResult&>(r)) +
         fmt::format("simulated: {} ranks, {}: {:.4g} s, {} packets of {:.4g} MiB; in {:.3g} s here\n",
                     r.on.ranks, r.on.network, r.seconds, r.packets,
                     static_cast<double>(r.packet_bytes) / (1 << 20), r.simulation_seconds);
}

ReplayResult replay(const std::string& path, const ReplayOptions& options) {
  graph::replay::ReplayOptions used = checked(options);
  check_outputs(path, options);
  Json profile;
  GraphDump recorded = tools::read_graph(path, &profile);
  const double recorded_seconds = span_of(recorded);  // before its tasks get other times
  const SubdomainBytes memory =
      bytes_of_subdomain(path, std::move(profile), recorded.instances.size(), options);
  used.object_bytes = memory.bytes;
  const graph::replay::Replayed replayed = tools::naming_document(path, [&] {
    if (options.processor_times) graph::replay::take_processor_times(recorded);
    if (options.copies > 1 || options.split > 1 || options.grow != 1)
      recorded = graph::replay::enlarged(recorded, {.copies = static_cast<std::uint32_t>(options.copies),
                                                    .split = static_cast<std::uint32_t>(options.split),
                                                    .grow = options.grow});
    return graph::replay::replay(recorded, used);
  });
  ReplayResult result = result_of(recorded, replayed, options, used);
  result.recorded_seconds = recorded_seconds;
  result.subdomain_bytes_from = memory.from;
  const Json account = json_of(result, path, replayed.engine);
  result.json = tools::text_of(account, 1) + "\n";
  if (!options.report.empty()) {
    result.report = (fs::path(options.report) / "replay.json").string();
    write_report(options.report, account, result.json, replayed);
  }
  if (!options.account.empty()) tools::write_text(options.account, result.json);
  if (!options.trace.empty()) write_trace(options.trace, replayed);
  return result;
}

namespace {

std::string origin_of(const std::string& subdomain_bytes_from) {
  if (subdomain_bytes_from == "given") return "as given";
  return subdomain_bytes_from == "recorded" ? "of the recording's memory" : "assumed: no profile.json tells";
}

}  // namespace

std::string summary(const ReplayResult& r) {
  const auto mebibytes = [](std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
  const std::uint64_t most = r.memory.empty() ? 0 : *std::max_element(r.memory.begin(), r.memory.end());
  const int cores = r.options.ranks * r.options.threads;
  std::string text;
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("{:<16}{}\n", name, value);
  };
  line("simulated on", fmt::format("{} ranks x {} threads, {}, balancer {}", r.options.ranks,
                                   r.options.threads, r.network, r.options.balancer));
  line("graph", fmt::format("{} subdomains, {} tasks, recorded in {:.4g} s", r.subdomains, r.tasks,
                            r.recorded_seconds));
  line("time", fmt::format("{:.4g} s, {:.1f} times as fast as one core (the adaptation's loop)", r.seconds,
                           r.seconds > 0 ? r.work / r.seconds : 1));
  line("work", fmt::format("{:.4g} s; critical path {:.4g} s, largest subdomain {:.4g} s", r.work,
                           r.critical_path, r.largest_subdomain));
  line("efficiency",
       fmt::format("{:.1f} % of {} cores; idle {:.1f} %", 100 * r.efficiency, cores, 100 * r.idle_share));
  line("end", fmt::format("found {:.3g} s after the last task", std::max(0.0, r.run_seconds - r.seconds)));
  line("messages", fmt::format("{} of {:.4g} MiB between ranks; with moves and the engine's own {} packets",
                               r.messages, mebibytes(r.message_bytes), r.packets));
  line("migrations",
       fmt::format("{} subdomains moved, {:.4g} MiB", r.migrations, mebibytes(r.migrated_bytes)));
  line("memory",
       fmt::format("at most {} subdomains on a rank, {:.4g} MiB ({:.3g} MiB each, {})", r.most_subdomains,
                   mebibytes(most), mebibytes(r.subdomain_bytes), origin_of(r.subdomain_bytes_from)));
  line("simulated in", fmt::format("{:.3g} s", r.simulation_seconds));
  return text;
}

}  // namespace weft
