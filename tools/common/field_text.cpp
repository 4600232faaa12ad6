#include "tools/common/field_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/common/text.h"

namespace weft::tools {
namespace {

std::string relative(double x, double scale) { return scale > 0 ? fmt::format("{:.2e}", x / scale) : "-"; }

}  // namespace

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

std::vector<std::string> transfer_warnings(const Transfer& transfer, const std::string& mesh_file) {
  constexpr double kRounding = 1e-12;
  std::vector<std::string> warnings;
  if (transfer.outside > 0)
    warnings.push_back(fmt::format("{} {} outside {}, up to {:.3g} from it",
                                   counted(transfer.outside, "vertex"),
                                   transfer.outside == 1 ? "lies" : "lie",
                                   mesh_file.empty() ? "the old mesh" : mesh_file, transfer.farthest));
  for (const ComponentAccount& a : transfer.accounts)
    if (a.beyond_bounds > kRounding * a.norm_max)
      warnings.push_back(
          fmt::format("{} leaves its old bounds by {:.3g} to keep its integral", a.name, a.beyond_bounds));
  return warnings;
}

}  // namespace weft::tools
