// Files that are read are not to be replaced.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "weft/weft.h"

namespace weft::tools {

inline bool same_file(const std::string& a, const std::string& b) {
  std::error_code missing;
  return std::filesystem::equivalent(a, b, missing) && !missing;
}

/// Throws OptionError where `output`, called `name`, is one of the inputs.
inline void keep_inputs(const std::string& output, const std::string& name,
                        const std::vector<std::string>& inputs) {
  for (const std::string& file : inputs)
    if (same_file(output, file)) throw OptionError("--out", name + " would replace the input " + file);
}

}  // namespace weft::tools
