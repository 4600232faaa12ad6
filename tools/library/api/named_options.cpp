// Options by their names: one table, for all languages but C++ and the command line.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "tools/common/numbers.h"
#include "weft/weft.h"

namespace weft {
namespace {

using Setter = std::function<void(Options&, const std::string& option, const std::string& text)>;
using Getter = std::function<std::string(const Options&)>;

struct Row {
  /// No aggregate: GCC 12 destroys the strings of one within another twice where an allocation of a later
  /// member fails.
  Row(NamedOption its_option, Setter its_set, Getter its_get)
      : option(std::move(its_option)), set(std::move(its_set)), get(std::move(its_get)) {}

  NamedOption option;
  Setter set;
  Getter get;
};

double number_of(const std::string& option, const std::string& text) {
  const std::optional<double> value = tools::parse_number(text);
  if (!value) throw OptionError(option, fmt::format("'{}' is not a number", text));
  return *value;
}

double size_of(const std::string& option, const std::string& text) {
  const std::optional<double> bytes = tools::parse_size(text);
  if (!bytes) throw OptionError(option, fmt::format("'{}' is not a size, such as 8G", text));
  return *bytes;
}

template <class Whole>
Whole whole_number_of(const std::string& option, const std::string& text) {
  const double value = number_of(option, text);
  constexpr auto kLeast = static_cast<double>(std::numeric_limits<Whole>::min());
  constexpr auto kMost = static_cast<double>(std::numeric_limits<Whole>::max());
  if (!(value >= kLeast && value <= kMost) || value != std::floor(value))
    throw OptionError(option, fmt::format("'{}' is not a whole number that it may be", text));
  return static_cast<Whole>(value);
}

bool yes_or_no(const std::string& option, const std::string& text) {
  for (const std::string_view yes : {"yes", "true", "1"})
    if (text == yes) return true;
  for (const std::string_view no : {"no", "false", "0"})
    if (text == no) return false;
  throw OptionError(option, fmt::format("'{}' is neither yes nor no", text));
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  for (std::size_t from = 0; from <= text.size() && !text.empty();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    words.push_back(text.substr(from, comma - from));
    from = comma + 1;
  }
  return words;
}

// Rows of each type. `place` gives the member that the option sets.

/// Of numbers and texts; `text_of` is their text.
template <class Place, class Text>
Getter getter(Place place, Text text_of) {
  // Nothing is changed: places serve setters too. A copy would have all solutions in memory.
  return [place, text_of](const Options& options) { return text_of(place(const_cast<Options&>(options))); };
}

std::string yes_text(bool value) { return value ? "yes" : "no"; }
std::string no_text(bool value) { return yes_text(!value); }

template <class Values>
std::string joined(const Values& values) {
  return fmt::format("{}", fmt::join(values, ","));
}

template <class Value>
std::string text_or_auto(const std::optional<Value>& value) {
  return value ? fmt::format("{}", *value) : "auto";
}

template <class Place>
Row number(const char* name, const char* text, Place place, bool of_command = true) {
  return {{name, "number", text, of_command},
          [place](Options& options, const std::string& option, const std::string& value) {
            place(options) = number_of(option, value);
          },
          getter(place, [](double value) { return fmt::format("{}", value); })};
}

template <class Place>
Row whole_number(const char* name, const char* text, Place place) {
  return {{name, "whole number", text, true},
          [place](Options& options, const std::string& option, const std::string& value) {
            auto& member = place(options);
            member = whole_number_of<std::remove_reference_t<decltype(member)>>(option, value);
          },
          getter(place, [](auto value) { return fmt::format("{}", value); })};
}

template <class Place>
Row flag(const char* name, const char* text, Place place, bool of_command = true) {
  return {{name, "yes or no", text, of_command},
          [place](Options& options, const std::string& option, const std::string& value) {
            place(options) = yes_or_no(option, value);
          },
          getter(place, yes_text)};
}

template <class Place>
Row word(const char* name, const char* text, Place place) {
  return {{name, "text", text, true},
          [place](Options& options, const std::string&, const std::string& value) { place(options) = value; },
          getter(place, [](const std::string& value) { return value; })};
}

/// One of several words, each of which means a value.
template <class Place, class Value, std::size_t N>
Row choice(const char* name, const char* text, Place place,
           const std::array<std::pair<const char*, Value>, N>& values) {
  std::string words;
  for (const auto& [known, value] : values) words += (words.empty() ? "" : ", ") + std::string(known);
  return {{name, words, text, true},
          [place, values, words](Options& options, const std::string& option, const std::string& given) {
            for (const auto& [known, value] : values)
              if (given == known) {
                place(options) = value;
                return;
              }
            throw OptionError(option, fmt::format("'{}' is none of {}", given, words));
          },
          getter(place, [values](Value value) {
            const auto same = [value](const auto& known) { return known.second == value; };
            const auto found = std::ranges::find_if(values, same);
            return found == values.end() ? "none of its values" : std::string(found->first);
          })};
}

template <class Value>
using Words = std::array<std::pair<const char*, Value>, 2>;

void add_metric(std::vector<Row>& rows) {
  rows.push_back(word(
      "metric", "file of a metric", [](Options & o) -> auto& { return o.metric.file; }));
  rows.push_back(word(
      "metric-fn", "analytic metric: polar-1, polar-2, linear, uniform:H",
      [](Options & o) -> auto& { return o.metric.function; }));
  rows.push_back(
      {{"sol", "texts", "file of a solution to resolve; adds to those before", true},
       [](Options& o, const std::string&, const std::string& file) { o.metric.sol.push_back(file); },
       [](const Options& o) { return joined(o.metric.sol); }});
  rows.push_back(number(
      "norm", "p of the Lp norm of the interpolation error, 1 to inf",
      [](Options & o) -> auto& { return o.metric.norm; }));
  rows.push_back(choice(
      "recovery", "how second derivatives are recovered",
      [](Options & o) -> auto& { return o.metric.recovery; },
      Words<HessianRecovery>{
          {{"lsq", HessianRecovery::least_squares}, {"l2", HessianRecovery::double_projection}}}));
  rows.push_back(flag(
      "implied", "the metric in which the input mesh is unit",
      [](Options & o) -> auto& { return o.metric.implied; }));
  rows.push_back(number(
      "complexity", "scale the metric to this complexity",
      [](Options & o) -> auto& { return o.metric.complexity; }));
  rows.push_back(number(
      "hmin", "smallest size", [](Options & o) -> auto& { return o.metric.hmin; }));
  rows.push_back(number(
      "hmax", "largest size", [](Options & o) -> auto& { return o.metric.hmax; }));
  rows.push_back(number(
      "aspect", "largest ratio of sizes at a vertex", [](Options & o) -> auto& { return o.metric.aspect; }));
  rows.push_back(number(
      "hgrad", "largest growth of sizes per unit edge; values <= 1: none",
      [](Options & o) -> auto& { return o.metric.hgrad; }));
  rows.push_back(choice(
      "hgrad-space", "the space in which sizes grow",
      [](Options & o) -> auto& { return o.metric.hgrad_space; },
      Words<GradationSpace>{{{"metric", GradationSpace::metric}, {"mixed", GradationSpace::mixed}}}));
}

/// An option whose name begins with "no-".
template <class Place>
Row ban(const char* name, const char* text, Place place) {
  return {{name, "yes or no", text, true},
          [place](Options& options, const std::string& option, const std::string& value) {
            place(options) = !yes_or_no(option, value);
          },
          getter(place, no_text)};
}

void add_boundary(std::vector<Row>& rows) {
  rows.push_back(number(
      "curvature", "edges per full turn of curvature of the boundary",
      [](Options & o) -> auto& { return o.metric.curvature; }));
  rows.push_back(number(
      "sagitta", "largest distance from an edge's middle to the boundary",
      [](Options & o) -> auto& { return o.metric.sagitta; }));
  rows.push_back({{"wall", "whole numbers", "references of walls with thin layers", true},
                  [](Options& o, const std::string& option, const std::string& text) {
                    o.metric.wall.refs.clear();
                    for (const std::string& ref : split(text))
                      o.metric.wall.refs.push_back(whole_number_of<std::int32_t>(option, ref));
                  },
                  [](const Options& o) { return joined(o.metric.wall.refs); }});
  rows.push_back(number(
      "wall-height", "size across the walls, of the first layer",
      [](Options & o) -> auto& { return o.metric.wall.height; }));
  rows.push_back(number(
      "wall-growth", "growth of successive layers, 1 and more",
      [](Options & o) -> auto& { return o.metric.wall.growth; }));
  rows.push_back(number(
      "wall-size", "size along the walls; 0: any",
      [](Options & o) -> auto& { return o.metric.wall.tangential; }));
  rows.push_back(number(
      "ridge-angle", "boundary edges sharper than this are kept; degrees",
      [](Options & o) -> auto& { return o.geometry.ridge_angle; }));
  rows.push_back(number(
      "hausd", "largest distance to the surface; 0: 0.1 % of the diagonal",
      [](Options & o) -> auto& { return o.geometry.hausd; }));
  rows.push_back(ban(
      "no-surface-limit", "do not make the metric as fine as hausd needs on curved boundary",
      [](Options & o) -> auto& { return o.geometry.limit_metric; }));
  rows.push_back(word(
      "geometry", "file of a CAD model that the boundary lies on, or carried: that of the mesh file",
      [](Options & o) -> auto& { return o.geometry.model; }));
  rows.push_back(number(
      "geometry-scale", "the model's lengths are multiplied by this",
      [](Options & o) -> auto& { return o.geometry.model_scale; }));
}

void add_operations(std::vector<Row>& rows) {
  rows.push_back(ban(
      "no-insert", "neither split nor collapse edges",
      [](Options & o) -> auto& { return o.allowed.insert; }));
  rows.push_back(ban(
      "no-swap", "swap no edges and faces", [](Options & o) -> auto& { return o.allowed.swap; }));
  rows.push_back(ban(
      "no-move", "move no vertices", [](Options & o) -> auto& { return o.allowed.move; }));
}

void add_run(std::vector<Row>& rows) {
  rows.push_back(choice(
      "transfer", "how fields are carried along", [](Options & o) -> auto& { return o.transfer; },
      Words<TransferMethod>{
          {{"linear", TransferMethod::linear}, {"conservative", TransferMethod::conservative}}}));
  rows.push_back(whole_number(
      "threads", "of this process or rank; 0: all cores, on several ranks one",
      [](Options & o) -> auto& { return o.run.threads; }));
  rows.push_back(flag(
      "force", "run even if the memory seems insufficient, or the mesh fits already",
      [](Options & o) -> auto& { return o.run.force; }));
  rows.push_back(flag(
      "repair", "mend an input that would be refused", [](Options & o) -> auto& { return o.run.repair; }));
  rows.push_back(number(
      "time-limit", "seconds after which the run has ended with the valid mesh that there is; 0: none",
      [](Options & o) -> auto& { return o.run.time_limit; }));
  rows.push_back(
      {{"max-memory", "size", "bytes that this process or rank may take, such as 8G; 0: what is free", true},
       [](Options& o, const std::string& option, const std::string& text) {
         o.run.max_memory = size_of(option, text);
       },
       [](const Options& o) { return fmt::format("{}", o.run.max_memory); }});
  rows.push_back(word(
      "checkpoint", "folder for states to go on from",
      [](Options & o) -> auto& { return o.checkpoint.folder; }));
  rows.push_back(number(
      "checkpoint-every",
      "seconds between checkpoints, the first after 10, 20, 40 ...; 0: only when asked for",
      [](Options & o) -> auto& { return o.checkpoint.every; }));
  rows.push_back(word(
      "resume", "folder of checkpoints to go on from",
      [](Options & o) -> auto& { return o.checkpoint.resume; }));
  rows.push_back(flag(
      "check", "check all subdomains after every round; slow",
      [](Options & o) -> auto& { return o.run.check; }));
  rows.push_back(ban(
      "no-verify", "give the result away without checking that it conforms",
      [](Options & o) -> auto& { return o.run.verify; }));
  rows.push_back(flag(
      "measure", "measure the result before it is returned, not when measures are asked for",
      [](Options & o) -> auto& { return o.run.measure; }, false));
}

void add_subdomains(std::vector<Row>& rows) {
  using Distributed = DistributedOptions;
  rows.push_back(whole_number(
      "subdomains", "number of subdomains; 0: one mesh, on several ranks 4 a thread",
      [](Options & o) -> auto& { return o.distributed.subdomains; }));
  rows.push_back(word(
      "partitioner", "graph, bisection or pqr:PxQxR[:harmonic=A,B|:wall=A,...][:principal][:fewer]",
      [](Options & o) -> auto& { return o.distributed.partitioner; }));
  rows.push_back(choice(
      "equal", "what subdomains have equally of", [](Options & o) -> auto& { return o.distributed.equal; },
      Words<Distributed::Equal>{{{"work", Distributed::Equal::work}, {"tets", Distributed::Equal::tets}}}));
  rows.push_back({{"layers", "whole number, or auto", "layers of tets that migrate in every shift", true},
                  [](Options& o, const std::string& option, const std::string& text) {
                    o.distributed.layers.reset();
                    if (text != "auto") o.distributed.layers = whole_number_of<int>(option, text);
                  },
                  [](const Options& o) { return text_or_auto(o.distributed.layers); }});
  rows.push_back(choice(
      "layers-by", "what layers grow across", [](Options & o) -> auto& { return o.distributed.layers_by; },
      Words<Distributed::LayersBy>{
          {{"points", Distributed::LayersBy::points}, {"faces", Distributed::LayersBy::faces}}}));
  rows.push_back({{"shifts", "whole number, or auto", "shifts at most", true},
                  [](Options& o, const std::string& option, const std::string& text) {
                    o.distributed.shifts.reset();
                    if (text != "auto") o.distributed.shifts = whole_number_of<std::uint32_t>(option, text);
                  },
                  [](const Options& o) { return text_or_auto(o.distributed.shifts); }});
  rows.push_back(word(
      "balancer", "stealing, diffusion or none",
      [](Options & o) -> auto& { return o.distributed.balancer; }));
  rows.push_back(choice(
      "freeze", "what is frozen at an interface", [](Options & o) -> auto& { return o.distributed.freeze; },
      Words<Distributed::Freeze>{
          {{"vertices", Distributed::Freeze::vertices}, {"tets", Distributed::Freeze::tets}}}));
  rows.push_back(ban(
      "no-interface-refinement", "leave the interface as it is at first",
      [](Options & o) -> auto& { return o.distributed.interface_refinement; }));
  rows.push_back(flag(
      "ghosts", "results in parts get a layer of ghost tets",
      [](Options & o) -> auto& { return o.distributed.ghosts; }, false));
}

const std::vector<Row>& table() {
  static const std::vector<Row> rows = [] {
    std::vector<Row> all;
    add_metric(all);
    add_boundary(all);
    add_operations(all);
    add_run(all);
    add_subdomains(all);
    return all;
  }();
  return rows;
}

}  // namespace

const std::vector<NamedOption>& named_options() {
  static const std::vector<NamedOption> names = [] {
    std::vector<NamedOption> all;
    for (const Row& row : table()) all.push_back(row.option);
    return all;
  }();
  return names;
}

namespace {

const Row& row_of(const std::string& name) {
  std::string known = name;
  for (char& c : known)
    if (c == '_') c = '-';
  for (const Row& row : table())
    if (row.option.name == known) return row;
  throw OptionError("--" + printable(known), "is not an option; they are those of weft adapt --help");
}

}  // namespace

void set_option(Options& options, const std::string& name, const std::string& text) {
  const Row& row = row_of(name);
  row.set(options, "--" + row.option.name, text);
}

std::string get_option(const Options& options, const std::string& name) { return row_of(name).get(options); }

}  // namespace weft
