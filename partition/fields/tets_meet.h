// Whether two tets have a point in common.
#pragma once

#include "partition/decompose/tet_measures.h"

namespace weft::partition {

/// By the axes that could separate them: never false where they meet; may be true where they are nearer than
/// 1e-4 of the first one's size. About 0.3 us.
bool tets_meet(const TetCorners& a, const TetCorners& b);

}  // namespace weft::partition
