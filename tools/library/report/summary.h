// The readable account of a run; nothing wider than 100 columns unless a path is.
#pragma once

#include <string>

#include "weft/weft.h"

namespace weft::tools {

std::string summary_text(const Report& run);
/// With the names of the files.
std::string summary_text(const FilesResult& run);

}  // namespace weft::tools
