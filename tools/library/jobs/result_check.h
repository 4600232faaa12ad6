// The final check of a mesh that is whole.
#pragma once

#include "weft/weft.h"

namespace weft::tools {

/// Throws RunError that says what is wrong where the mesh does not conform: a fault of weft.
void check_conforms(const Mesh& mesh);

}  // namespace weft::tools
