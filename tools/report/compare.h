// Two runs beside each other: what got slower, and what happened to the mesh.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace weft::report {

/// The same quantity of both runs.
struct ComparedSeconds {
  std::string name;
  double a = 0, b = 0;
};

/// A figure of both results; empty where a run has none.
struct ComparedMeasure {
  enum class Kind { count, share, number };
  std::string name;
  Kind kind = Kind::number;
  int better = 0;  ///< 1: more is better; -1: less is; 0: neither
  std::optional<double> a, b;
};

struct ComparedRun {
  std::string name;    ///< what the user calls it: its file
  std::string about;   ///< "4 ranks, 8 workers, 128 subdomains"
  double seconds = 0;  ///< of the adaptation; of its loop alone where one of both was simulated
};

struct Comparison {
  ComparedRun a, b;
  std::vector<ComparedSeconds> operations;  ///< of all workers; empty where a run has no profile
  std::vector<ComparedSeconds> ranks;       ///< of the ranks that both have, their workers' time but for idle
  std::vector<ComparedSeconds> steps;       ///< of the command; empty where one was simulated
  std::vector<ComparedMeasure> measures;
  std::vector<std::string> remarks;  ///< what makes the runs hard to compare

  /// One sentence.
  std::string verdict() const;
};

/// Documents of schema "weft-profile-1" or "weft-report-1". Throws std::invalid_argument, naming the run, for
/// others.
Comparison compare(const std::string& name_a, const nlohmann::ordered_json& a, const std::string& name_b,
                   const nlohmann::ordered_json& b);

/// For terminals.
std::string comparison_text(const Comparison& comparison);

/// For comparison_page() (report_page.h).
nlohmann::ordered_json comparison_json(const Comparison& comparison);

}  // namespace weft::report
