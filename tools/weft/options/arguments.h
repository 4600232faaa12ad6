// The peers' option words: what Mmg, refine and ParMmg users type is understood too.
#pragma once

#include <string>
#include <vector>

namespace weft::tools {

/// Replaces single-dash words such as `-hgrad` and `-sol`, which the parser would read as bundles of
/// one-letter options, by their double-dash names. Nothing behind `--` is touched.
std::vector<std::string> translate_aliases(std::vector<std::string> arguments);

/// The subcommand most like `word`, or empty when none is.
std::string closest_word(const std::string& word, const std::vector<std::string>& words);

}  // namespace weft::tools
