#include "tools/report/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/json/json.h"

namespace weft::report {
namespace {

using Json = nlohmann::ordered_json;

/// Runs differ by this much without a reason.
constexpr double kNoise = 0.02;

/// The parts of a document, whichever schema it has.
struct Document {
  std::string name;
  const Json& json;

  bool is_profile() const { return json.at("schema") == "weft-profile-1"; }
  const Json& report() const { return is_profile() ? json.at("report") : json; }
  /// The run's account of all workers; null where it has none.
  const Json& total() const {
    static const Json none;
    return is_profile() ? json.at("total") : none;
  }
  /// What a replay says of itself; null: the run was real.
  const Json& simulation() const {
    static const Json none;
    return is_profile() && json.contains("simulation") ? json.at("simulation") : none;
  }
  bool is_simulated() const { return !simulation().is_null(); }
  /// From the first task's begin to the last one's end: what a replay knows the time of. Empty where no graph
  /// was recorded.
  std::optional<double> loop_seconds() const {
    if (!is_profile() || !json.contains("critical_path") || json.at("critical_path").is_null()) return {};
    return json.at("critical_path").at("wall").get<double>();
  }
};

std::string lacks(const std::string& name, const std::string& member) {
  return name + " has no \"" + member + "\": it is damaged, or of another version of weft";
}

Document document(const std::string& name, const Json& json) {
  const std::string schema = engine::schema_of(json);
  if (schema != "weft-profile-1" && schema != "weft-report-1")
    throw std::invalid_argument(name + " is neither a profile (weft-profile-1) nor a report (weft-report-1)");
  if (schema == "weft-profile-1")
    for (const char* member : {"report", "total", "ranks"})
      if (!json.contains(member)) throw std::invalid_argument(lacks(name, member));
  return {name, json};
}

std::string plural(std::uint64_t n, const char* word) {
  return fmt::format("{} {}{}", n, word, n == 1 ? "" : "s");
}

ComparedRun about(const Document& run, bool of_loops) {
  const Json& report = run.report();
  ComparedRun result{run.name, "",
                     of_loops ? *run.loop_seconds() : report.at("seconds").at("adapt").get<double>()};
  if (!run.total().is_null()) {
    result.about = plural(run.json.at("ranks").size(), "rank") + ", " +
                   plural(run.total().at("workers").get<std::uint64_t>(), "worker");
  } else {
    result.about = plural(report.at("threads").get<std::uint64_t>(), "thread");
  }
  if (report.contains("subdomains") && report.at("subdomains").is_object())
    result.about += ", " + plural(report.at("subdomains").at("subdomains").get<std::uint64_t>(), "subdomain");
  if (run.is_simulated())
    result.about += ", " + plural(run.simulation().at("subdomains").get<std::uint64_t>(), "subdomain") +
                    ", simulated: a replay of " + run.simulation().at("graph").get<std::string>();
  return result;
}

/// Members of two objects of numbers by name: those of A, then those that only B has.
std::vector<ComparedSeconds> by_name(const Json& a, const Json& b) {
  std::vector<ComparedSeconds> rows;
  for (const auto& [name, value] : a.items()) rows.push_back({name, value.get<double>(), b.value(name, 0.0)});
  for (const auto& [name, value] : b.items())
    if (!a.contains(name)) rows.push_back({name, 0, value.get<double>()});
  return rows;
}

double busy_seconds(const Json& rank) {
  double sum = 0;
  for (const auto& [name, value] : rank.at("seconds").items())
    if (name != "idle") sum += value.get<double>();
  return sum;
}

std::vector<ComparedSeconds> by_rank(const Json& a, const Json& b) {
  std::vector<ComparedSeconds> rows;
  for (std::size_t r = 0; r < std::min(a.size(), b.size()); ++r)
    rows.push_back({"rank " + std::to_string(r), busy_seconds(a[r]), busy_seconds(b[r])});
  return rows;
}

/// A number of a report by its path; empty where it is missing or null.
std::optional<double> number_at(const Json& report, const char* path) {
  const Json::json_pointer pointer(path);
  if (!report.contains(pointer) || !report.at(pointer).is_number()) return std::nullopt;
  return report.at(pointer).get<double>();
}

std::vector<ComparedMeasure> measures_of(const Json& a, const Json& b) {
  using Kind = ComparedMeasure::Kind;
  struct Row {
    const char *name, *path;
    Kind kind;
    int better;
  };
  static constexpr Row kRows[] = {
      {"tets", "/after/tets", Kind::count, 0},
      {"vertices", "/after/vertices", Kind::count, 0},
      {"quality, mean", "/after/quality/mean", Kind::number, 1},
      {"quality, 1 %", "/after/quality/quantile_0.01", Kind::number, 1},
      {"quality, 0.1 %", "/after/quality/quantile_0.001", Kind::number, 1},
      {"quality, worst", "/after/quality/min", Kind::number, 1},
      {"edges unit", "/after/edge_length/share_unit", Kind::share, 1},
      {"edges long", "/after/edge_length/share_long", Kind::share, -1},
      {"edges short", "/after/edge_length/share_short", Kind::share, -1},
      {"former interface, quality mean", "/subdomains/former_interface/quality/mean", Kind::number, 1},
      {"former interface, quality 1 %", "/subdomains/former_interface/quality/quantile_0.01", Kind::number,
       1},
      {"peak memory, bytes", "/peak_memory_bytes", Kind::count, -1}};
  std::vector<ComparedMeasure> rows;
  for (const Row& row : kRows) {
    ComparedMeasure measure{row.name, row.kind, row.better, number_at(a, row.path), number_at(b, row.path)};
    if (measure.a || measure.b) rows.push_back(std::move(measure));
  }
  return rows;
}

std::vector<std::string> remarks_on(const Document& a, const Document& b) {
  std::vector<std::string> remarks;
  if (a.is_simulated() || b.is_simulated()) {
    remarks.push_back(
        std::string(a.is_simulated() && b.is_simulated() ? "Both runs are"
                    : a.is_simulated()                   ? "A is"
                                                         : "B is") +
        " simulated. Times are those of the adaptation's loop, from the first task to the last.");
    return remarks;
  }
  const auto tets = [](const Document& d) { return d.report().at("output").at("tets").get<double>(); };
  if (std::abs(tets(b) - tets(a)) > kNoise * std::max(tets(a), tets(b)))
    remarks.push_back(
        fmt::format("The results are of different sizes: {:.0f} and {:.0f} tets.", tets(a), tets(b)));
  if (a.report().at("input") != b.report().at("input")) remarks.push_back("The inputs are different meshes.");
  for (const Document* run : {&a, &b})
    if (!run->report().at("goal_met").get<bool>()) remarks.push_back(run->name + " did not meet its goal.");
  return remarks;
}

std::string seconds_text(double seconds) {
  return std::abs(seconds) < 0.1 && seconds != 0 ? fmt::format("{:.3g} ms", 1e3 * seconds)
                                                 : fmt::format("{:.3g} s", seconds);
}

std::string signed_text(double seconds) {
  return fmt::format("{}{}", seconds > 0 ? "+" : "", seconds_text(seconds));
}

std::string change_text(double a, double b) {
  if (!(a > 0)) return "-";
  return b < 100 * a ? fmt::format("{:+.1f} %", 100 * (b / a - 1)) : fmt::format("x {:.3g}", b / a);
}

std::string seconds_table(const std::string& title, std::vector<ComparedSeconds> rows) {
  if (rows.empty()) return "";
  std::stable_sort(rows.begin(), rows.end(), [](const ComparedSeconds& x, const ComparedSeconds& y) {
    return std::abs(x.b - x.a) > std::abs(y.b - y.a);
  });
  std::string text = fmt::format("\n{:<32}{:>12}{:>12}{:>14}{:>12}\n", title, "A", "B", "difference", "");
  for (const ComparedSeconds& row : rows) {
    text += fmt::format("  {:<30}{:>12}{:>12}{:>14}{:>12}\n", row.name, seconds_text(row.a),
                        seconds_text(row.b), signed_text(row.b - row.a), change_text(row.a, row.b));
  }
  return text;
}

std::string measure_text(const ComparedMeasure& measure, const std::optional<double>& value) {
  if (!value) return "-";
  switch (measure.kind) {
    case ComparedMeasure::Kind::count:
      return fmt::format("{:.0f}", *value);
    case ComparedMeasure::Kind::share:
      return fmt::format("{:.2f} %", 100 * *value);
    case ComparedMeasure::Kind::number:
      return fmt::format("{:.4g}", *value);
  }
  return "";
}

std::string judgement(const ComparedMeasure& measure) {
  if (measure.better == 0 || !measure.a || !measure.b || *measure.a == *measure.b) return "";
  return (*measure.b - *measure.a) * measure.better > 0 ? "better" : "worse";
}

Json json_of(const ComparedRun& run) {
  return {{"name", run.name}, {"about", run.about}, {"seconds", run.seconds}};
}

Json json_of(const std::vector<ComparedSeconds>& rows) {
  Json list = Json::array();
  for (const ComparedSeconds& row : rows) list.push_back({{"name", row.name}, {"a", row.a}, {"b", row.b}});
  return list;
}

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

}  // namespace

std::string Comparison::verdict() const {
  const double change = a.seconds > 0 ? b.seconds / a.seconds - 1 : 0;
  if (std::abs(change) < kNoise)
    return fmt::format("B is as fast as A: {} and {}.", seconds_text(b.seconds), seconds_text(a.seconds));
  std::string text =
      fmt::format("B is {:.0f} % {} than A: {} instead of {}", 100 * std::abs(change),
                  change > 0 ? "slower" : "faster", seconds_text(b.seconds), seconds_text(a.seconds));
  const auto most = std::max_element(operations.begin(), operations.end(), [&](const auto& x, const auto& y) {
    return (x.b - x.a) * change < (y.b - y.a) * change;
  });
  if (most != operations.end() && (most->b - most->a) * change > 0) text += "; most of it is " + most->name;
  return text + ".";
}

Comparison compare(const std::string& name_a, const Json& a, const std::string& name_b, const Json& b) {
  const Document first = document(name_a, a), second = document(name_b, b);
  Comparison result;
  const bool simulated = first.is_simulated() || second.is_simulated();
  if (simulated)
    for (const Document* run : {&first, &second})
      if (!run->loop_seconds())
        throw std::invalid_argument(run->name +
                                    " has no task graph: only such runs compare with a simulated one");
  result.a = about(first, simulated);
  result.b = about(second, simulated);
  if (!first.total().is_null() && !second.total().is_null()) {
    result.operations = by_name(first.total().at("seconds"), second.total().at("seconds"));
    result.ranks = by_rank(a.at("ranks"), b.at("ranks"));
    if (a.at("ranks").size() != b.at("ranks").size())
      result.remarks.push_back("The runs had different numbers of ranks.");
  }
  if (!simulated) result.steps = by_name(first.report().at("seconds"), second.report().at("seconds"));
  result.measures = measures_of(first.report(), second.report());
  const std::vector<std::string> remarks = remarks_on(first, second);
  result.remarks.insert(result.remarks.end(), remarks.begin(), remarks.end());
  return result;
}

std::string comparison_text(const Comparison& comparison) {
  std::string text = comparison.verdict() + "\n";
  for (const std::string& remark : comparison.remarks) text += remark + "\n";
  text += fmt::format("  A: {} ({})\n  B: {} ({})\n", comparison.a.name, comparison.a.about,
                      comparison.b.name, comparison.b.about);
  text += seconds_table("by operation", comparison.operations) + seconds_table("by step", comparison.steps) +
          seconds_table("by rank, without idle", comparison.ranks);
  if (!comparison.measures.empty()) text += fmt::format("\n{:<32}{:>14}{:>14}\n", "mesh", "A", "B");
  for (const ComparedMeasure& measure : comparison.measures) {
    text += fmt::format("  {:<30}{:>14}{:>14}  {}\n", measure.name, measure_text(measure, measure.a),
                        measure_text(measure, measure.b), judgement(measure));
  }
  return text;
}

Json comparison_json(const Comparison& comparison) {
  Json measures = Json::array();
  for (const ComparedMeasure& m : comparison.measures) {
    const char* kind = m.kind == ComparedMeasure::Kind::count   ? "count"
                       : m.kind == ComparedMeasure::Kind::share ? "share"
                                                                : "number";
    measures.push_back(
        {{"name", m.name}, {"kind", kind}, {"better", m.better}, {"a", json_of(m.a)}, {"b", json_of(m.b)}});
  }
  return {{"a", json_of(comparison.a)},
          {"b", json_of(comparison.b)},
          {"verdict", comparison.verdict()},
          {"remarks", comparison.remarks},
          {"operations", json_of(comparison.operations)},
          {"ranks", json_of(comparison.ranks)},
          {"steps", json_of(comparison.steps)},
          {"measures", measures}};
}

}  // namespace weft::report
