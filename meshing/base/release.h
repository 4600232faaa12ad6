// Memory of vectors given back.
#pragma once

#include <vector>

namespace weft::meshing {

/// Empties a vector and gives its memory back, which "= {}" does not: that assigns an empty list.
template <class T>
void release(std::vector<T>& values) {
  values = std::vector<T>();
}

}  // namespace weft::meshing
