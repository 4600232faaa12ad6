// Reads the keys; each one that is asked for is ticked off, and what is left over is unknown.
#include "tools/weft/options/loop_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <string_view>
#include <thread>

#include "engine/json/json.h"
#include "tools/weft/options/arguments.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json parse(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file, "", "cannot be opened");
  try {
    return Json::parse(in);
  } catch (const Json::parse_error& error) {
    const std::string text = error.what();  // "[json.exception...] parse error at line 1, column 2: ..."
    const auto at = text.find("at line");
    throw InputError(file, "", "is not JSON: " + (at == std::string::npos ? text : text.substr(at)));
  } catch (const Json::out_of_range&) {
    throw InputError(file, "", "has a number that is too large");
  }
}

/// One object of the file. Names in messages are those of a path, such as metric.hgrad.
class Section {
 public:
  Section(const std::string& file, const Json& json, std::string prefix)
      : file_(file), json_(json), prefix_(std::move(prefix)) {
    if (!json.is_object()) fail("", "must be an object: {...}");
  }

  [[noreturn]] void fail(const std::string& key, const std::string& reason) const {
    const std::string name =
        key.empty() && !prefix_.empty() ? prefix_.substr(0, prefix_.size() - 1) : prefix_ + key;
    throw InputError(file_, name, reason);
  }

  const Json* find(const std::string& key) {
    known_.push_back(key);
    const auto at = json_.find(key);
    return at == json_.end() ? nullptr : &*at;
  }
  const Json& need(const std::string& key) {
    const Json* value = find(key);
    if (!value) fail(key, "is missing");
    return *value;
  }

  void text(const std::string& key, std::string& value) {
    if (const Json* json = find(key)) value = text_of(key, *json);
  }
  std::string text_of(const std::string& key, const Json& json) const {
    if (!json.is_string() || json.get<std::string>().empty()) fail(key, "must be a string that is not empty");
    return json.get<std::string>();
  }

  void number(const std::string& key, double least, double& value) {
    if (const Json* json = find(key)) value = number_of(key, *json, least);
  }
  /// A finite number of at least `least`; 0 means above zero.
  double number_of(const std::string& key, const Json& json, double least) const {
    const double x = json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(std::isfinite(x) && x >= least && x > 0))
      fail(key,
           least > 0 ? fmt::format("must be a number from {} up", least) : "must be a number above zero");
    return x;
  }
  int count_of(const std::string& key, const Json& json, int most) const {
    const double x = number_of(key, json, 1);
    if (x != std::floor(x) || x > most) fail(key, fmt::format("must be a whole number from 1 to {}", most));
    return static_cast<int>(x);
  }

  template <class Value>
  void choice(const std::string& key, const std::map<std::string, Value>& choices, Value& value) {
    const Json* json = find(key);
    if (!json) return;
    const auto at = json->is_string() ? choices.find(json->get<std::string>()) : choices.end();
    if (at != choices.end()) {
      value = at->second;
      return;
    }
    std::string names;
    for (const auto& [name, unused] : choices) names += (names.empty() ? "" : " or ") + name;
    fail(key, "must be " + names);
  }

  bool knows(const std::string& key) const { return std::ranges::find(known_, key) != known_.end(); }

  /// To be called when all keys have been asked for.
  void refuse_unknown() const {
    for (const auto& [key, value] : json_.items()) {
      if (std::ranges::find(known_, key) != known_.end()) continue;
      const std::string closest = closest_word(key, known_);
      fail(key, closest.empty() ? "is unknown; known are " + fmt::format("{}", fmt::join(known_, ", "))
                                : "is unknown; did you mean " + closest + "?");
    }
  }

 private:
  const std::string& file_;
  const Json& json_;
  std::string prefix_;
  std::vector<std::string> known_;
};

/// Options of `weft adapt` that a loop sets itself, or says elsewhere.
constexpr std::array<std::string_view, 10> kOfLoop = {"sol",      "metric",     "metric-fn",  "complexity",
                                                      "transfer", "time-limit", "checkpoint", "resume",
                                                      "measure",  "ghosts"};
/// Those that change nothing of a result.
constexpr std::array<std::string_view, 6> kOfRun = {"threads",          "force", "max-memory",
                                                    "checkpoint-every", "check", "no-verify"};
constexpr std::array<std::string_view, 14> kOfMetric = {
    "norm",    "recovery",  "hmin",    "hmax", "aspect",      "hgrad",       "hgrad-space",
    "implied", "curvature", "sagitta", "wall", "wall-height", "wall-growth", "wall-size"};

bool is_among(const auto& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// Names of options that a section may have, as `weft adapt` has them.
std::vector<std::string> names_of(bool of_metric) {
  std::vector<std::string> names;
  for (const NamedOption& option : named_options())
    if (option.of_command && !is_among(kOfLoop, option.name) && is_among(kOfMetric, option.name) == of_metric)
      names.push_back(option.name);
  return names;
}

std::string as_key(std::string name) {
  std::ranges::replace(name, '-', '_');
  return name;
}

/// The text of a value, as set_option() takes it.
std::string option_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const Json& each : value) text += (text.empty() ? "" : ",") + option_text(each);
  return text;
}

/// Those that have no words of their own in the section.
void read_others(Section& section, bool of_metric, Options& options) {
  for (const std::string& name : names_of(of_metric)) {
    if (section.knows(as_key(name))) continue;
    const Json* value = section.find(as_key(name));
    if (!value) continue;
    try {
      set_option(options, name, option_text(*value));
    } catch (const OptionError& error) {
      section.fail(as_key(name), error.reason());
    }
  }
}

/// The options of a section that are not as they are by themselves, but those of a run alone.
Json changed_options(const Options& options, bool of_metric) {
  const Options plain;
  Json changed = Json::object();
  for (const std::string& name : names_of(of_metric))
    if (!is_among(kOfRun, name) && get_option(options, name) != get_option(plain, name))
      changed[as_key(name)] = get_option(options, name);
  return changed;
}

void read_norm(Section& section, double& norm) {
  const Json* json = section.find("norm");
  if (!json) return;
  norm = json->is_string() && json->get<std::string>() == "inf" ? std::numeric_limits<double>::infinity()
                                                                : section.number_of("norm", *json, 1);
}

void read_metric(const std::string& file, const Json& json, Options& options) {
  MetricOptions& metric = options.metric;
  static const std::map<std::string, HessianRecovery> recoveries = {
      {"lsq", HessianRecovery::least_squares}, {"l2", HessianRecovery::double_projection}};
  static const std::map<std::string, GradationSpace> spaces = {{"metric", GradationSpace::metric},
                                                               {"mixed", GradationSpace::mixed}};
  Section section(file, json, "metric.");
  read_norm(section, metric.norm);
  section.choice("recovery", recoveries, metric.recovery);
  section.number("hmin", 0, metric.hmin);
  section.number("hmax", 0, metric.hmax);
  section.number("aspect", 1, metric.aspect);
  section.number("hgrad", 1, metric.hgrad);
  section.choice("hgrad_space", spaces, metric.hgrad_space);
  read_others(section, true, options);
  section.refuse_unknown();
  if (metric.hmax > 0 && metric.hmin > metric.hmax) section.fail("hmin", "is larger than hmax");
}

void read_adapt(const std::string& file, const Json& json, LoopConfig& config) {
  Options& options = config.options;
  Section section(file, json, "adapt.");
  section.text("launcher", config.launcher);
  if (!config.launcher.empty()) options.run.threads = 1;  // of each rank
  if (const Json* threads = section.find("threads"))
    options.run.threads = section.count_of("threads", *threads, 1024);
  if (const Json* subdomains = section.find("subdomains"))
    options.distributed.subdomains =
        static_cast<std::uint32_t>(section.count_of("subdomains", *subdomains, 1 << 22));
  section.text("partitioner", options.distributed.partitioner);
  section.number("hausd", 0, options.geometry.hausd);
  section.number("ridge_angle", 0, options.geometry.ridge_angle);
  if (options.geometry.ridge_angle > 180) section.fail("ridge_angle", "must be at most 180");
  read_others(section, false, options);
  std::string& model = options.geometry.model;
  if (!model.empty() && model != "carried") model = (config.home / model).string();
  section.refuse_unknown();
}

/// Every complexity as often as "cycles" says.
void read_complexities(Section& section, std::vector<double>& complexities) {
  const Json& list = section.need("complexities");
  const Json* cycles = section.find("cycles");
  const int repeats = cycles ? section.count_of("cycles", *cycles, 1000) : 1;
  if (!list.is_array() || list.empty())
    section.fail("complexities", "must be a list of numbers: [1000, 2000]");
  for (std::size_t i = 0; i < list.size(); ++i)
    complexities.insert(complexities.end(), static_cast<std::size_t>(repeats),
                        section.number_of(fmt::format("complexities[{}]", i), list[i], 0));
}

void read_solver(Section& section, std::string& solver) {
  solver = section.text_of("solver", section.need("solver"));
  for (const char* placeholder : {"{mesh}", "{solution}"})
    if (solver.find(placeholder) == std::string::npos)
      section.fail("solver", std::string("does not say ") + placeholder);
}

void read_extensions(Section& section, LoopConfig& config) {
  section.text("mesh_extension", config.mesh_extension);
  const std::string mesh = "mesh" + config.mesh_extension;
  if (!config.mesh_extension.starts_with(".") || !is_mesh_name(mesh) || !holds_volumes(mesh))
    section.fail("mesh_extension", "must be one of " + volume_extensions());
  config.solution_extension = fs::path(fields_beside(mesh)).extension().string();
  section.text("solution_extension", config.solution_extension);
  if (!config.solution_extension.starts_with("."))
    section.fail("solution_extension", "must begin with a dot");
}

}  // namespace

LoopConfig read_loop_config(const std::string& file) {
  static const std::map<std::string, TransferMethod> methods = {
      {"linear", TransferMethod::linear}, {"conservative", TransferMethod::conservative}};
  const Json json = parse(file);
  LoopConfig config;
  config.file = file;
  config.home = fs::absolute(file).parent_path();
  config.options.run.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Section section(file, json, "");
  config.mesh = config.home / section.text_of("mesh", section.need("mesh"));
  read_solver(section, config.solver);
  read_complexities(section, config.complexities);
  std::string folder = fs::path(file).stem().string();
  section.text("folder", folder);
  config.folder = config.home / folder;
  read_extensions(section, config);
  if (const Json* metric = section.find("metric")) read_metric(file, *metric, config.options);
  if (const Json* adapt = section.find("adapt")) read_adapt(file, *adapt, config);
  section.choice("transfer", methods, config.options.transfer);
  section.refuse_unknown();
  try {
    validate(config.options);
  } catch (const OptionError& error) {
    section.fail("adapt", error.what());
  }
  if (!fs::is_regular_file(config.mesh)) section.fail("mesh", "there is no file " + config.mesh.string());
  return config;
}

Json LoopConfig::settings(std::size_t cycle) const {
  Json all = {{"solver", solver}, {"solution_extension", solution_extension}};
  if (cycle == 0) {
    all["mesh"] = mesh.filename().string();
    return all;
  }
  all["complexity"] = complexities[cycle - 1];
  all["mesh_extension"] = mesh_extension;
  all["metric"] = changed_options(options, true);
  all["adapt"] = changed_options(options, false);
  all["transfer"] = get_option(options, "transfer");
  return all;
}

}  // namespace weft::tools
