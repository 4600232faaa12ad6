// How often tests at random try: fewer times in the suite that everybody runs.
#pragma once

#include <cstdlib>

namespace weft::support {

/// `all` where WEFT_LONG_TESTS is set, as by scripts/nightly.sh.
inline unsigned repetitions(unsigned usual, unsigned all) {
  return std::getenv("WEFT_LONG_TESTS") ? all : usual;
}

}  // namespace weft::support
