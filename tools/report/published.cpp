#include "tools/report/published.h"

#include <array>
#include <locale>
#include <sstream>
#include <utility>

#include "tools/report/assets.h"

namespace weft::report {
namespace {

constexpr std::string_view kUgawg =
    "Unstructured Grid Adaptation Working Group, parallel-adapt-results (Xeon 6148); minima are bin edges";
constexpr std::string_view kUgawgFeflo =
    "Unstructured Grid Adaptation Working Group, parallel-adapt-results; minima are bin edges";
constexpr std::string_view kBeside =
    "measured by weft's authors on a 2-core virtual machine, same start mesh";

constexpr std::nullopt_t kUnknown = std::nullopt;

constexpr PublishedRun kCube50[] = {
    {"Mmg 5.8.0", 1, 22.0, 0.851, 0.662, 0.371, 0.953, kBeside},
    {"refine 2022-11", 1, 153.7, 0.872, 0.570, 0.243, 0.978, kBeside},
    {"refine 2022-11, MPI", 2, 112.8, 0.866, 0.566, 0.292, 0.972, kBeside},
    {"ParMmg 1.5.0", 2, 51.6, 0.437, 0.025, 0.0005, 0.482, kBeside},
};
constexpr PublishedRun kCube500[] = {
    {"CDT3D", 1, 1384, 0.770, 0.489, 0.099, 0.795, kUgawg},
    {"CDT3D", 2, 571, 0.770, 0.489, 0.099, 0.795, kUgawg},
    {"CDT3D", 40, 58, 0.770, 0.489, 0.099, 0.795, kUgawg},
    {"refine", 1, 6412, 0.797, 0.474, 0.099, 0.875, kUgawg},
    {"refine", 40, 249, 0.808, 0.474, 0.099, 0.896, kUgawg},
    {"Mmg 5.8.0", 1, 202, 0.855, 0.671, 0.355, 0.963, kBeside},
    {"ParMmg 1.5.0", 2, 753, 0.470, 0.021, 0.0007, 0.511, kBeside},
};
constexpr PublishedRun kDelta500[] = {
    {"CDT3D", 1, 1024, 0.743, 0.460, 0.094, 0.740, kUgawg},
    {"CDT3D", 2, 433, 0.743, 0.460, 0.094, 0.740, kUgawg},
    {"CDT3D", 40, 44, 0.743, 0.460, 0.094, 0.740, kUgawg},
    {"feflo.a", 1, 68.6, 0.876, 0.665, 0.281, 0.987, kUgawgFeflo},
    {"feflo.a", 16, kUnknown, 0.795, 0.299, 0.011, 0.957, kUgawgFeflo},
    {"Mmg 5.8.0", 1, 169, 0.809, 0.353, 0.033, 0.893, kBeside},
};

constexpr std::array<std::pair<std::string_view, std::span<const PublishedRun>>, 3> kCases = {
    {{"cube-polar2-50000", kCube50}, {"cube-polar2-500000", kCube500}, {"delta-wing-500000", kDelta500}}};

std::vector<double> numbers(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> all;
  for (double x; in >> x;) all.push_back(x);
  return all;
}

}  // namespace

std::vector<PublishedCurve> published_curves(std::string_view case_name) {
  std::istringstream file{std::string(asset("published_curves.csv"))};
  std::vector<PublishedCurve> curves;
  std::string line;
  for (int head = 0; head < 2; ++head) std::getline(file, line);  // the source, the names of the columns
  while (std::getline(file, line)) {
    std::istringstream row(line);
    std::array<std::string, 6> columns;
    for (std::string& column : columns) std::getline(row, column, ',');
    const auto& [name, program, cores, measure, edges, densities] = columns;
    if (name == case_name)
      curves.push_back({program, std::stoi(cores), measure, numbers(edges), numbers(densities)});
  }
  return curves;
}

std::vector<std::string_view> published_cases() {
  std::vector<std::string_view> names;
  for (const auto& [name, runs] : kCases) names.push_back(name);
  return names;
}

std::span<const PublishedRun> published_runs(std::string_view case_name) {
  for (const auto& [name, runs] : kCases)
    if (name == case_name) return runs;
  return {};
}

}  // namespace weft::report
