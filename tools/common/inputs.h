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

/// Throws OptionError where `output`, called `name` and given by `option`, is one of the inputs.
inline void keep_inputs(const std::string& output, const std::string& name,
                        const std::vector<std::string>& inputs, const std::string& option = "--out") {
  for (const std::string& file : inputs)
    if (same_file(output, file)) throw OptionError(option, name + " would replace the input " + file);
}

}  // namespace weft::tools
