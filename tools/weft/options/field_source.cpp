// Options and reading of fields; the account as text.
#include "tools/weft/options/field_source.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "tools/weft/terminal/text.h"

namespace weft::tools {
namespace {

using meshing::ComponentAccount;
using meshing::Field;
using meshing::InputError;
using meshing::SolutionData;
using meshing::TransferMethod;

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

std::string relative(double x, double scale) { return scale > 0 ? fmt::format("{:.2e}", x / scale) : "-"; }

}  // namespace

CLI::Option* add_field_options(CLI::App& command, FieldRequest& request, const std::string& owner,
                               const std::string& group) {
  static const std::map<std::string, TransferMethod> methods = {
      {"linear", TransferMethod::linear}, {"conservative", TransferMethod::conservative}};
  CLI::Option* fields = command
                            .add_option("--field", request.files,
                                        "fields at the vertices of " + owner + " to transfer; repeatable")
                            ->type_name("FILE")
                            ->expected(1)
                            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
                            ->group(group);
  command
      .add_option("--transfer", request.method,
                  "linear (default) or conservative (preserves integrals and definite tensors)")
      ->transform(CLI::CheckedTransformer(methods).description(""))
      ->type_name("HOW")
      ->needs(fields)
      ->group(group);
  return fields;
}

SolutionData read_fields(const FieldRequest& request, std::size_t num_points, const std::string& mesh_file) {
  SolutionData all{num_points, {}};
  for (const std::string& file : request.files) {
    SolutionData solution = read_one(file, num_points, mesh_file);
    std::ranges::move(solution.fields, std::back_inserter(all.fields));
  }
  return all;
}

std::string accounts_text(const std::vector<ComponentAccount>& accounts, TransferMethod method) {
  const char* how = method == TransferMethod::linear ? "linear" : "conservative";
  std::string text = fmt::format("{:<28}{:>16}{:>12}{:>14}{:>14}\n", fmt::format("fields, {}", how),
                                 "integral", "changed by", "back, L2", "back, most");
  for (const ComponentAccount& a : accounts)
    text += fmt::format("  {:<26.26}{:>16.6g}{:>12}{:>14}{:>14}\n", a.name, a.integral_after,
                        relative(a.integral_after - a.integral_before, a.absolute),
                        relative(a.difference_l2, a.norm_l2), relative(a.difference_max, a.norm_max));
  const auto definite = std::ranges::count_if(accounts, &ComponentAccount::stays_definite) / 6;
  if (definite > 0)
    text += fmt::format("  {} of the fields are tensors that were positive definite, and are so again\n",
                        definite);
  return text;
}

std::vector<std::string> transfer_warnings(const meshing::Transfer& transfer, const std::string& mesh_file) {
  constexpr double kRounding = 1e-12;
  std::vector<std::string> warnings;
  if (transfer.outside > 0)
    warnings.push_back(fmt::format("{} vertices lie outside {}, up to {:.3g} from it",
                                   grouped(transfer.outside), mesh_file, transfer.farthest));
  for (const ComponentAccount& a : transfer.accounts)
    if (a.beyond_bounds > kRounding * a.norm_max)
      warnings.push_back(
          fmt::format("{} leaves its old bounds by {:.3g} to keep its integral", a.name, a.beyond_bounds));
  return warnings;
}

}  // namespace weft::tools
