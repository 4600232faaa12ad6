// Figures of other mesh adapters on the cases that they have in common with weft.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace weft::report {

/// One run of a program. What was not published is empty.
struct PublishedRun {
  std::string_view program;
  int cores = 1;
  std::optional<double> seconds, quality_mean, quality_q01, quality_min, unit_edges;  ///< shares 0 to 1
  std::string_view source;
};

/// A histogram that a program's authors have published.
struct PublishedCurve {
  std::string program;
  int cores = 1;
  std::string measure;            ///< "mean_ratio" or "edge_length"
  std::vector<double> edges;      ///< of the bins, ascending: one more than there are densities
  std::vector<double> densities;  ///< share of all values in a bin, for each unit of the bin's width
};

/// The names of the cases that there are figures for: "cube-polar2-50000", "cube-polar2-500000",
/// "delta-wing-500000".
std::vector<std::string_view> published_cases();

/// The runs on a case; none for a name that is not known.
std::span<const PublishedRun> published_runs(std::string_view case_name);

/// The histograms on a case, from published_curves.csv; none for a name that is not known.
std::vector<PublishedCurve> published_curves(std::string_view case_name);

}  // namespace weft::report
