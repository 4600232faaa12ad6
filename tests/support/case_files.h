// Where the real inputs are, which tests do without (skipping, loudly) where they are not.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace weft::support {

/// The folder of the case files, WEFT_CASES of the environment or beside the checkout; it need not exist.
inline std::filesystem::path case_files() {
  const char* given = std::getenv("WEFT_CASES");
  return given ? given : WEFT_CASES;
}

}  // namespace weft::support
