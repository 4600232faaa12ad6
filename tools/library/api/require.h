// Checks of options.
#pragma once

#include <string>

#include "weft/weft.h"

namespace weft {

/// Throws OptionError unless `good`.
inline void require(bool good, const char* option, const std::string& reason) {
  if (!good) throw OptionError(option, reason);
}

}  // namespace weft
