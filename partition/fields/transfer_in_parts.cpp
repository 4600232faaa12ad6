// Slices become parts, the transfer is meshing's, and the result becomes slices again.
#include "partition/fields/transfer_in_parts.h"

#include <numeric>
#include <vector>

#include "partition/communication/ranges.h"
#include "partition/fields/by_components.h"
#include "partition/fields/part_pair.h"

namespace weft::partition {

meshing::Transfer transfer_in_parts(Peers& peers, const MeshSlice& from, const meshing::SolutionData& fields,
                                    const MeshSlice& to, meshing::TransferMethod method,
                                    const std::atomic<bool>* interrupt,
                                    const std::function<void()>& slices_are_read) {
  PartPair meshes(peers, from, to, interrupt);
  const std::size_t points = to.points.size();
  const meshing::SolutionData at_part =
      by_components(fields, meshes.old_mesh().mesh().points.size(),
                    [&](const auto& values) { return meshes.old_mesh().from_slices(values); });
  if (slices_are_read) slices_are_read();
  meshing::Transfer result = meshing::transfer(meshes, at_part, method);
  result.fields = by_components(result.fields, points,
                                [&](const auto& values) { return meshes.new_mesh().to_slices(values); });
  return result;
}

meshing::Transfer keep_fields_in_parts(Peers& peers, const MeshSlice& slice,
                                       const meshing::SolutionData& fields, std::uint64_t points,
                                       meshing::TransferMethod method) {
  const PartDomain domain(peers, slice, 1);
  meshing::Transfer result =
      meshing::keep_fields(domain,
                           by_components(fields, domain.mesh().points.size(),
                                         [&](const auto& values) { return domain.from_slices(values); }),
                           method);
  const Ranges given(peers, slice.points.size()), wanted(peers, points);
  std::vector<std::uint32_t> numbers(points);
  std::iota(numbers.begin(), numbers.end(), static_cast<std::uint32_t>(wanted.first(peers.rank())));
  result.fields = by_components(fields, points, [&](const auto& values) {
    return fetch<double>(peers, given, numbers, [&](std::size_t i) { return values[i]; });
  });
  return result;
}

}  // namespace weft::partition
