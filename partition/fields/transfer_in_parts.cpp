// Slices become parts, the transfer is meshing's, and the result becomes slices again.
#include "partition/fields/transfer_in_parts.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "partition/fields/part_pair.h"

namespace weft::partition {
namespace {

/// Each component by itself, through `move`.
template <class Move>
std::vector<double> by_components(const meshing::Field& field, const Move& move) {
  const auto n = static_cast<std::size_t>(meshing::components(field.kind));
  std::vector<double> moved;
  for (std::size_t c = 0; c < n; ++c) {
    std::vector<double> column;
    for (std::size_t i = c; i < field.values.size(); i += n) column.push_back(field.values[i]);
    column = move(column);
    moved.resize(column.size() * n);
    for (std::size_t i = 0; i < column.size(); ++i) moved[i * n + c] = column[i];
  }
  return moved;
}

}  // namespace

meshing::Transfer transfer_in_parts(Peers& peers, const MeshSlice& from, const meshing::SolutionData& fields,
                                    const MeshSlice& to, meshing::TransferMethod method) {
  PartPair meshes(peers, from, to);
  meshing::SolutionData at_part{meshes.old_mesh().mesh().points.size(), {}};
  for (const meshing::Field& field : fields.fields)
    at_part.fields.push_back(
        {field.kind, by_components(field, [&](const auto& v) { return meshes.old_mesh().from_slices(v); }),
         field.name});
  meshing::Transfer result = meshing::transfer(meshes, at_part, method);
  for (meshing::Field& field : result.fields.fields)
    field.values = by_components(field, [&](const auto& v) { return meshes.new_mesh().to_slices(v); });
  result.fields.num_points = to.points.size();
  return result;
}

}  // namespace weft::partition
