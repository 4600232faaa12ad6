// Sorted, each once.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

namespace weft::meshing {

/// By their keys, where some are given.
template <class T, class Key = std::identity>
void sort_unique(std::vector<T>& values, Key key = {}) {
  std::ranges::sort(values, {}, key);
  const auto rest = std::ranges::unique(values, {}, key);
  values.erase(rest.begin(), rest.end());
}

}  // namespace weft::meshing
