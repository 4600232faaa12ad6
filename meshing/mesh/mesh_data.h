// A mesh and its fields as files hold them: plain arrays that the public interface shares.
#pragma once

#include <array>
#include <cstdint>

#include "meshing/base/point.h"
#include "weft/data.h"

namespace weft::meshing {

/// Vertices, as in MeshData's rows of tets and triangles.
using Tet = std::array<std::uint32_t, 4>;
using Triangle = std::array<std::uint32_t, 3>;

}  // namespace weft::meshing
