// The program's version, which CMakeLists.txt sets, and what it is built of.
#pragma once

#include <string>

namespace weft::tools {

inline constexpr const char* kVersion = WEFT_VERSION;

/// `weft X.Y.Z`, then a line for the compiler, each library, the processor and the assertions; no
/// line end after the last.
std::string version_text();

}  // namespace weft::tools
