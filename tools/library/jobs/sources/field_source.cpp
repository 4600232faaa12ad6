#include "tools/library/jobs/sources/field_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "partition/communication/agreement.h"
#include "tools/common/inputs.h"
#include "tools/library/jobs/sources/shares.h"

namespace weft::tools {
namespace {

using meshing::Field;
using meshing::InputError;
using meshing::SolutionData;

/// What weft calls the metric of a result.
constexpr const char* kMetricName = "metric";

/// "mach" for the only field of mach.solb, "flow_2" for the second one of flow.solb.
void name_fields(const std::string& file, SolutionData& solution) {
  const std::string stem = std::filesystem::path(file).stem().string();
  for (std::size_t f = 0; f < solution.fields.size(); ++f)
    if (solution.fields[f].name.empty())
      solution.fields[f].name = solution.fields.size() == 1 ? stem : fmt::format("{}_{}", stem, f + 1);
}

std::string number_text(const VertexCount& count) {
  return count.least == count.most ? std::to_string(count.least)
                                   : fmt::format("{} to {}", count.least, count.most);
}

/// Checks and names.
void add_fields(const std::string& file, SolutionData&& solution, std::uint64_t first_vertex,
                SolutionData& all) {
  if (solution.fields.empty()) throw InputError(file, "", "has no fields");
  check_values(file, solution, first_vertex);
  name_fields(file, solution);
  std::ranges::move(solution.fields, std::back_inserter(all.fields));
}

}  // namespace

std::string of_another_mesh(const VertexCount& has, const std::string& mesh_file,
                            const VertexCount& vertices) {
  return fmt::format("belongs to another mesh: it has {} vertices, {} has {}", number_text(has), mesh_file,
                     number_text(vertices));
}

InputError not_finite(const std::string& file, std::size_t field, std::uint64_t vertex,
                      const std::string& piece) {
  return {file, fmt::format("{}field {}", piece, field),
          fmt::format("vertex {}: not a finite number", vertex + 1)};
}

void check_values(const std::string& file, const SolutionData& fields, std::uint64_t first_vertex,
                  const std::string& piece) {
  for (std::size_t f = 0; f < fields.fields.size(); ++f) {
    const Field& field = fields.fields[f];
    const auto bad = std::ranges::find_if(field.values, [](double x) { return !std::isfinite(x); });
    if (bad == field.values.end()) continue;
    const auto vertex = first_vertex + static_cast<std::uint64_t>(bad - field.values.begin()) /
                                           static_cast<std::uint64_t>(meshing::components(field.kind));
    throw not_finite(file, f + 1, vertex, piece);
  }
}

std::vector<std::string> left_fields_warnings(const Files& files, const Options& options, const Fields& own) {
  if (!files.fields.empty()) return {};
  bool has_metric = !options.metric.file.empty() && same_file(options.metric.file, files.input);
  std::vector<std::string> left;
  for (std::size_t f = 0; f < own.fields.size(); ++f) {
    const bool is_metric = has_metric && own.fields[f].kind != Field::Kind::vector;  // the first that can be
    if (is_metric) has_metric = false;
    const std::string name = meshing::field_name(own, f);
    if (!is_metric && name != kMetricName) left.push_back(printable(name));
  }
  if (left.empty()) return {};
  const bool one = left.size() == 1;
  return {fmt::format("field{} {} of {} {} left behind: --field {} carries {}", one ? "" : "s",
                      fmt::join(left, ", "), files.input, one ? "is" : "are", files.input,
                      one ? "it" : "them")};
}

SolutionData read_all_fields(const std::vector<std::string>& files, std::size_t num_points,
                             const std::string& mesh_file) {
  SolutionData all{num_points, {}};
  for (const std::string& file : files) {
    SolutionData solution = meshing::read_solution(file);
    if (solution.num_points != num_points)
      throw InputError(
          file, "",
          of_another_mesh({solution.num_points, solution.num_points}, mesh_file, {num_points, num_points}));
    add_fields(file, std::move(solution), 0, all);
  }
  return all;
}

SolutionData read_fields_of_slice(partition::Peers& peers, const std::vector<std::string>& files,
                                  const partition::MeshSlice& slice, const std::string& mesh_file) {
  SolutionData all{slice.points.size(), {}};
  for (const std::string& file : files) {
    SolutionData solution = read_fields_share(peers, file, slice, [&](std::uint64_t length) {
      return of_another_mesh({length, length}, mesh_file, {slice.num_points, slice.num_points});
    });
    partition::agree_on(peers, [&] { add_fields(file, std::move(solution), slice.first_point, all); });
  }
  return all;
}

}  // namespace weft::tools
