// The files of the page, as embed_assets.py puts them into the program.
#pragma once

#include <string_view>

namespace weft::report {

/// A file of page/ or of a library by its name, for instance "style.css"; empty for one that there is not.
std::string_view asset(std::string_view name);

}  // namespace weft::report
