// In what two meshes of the same domain differ.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tools/common/text.h"
#include "weft/weft.h"

namespace weft {
namespace {

using ByRef = std::map<std::int32_t, double>;

/// A sentence for each reference at which two meshes differ.
void compare(const char* what, const ByRef& ours, const ByRef& theirs, std::vector<std::string>& found) {
  constexpr double kTolerance = 1e-9;
  std::set<std::int32_t> refs;
  for (const auto& [ref, value] : ours) refs.insert(ref);
  for (const auto& [ref, value] : theirs) refs.insert(ref);
  const auto value_at = [](const ByRef& by_ref, std::int32_t ref) {
    const auto at = by_ref.find(ref);
    return at == by_ref.end() ? 0.0 : at->second;
  };
  for (const std::int32_t ref : refs) {
    const double a = value_at(ours, ref), b = value_at(theirs, ref);
    const double relative = a == b ? 0 : std::abs(a - b) / std::max(std::abs(a), std::abs(b));
    if (relative > kTolerance)
      found.push_back(fmt::format("{} of reference {} is {:.15g}, the other mesh's {:.15g}: {:.2g} apart",
                                  what, ref, a, b, relative));
  }
}

/// A body must not come to touch itself where it did not, nor come apart.
void compare_touching(const char* what, std::uint64_t ours, std::uint64_t theirs,
                      std::vector<std::string>& found) {
  if (ours != theirs)
    found.push_back(fmt::format("the body touches itself at {} {}, the other mesh's at {}",
                                tools::grouped(ours), what, tools::grouped(theirs)));
}

}  // namespace

std::vector<std::string> differences(const CheckReport& mesh, const CheckReport& other) {
  std::vector<std::string> found;
  compare("volume", mesh.volume_by_ref, other.volume_by_ref, found);
  compare("area", mesh.area_by_ref, other.area_by_ref, found);
  compare_touching("edges", mesh.touching_edges, other.touching_edges, found);
  compare_touching("vertices", mesh.touching_vertices, other.touching_vertices, found);
  return found;
}

}  // namespace weft
