// Translation of aliases and "did you mean".
#include "tools/weft/options/arguments.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "tools/common/text.h"

namespace weft::tools {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kAliases = {{
    {"-met", "--metric"},
    {"-sol", "--metric"},
    {"-out", "--out"},
    {"-hgrad", "--hgrad"},
    {"-hmin", "--hmin"},
    {"-hmax", "--hmax"},
    {"-hausd", "--hausd"},
    {"-ar", "--ridge-angle"},
    {"-noinsert", "--no-insert"},
    {"-noswap", "--no-swap"},
    {"-nomove", "--no-move"},
}};

}  // namespace

std::vector<std::string> translate_aliases(std::vector<std::string> arguments) {
  const auto end = std::find(arguments.begin(), arguments.end(), "--");
  std::for_each(arguments.begin(), end, [](std::string& argument) {
    const auto alias = std::find_if(kAliases.begin(), kAliases.end(),
                                    [&](const auto& candidate) { return candidate.first == argument; });
    if (alias != kAliases.end()) argument = alias->second;
  });
  // The input is the positional argument: Mmg's word for it says nothing more.
  arguments.erase(std::remove(arguments.begin(), end, "-in"), end);
  return arguments;
}

std::string closest_word(const std::string& word, const std::vector<std::string>& words) {
  constexpr std::size_t kMostChanges = 2;
  std::string best;
  std::size_t best_distance = kMostChanges + 1;
  for (const std::string& candidate : words) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace weft::tools
