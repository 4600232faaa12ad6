// Values of several fields at vertices, side by side.
#pragma once

#include <cstddef>
#include <vector>

namespace weft::meshing {

/// Values at vertices, several columns: column c of vertex v at v * columns + c.
struct ValueTable {
  std::size_t columns = 0;
  std::vector<double> values;
};

}  // namespace weft::meshing
