// Checks of options.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "weft/weft.h"

namespace weft {

/// Throws OptionError unless `good`.
inline void require(bool good, const char* option, const std::string& reason) {
  if (!good) throw OptionError(option, reason);
}

inline void require_positive(const char* option, double value) {
  require(value > 0 && std::isfinite(value), option, fmt::format("{} is not a positive number", value));
}

}  // namespace weft
