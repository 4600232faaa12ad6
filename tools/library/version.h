// The program's version, which CMakeLists.txt sets.
#pragma once

namespace weft::tools {

inline constexpr const char* kVersion = WEFT_VERSION;

}  // namespace weft::tools
