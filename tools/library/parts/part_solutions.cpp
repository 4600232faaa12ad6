#include "tools/library/parts/part_solutions.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "meshing/metric/sources/multiscale.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/parts/naming_rank.h"
#include "tools/library/parts/part_numbers.h"
#include "tools/library/parts/part_values.h"

namespace weft::tools {
namespace {

using partition::Peers;
using Values = std::span<const double>;

/// The scalar fields of all solutions, as many on all ranks: those of a rank without points have no values.
std::vector<Values> agreed_scalars(Peers& peers, const Part& part, const std::vector<Fields>& solutions) {
  const std::size_t num_points = part.mesh.points.size();
  std::vector<Values> scalars;
  agree_naming_rank(peers, [&] {
    if (num_points == 0) return;
    for (const Fields& solution : solutions) {
      check_fields(part.mesh, solution);
      for (const Values values : meshing::scalar_fields(solution, num_points, "solutions"))
        scalars.push_back(values);
    }
  });
  std::vector<std::uint64_t> mine;
  if (num_points > 0) mine.push_back(scalars.size());
  std::vector<std::uint64_t> counts;
  for (const auto& of_rank : partition::allgather(peers, mine))
    counts.insert(counts.end(), of_rank.begin(), of_rank.end());
  if (std::ranges::adjacent_find(counts, std::not_equal_to<>()) != counts.end())
    throw InputError("", "solutions", "are not of the same number of scalar fields on all ranks");
  scalars.resize(counts.empty() ? 0 : counts[0]);
  return scalars;
}

}  // namespace

Fields solutions_of_slices(Peers& peers, const Part& part, const std::vector<Fields>& solutions) {
  const IdHomes homes(peers, largest_id(part.ids));
  Fields of_slice;
  for (const Values values : agreed_scalars(peers, part, solutions)) {
    std::string issue;
    of_slice.fields.push_back(
        {Field::Kind::scalar, values_of_slice(peers, homes, part.ids, values, issue), ""});
    partition::agree(peers, issue.empty() ? issue : issue + " of a solution");
  }
  if (!of_slice.fields.empty()) of_slice.num_points = of_slice.fields[0].values.size();
  return of_slice;
}

}  // namespace weft::tools
