// New numbers for the vertices of elements.
#pragma once

#include <cstdint>
#include <span>

namespace weft::meshing {

/// `numbers`: of each old vertex, the new one. `elements`: rows of vertices, all of which have a number.
template <class Elements>
void renumber_vertices(Elements& elements, std::span<const std::uint32_t> numbers) {
  for (auto& element : elements)
    for (std::uint32_t& v : element) v = numbers[v];
}

}  // namespace weft::meshing
