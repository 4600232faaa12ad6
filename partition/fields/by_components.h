// Moves of fields as moves of numbers.
#pragma once

#include <cstddef>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::partition {

/// The values of a field after each of its `components`, one number a point, has gone through `move`; a field
/// that is elsewhere may be empty here.
template <class Move>
std::vector<double> by_components(const std::vector<double>& values, std::size_t components,
                                  const Move& move) {
  std::vector<double> moved;
  for (std::size_t c = 0; c < components; ++c) {
    std::vector<double> column;
    column.reserve(values.size() / components);
    for (std::size_t i = c; i < values.size(); i += components) column.push_back(values[i]);
    column = move(column);
    moved.resize(column.size() * components);
    for (std::size_t i = 0; i < column.size(); ++i) moved[i * components + c] = column[i];
  }
  return moved;
}

/// All fields likewise, at `num_points` points then.
template <class Move>
meshing::SolutionData by_components(const meshing::SolutionData& fields, std::size_t num_points,
                                    const Move& move) {
  meshing::SolutionData result{num_points, {}};
  for (const meshing::Field& field : fields.fields)
    result.fields.push_back(
        {field.kind, by_components(field.values, static_cast<std::size_t>(components(field.kind)), move),
         field.name});
  return result;
}

}  // namespace weft::partition
