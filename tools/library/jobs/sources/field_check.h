// What is known of a file of fields without holding it.
#pragma once

#include <string>

#include "weft/weft.h"

namespace weft::tools {

/// count_vertices() of <weft/weft.h>.
VertexCount count_vertices_of(const std::string& mesh);
/// check_field_file() of <weft/weft.h>.
Fields check_field_file(const std::string& file, const VertexCount& vertices, const std::string& mesh);

}  // namespace weft::tools
