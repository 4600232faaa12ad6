// Text from files, made fit for a terminal.
#pragma once

#include <string>
#include <string_view>

namespace weft::meshing {

/// The text with a question mark for every control character and for every byte that is not part of valid
/// UTF-8: damaged and binary files end up in messages.
std::string printable(std::string_view text);

}  // namespace weft::meshing
