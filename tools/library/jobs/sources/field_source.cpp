#include "tools/library/jobs/sources/field_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"

namespace weft::tools {
namespace {

using meshing::Field;
using meshing::InputError;
using meshing::SolutionData;

void check_values(const std::string& file, const SolutionData& solution) {
  for (std::size_t f = 0; f < solution.fields.size(); ++f) {
    const Field& field = solution.fields[f];
    const auto bad = std::ranges::find_if(field.values, [](double x) { return !std::isfinite(x); });
    if (bad == field.values.end()) continue;
    const auto vertex = (bad - field.values.begin()) / meshing::components(field.kind);
    throw InputError(file, fmt::format("field {}", f + 1),
                     fmt::format("vertex {}: not a finite number", vertex + 1));
  }
}

/// "mach" for the only field of mach.solb, "flow_2" for the second one of flow.solb.
void name_fields(const std::string& file, SolutionData& solution) {
  const std::string stem = std::filesystem::path(file).stem().string();
  for (std::size_t f = 0; f < solution.fields.size(); ++f)
    if (solution.fields[f].name.empty())
      solution.fields[f].name = solution.fields.size() == 1 ? stem : fmt::format("{}_{}", stem, f + 1);
}

SolutionData read_one(const std::string& file, std::size_t num_points, const std::string& mesh_file) {
  SolutionData solution = meshing::read_solution(file);
  if (solution.num_points != num_points)
    throw InputError(file, "",
                     fmt::format("belongs to another mesh: it has {} vertices, {} has {}",
                                 solution.num_points, mesh_file, num_points));
  if (solution.fields.empty()) throw InputError(file, "", "has no fields");
  check_values(file, solution);
  name_fields(file, solution);
  return solution;
}

}  // namespace

SolutionData read_all_fields(const std::vector<std::string>& files, std::size_t num_points,
                             const std::string& mesh_file) {
  SolutionData all{num_points, {}};
  for (const std::string& file : files) {
    SolutionData solution = read_one(file, num_points, mesh_file);
    std::ranges::move(solution.fields, std::back_inserter(all.fields));
  }
  return all;
}

}  // namespace weft::tools
