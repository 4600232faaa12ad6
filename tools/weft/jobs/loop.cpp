// Cycles, markers, resumption.
#include "tools/weft/jobs/loop.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <optional>
#include <system_error>
#include <vector>

#include "engine/json/json.h"
#include "tools/common/inputs.h"
#include "tools/common/shell_command.h"
#include "tools/common/text.h"
#include "tools/weft/terminal/exit_codes.h"
#include "tools/weft/terminal/interrupt.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "weft-cycle-1";

/// Keeps a second loop out of a folder. The solver inherits the lock: one that outlived a killed loop would
/// write into the cycle that is being done again.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder) {
    const fs::path path = folder / "lock";
    descriptor_ = open(path.c_str(), O_RDWR | O_CREAT, 0666);
    if (descriptor_ < 0) throw InputError(path.string(), "", "cannot be made");
    if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
    close(descriptor_);
    throw InputError(folder.string(), "",
                     "another loop, or a solver that one left behind, still runs in this folder");
  }
  ~FolderLock() { close(descriptor_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

/// The files of one cycle.
struct CycleFiles {
  fs::path folder, mesh, solution, restart, log, marker;
  fs::path checkpoints, checkpoints_of;  ///< of the adaptation, and the run that they belong to
};

class Loop {
 public:
  Loop(const LoopConfig& config, const Verbosity& verbosity) : config_(config), verbosity_(verbosity) {}

  int run() {
    keep_first_mesh();
    fs::create_directories(config_.folder);
    const FolderLock lock(config_.folder);
    const std::size_t first = count_finished();
    if (first > 0) verbosity_.print("cycles 0 to {} are done already\n", first - 1);
    forget_from(first);
    remove_half_written(config_.folder);
    for (std::size_t cycle = first; cycle < cycles(); ++cycle)
      if (!do_cycle(cycle)) return interrupted(cycle);
    write_table();
    verbosity_.print("{}: {} cycles done\n", config_.folder.string(), cycles());
    return finished_.back().at("goal_met") == true ? kDone : kGoalNotMet;
  }

 private:
  std::size_t cycles() const { return config_.complexities.size() + 1; }

  CycleFiles files(std::size_t cycle) const {
    const fs::path folder = config_.folder / fmt::format("{:03}", cycle);
    const fs::path mesh = folder / ("mesh" + config_.mesh_extension);
    return {folder,
            cycle == 0 ? config_.mesh : mesh,
            folder / ("solution" + config_.solution_extension),
            cycle == 0 ? fs::path() : fs::path(result_files(mesh.string()).fields),
            folder / "solver.log",
            folder / "done.json",
            folder / "checkpoints",
            folder / "checkpoints.json"};
  }

  /// It may be the result of an earlier loop in the same folder, or a solution, which can hold a mesh.
  void keep_first_mesh() const {
    const auto keep = [this](const fs::path& file, const char* what, std::size_t cycle) {
      const std::string mesh = config_.mesh.string();
      if (same_file(file.string(), mesh) || is_piece_of(file.string(), mesh))
        throw InputError(
            config_.file, "mesh",
            fmt::format("would be replaced by {} of cycle {}: give another folder", what, cycle));
    };
    for (std::size_t cycle = 0; cycle < cycles(); ++cycle) {
      if (cycle > 0) keep(files(cycle).mesh, "that", cycle);
      keep(files(cycle).solution, "the solution", cycle);
    }
  }

  /// Reads the markers of the cycles that need not be done again.
  std::size_t count_finished() {
    for (std::size_t cycle = 0; cycle < cycles(); ++cycle) {
      const CycleFiles f = files(cycle);
      if (!fs::exists(f.marker) || !fs::exists(f.solution) || !fs::exists(f.mesh)) break;
      finished_.push_back(read_marker(f.marker));
      check_settings(cycle);
    }
    return finished_.size();
  }

  static Json read_marker(const fs::path& path) {
    std::ifstream in(path);
    Json marker = Json::parse(in, nullptr, false);
    const bool good = engine::schema_of(marker) == kSchema && marker.contains("settings") &&
                      marker["settings"].is_object() && marker.contains("goal_met");
    if (!good)
      throw InputError(path.string(), "", "is no marker of a cycle: remove it to do the cycle again");
    return marker;
  }

  void check_settings(std::size_t cycle) const {
    const Json wanted = config_.settings(cycle);
    const Json& made = finished_.back().at("settings");
    for (const auto& [key, value] : wanted.items())
      if (!made.contains(key) || made.at(key) != value)
        throw InputError(
            config_.file, key,
            fmt::format("has changed since cycle {} was done: remove {} to do it and all later ones again",
                        cycle, files(cycle).folder.string()));
  }

  /// What came after a cycle that is to be done again was made from it, though the folder of that may be
  /// gone.
  void forget_from(std::size_t first) const {
    for (const fs::directory_entry& entry : fs::directory_iterator(config_.folder)) {
      const std::string name = entry.path().filename().string();
      std::size_t cycle = 0;
      if (std::from_chars(name.data(), name.data() + name.size(), cycle).ec != std::errc()) continue;
      if (cycle < first || files(cycle).folder.filename() != name) continue;
      fs::remove(files(cycle).marker);
      if (cycle > first) remove_checkpoints(cycle);
    }
  }

  void remove_checkpoints(std::size_t cycle) const {
    fs::remove_all(files(cycle).checkpoints);
    fs::remove(files(cycle).checkpoints_of);
  }

  /// Where they are asked for: an adaptation that was killed goes on from those of the same settings. A run
  /// of one mesh and one in subdomains refuse each other's.
  void keep_checkpoints(std::size_t cycle, Options& options) const {
    constexpr const char* kEvery = "checkpoint-every";
    if (get_option(options, kEvery) == get_option({}, kEvery)) return;
    const CycleFiles f = files(cycle);
    const Json wanted = {{"settings", config_.settings(cycle)},
                         {"in_subdomains", !config_.launcher.empty() || in_subdomains(options)}};
    std::ifstream in(f.checkpoints_of);
    if (!(Json::parse(in, nullptr, false) == wanted)) {  // no file gives what is neither equal nor unequal
      remove_checkpoints(cycle);
      write_text(f.checkpoints_of.string(), wanted.dump() + "\n");
    }
    options.checkpoint.folder = options.checkpoint.resume = f.checkpoints.string();
  }

  /// What a killed run was writing still has its temporary name; the lock says that nobody writes it now.
  static void remove_half_written(const fs::path& folder) {
    std::vector<fs::path> left;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (entry.path().filename().string().starts_with(".weft-")) left.push_back(entry.path());
    for (const fs::path& path : left) fs::remove(path);
  }

  /// False when interrupted.
  bool do_cycle(std::size_t cycle) {
    const CycleFiles f = files(cycle);
    fs::create_directories(f.folder);
    remove_half_written(f.folder);
    fs::remove(f.solution);  // a solver that writes none must not seem to have
    Json marker = {
        {"schema", kSchema}, {"cycle", cycle}, {"settings", config_.settings(cycle)}, {"goal_met", true}};
    if (cycle > 0 && !adapt(cycle, marker)) return false;
    if (!solve(cycle, marker)) return false;
    write_text(f.marker.string(), marker.dump(1) + "\n");
    finished_.push_back(std::move(marker));
    write_table();
    report(finished_.back());
    return true;
  }

  bool adapt(std::size_t cycle, Json& marker) const {
    const CycleFiles last = files(cycle - 1), now = files(cycle);
    Files files;
    files.input = last.mesh.string();
    files.output = now.mesh.string();
    files.report = now.folder.string();
    files.page = false;
    files.fields = {last.solution.string()};
    Options options = config_.options;
    options.metric.sol = files.fields;
    options.metric.complexity = config_.complexities[cycle - 1];
    marker["target_complexity"] = options.metric.complexity;
    keep_checkpoints(cycle, options);
    const bool done = config_.launcher.empty() ? adapt_here(cycle, files, options, marker)
                                               : adapt_on_ranks(cycle, files, options, marker);
    if (done) remove_checkpoints(cycle);
    return done;
  }

  bool adapt_here(std::size_t cycle, const Files& files, Options& options, Json& marker) const {
    const InterruptGuard interrupt;
    options.run.cancel = interrupt.flag();
    Progress progress(verbosity_.style());
    options.run.progress = [&progress](const weft::Progress& state) {
      progress.show(state);
      return true;
    };
    const FilesResult run = adapt_files(files, options);
    check_end(cycle, run.ended_by);
    if (run.cancelled) return false;
    if (!run.after) refuse_unmeasured(cycle, run.report_error);
    marker["goal_met"] = run.goal_met();
    marker["complexity"] = run.after->complexity;
    marker["vertices"] = run.after->num_vertices;
    marker["tets"] = run.after->num_tets;
    marker["unit_edges"] = run.after->edges_unit;
    marker["adapt_seconds"] = run.times.total;
    return true;
  }

  /// `weft adapt`, started by the launcher.
  bool adapt_on_ranks(std::size_t cycle, const Files& files, const Options& options, Json& marker) const {
    const fs::path folder = files.report, log = folder / "adapt.log", json = folder / "report.json";
    for (const fs::path& file : {fs::path(files.output), json}) fs::remove(file);
    const InterruptGuard interrupt;
    const ShellResult result =
        run_shell(config_.launcher + " " + adapt_line(files, options), config_.home, log, *interrupt.flag());
    if (interrupt.raised()) return false;
    const bool ended_well = result.status == kDone || result.status == kGoalNotMet;
    if (!ended_well || !fs::exists(files.output) || !fs::exists(json))
      throw InputError(config_.file, "adapt.launcher",
                       fmt::format("cycle {}: {}{}; it said: {}", cycle,
                                   ended_well ? "wrote no mesh" : fmt::format("ended with {}", result.status),
                                   issue_in(log), log.string()));
    return read_report(cycle, json, marker);
  }

  /// The mesh is there, but memory ran out before it was measured: of such a cycle there is nothing to tell.
  [[noreturn]] void refuse_unmeasured(std::size_t cycle, const std::string& why) const {
    throw InputError(config_.file, "adapt", fmt::format("cycle {}: {}", cycle, why));
  }

  /// Whoever interrupts a run goes on later; a limit would end it again.
  void check_end(std::size_t cycle, const std::string& ended_by) const {
    if (!ended_by.empty() && ended_by != "interrupted")
      throw InputError(config_.file, "adapt", fmt::format("cycle {}: ended early: {}", cycle, ended_by));
  }

  /// With the options that are not as they are by themselves.
  static std::string adapt_line(const Files& files, const Options& options) {
    std::string line =
        "{weft} adapt {in} --sol {sol} --field {sol} -o {out} --report {report} --no-page --progress none";
    std::map<std::string, std::string> values = {{"weft", fs::read_symlink("/proc/self/exe").string()},
                                                 {"in", files.input},
                                                 {"sol", files.fields[0]},
                                                 {"out", files.output},
                                                 {"report", files.report}};
    const Options plain;
    for (const NamedOption& option : named_options()) {
      const std::string value = get_option(options, option.name);
      if (!option.of_command || option.name == "sol" || value == get_option(plain, option.name)) continue;
      line += " --" + option.name;
      if (option.type == "yes or no") continue;
      line += " {" + option.name + "}";
      values[option.name] = value;
    }
    return filled_in(line, values);
  }

  /// What weft itself said in a log, if anything.
  static std::string issue_in(const fs::path& log) {
    std::ifstream in(log);
    for (std::string line; std::getline(in, line);)
      if (line.starts_with("weft")) return ": " + line;
    return {};
  }

  /// False where the adaptation was interrupted.
  bool read_report(std::size_t cycle, const fs::path& path, Json& marker) const {
    std::ifstream in(path);
    const Json report = Json::parse(in);
    check_end(cycle, report.at("ended_by").get<std::string>());
    if (report.at("interrupted") == true) return false;
    const Json &after = report.at("after"), &subdomains = report.at("subdomains");
    if (after.is_null()) refuse_unmeasured(cycle, "its result was not measured; see " + path.string());
    marker["goal_met"] = report.at("goal_met");
    marker["complexity"] = after.at("complexity");
    marker["vertices"] = after.at("vertices");
    marker["tets"] = after.at("tets");
    marker["unit_edges"] = after.at("edge_length").at("share_unit");
    marker["adapt_seconds"] = report.at("seconds").at("total");
    marker["ranks"] = subdomains.is_null() ? Json(1) : subdomains.at("ranks");
    return true;
  }

  bool solve(std::size_t cycle, Json& marker) const {
    const CycleFiles f = files(cycle);
    const std::string line = filled_in(config_.solver, {{"mesh", f.mesh.string()},
                                                        {"solution", f.solution.string()},
                                                        {"restart", f.restart.string()},
                                                        {"cycle", std::to_string(cycle)}});
    const auto start = std::chrono::steady_clock::now();
    const InterruptGuard interrupt;
    const ShellResult result = run_shell(line, config_.home, f.log, *interrupt.flag());
    if (interrupt.raised()) return false;
    const std::string where = fmt::format("cycle {}", cycle);
    if (result.status != 0)
      throw InputError(config_.file, "solver",
                       fmt::format("{}: ended with {}; it said: {}", where, result.status, f.log.string()));
    if (!fs::exists(f.solution))
      throw InputError(
          config_.file, "solver",
          fmt::format("{}: wrote no {}; it said: {}", where, f.solution.string(), f.log.string()));
    check_solution(f, marker);
    marker["solver_seconds"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return true;
  }

  /// Better found now than when the next cycle wants to read it.
  void check_solution(const CycleFiles& f, const Json& marker) const {
    const std::string mesh = f.mesh.string(), file = f.solution.string();
    const Fields solution = config_.launcher.empty()
                                ? read_fields({file}, read_mesh(mesh).points.size(), mesh)
                                : check_field_file(file, vertices_of(mesh, marker), mesh);
    const auto scalar = [](const Field& field) { return field.kind == Field::Kind::scalar; };
    if (std::ranges::none_of(solution.fields, scalar)) throw InputError(file, "", "has no scalar field");
  }

  /// Where ranks adapt a mesh, it may fit into all of them together alone: this process does not hold it.
  static VertexCount vertices_of(const std::string& mesh, const Json& marker) {
    if (!marker.contains("vertices")) return count_vertices(mesh);
    const auto vertices = marker.at("vertices").get<std::uint64_t>();  // of the adaptation's result
    return {vertices, vertices};
  }

  void report(const Json& marker) const {
    const auto cycle = marker.at("cycle").get<std::size_t>();
    std::string text = fmt::format("cycle {} of {}: ", cycle, cycles() - 1);
    if (cycle > 0)
      text += fmt::format(
          "complexity {}, {} vertices, {} tets, {} unit edges{}; adapted{} in {}, ",
          grouped(marker.at("complexity").get<double>()), grouped(marker.at("vertices").get<std::uint64_t>()),
          grouped(marker.at("tets").get<std::uint64_t>()), percent(marker.at("unit_edges").get<double>()),
          marker.at("goal_met") == true ? "" : " (GOAL NOT MET)",
          marker.contains("ranks") ? fmt::format(" on {} ranks", marker.at("ranks").get<int>()) : "",
          seconds_text(marker.at("adapt_seconds").get<double>()));
    verbosity_.print("{}solved in {}\n", text, seconds_text(marker.at("solver_seconds").get<double>()));
    std::fflush(stdout);  // a loop can take days: its lines must not wait in a buffer
  }

  void write_table() const {
    const char* const columns[] = {"cycle", "target_complexity", "complexity",    "vertices",
                                   "tets",  "unit_edges",        "adapt_seconds", "solver_seconds"};
    std::string text = fmt::format("{}\n", fmt::join(columns, ","));
    for (const Json& marker : finished_)
      for (const char* column : columns) {
        text += marker.contains(column) ? marker.at(column).dump() : "";
        text += column == std::end(columns)[-1] ? "\n" : ",";
      }
    write_text((config_.folder / "cycles.csv").string(), text);
  }

  int interrupted(std::size_t cycle) const {
    verbosity_.print("interrupted in cycle {}: run the same command again to go on there\n", cycle);
    return kGoalNotMet;
  }

  const LoopConfig& config_;
  const Verbosity& verbosity_;
  std::vector<Json> finished_;  ///< the markers
};

}  // namespace

int run_loop(const LoopConfig& config, const Verbosity& verbosity) { return Loop(config, verbosity).run(); }

}  // namespace weft::tools
