// Text made small.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace weft::report {

/// RFC 1952. Throws std::bad_alloc.
std::vector<std::byte> gzip(std::string_view text);

}  // namespace weft::report
