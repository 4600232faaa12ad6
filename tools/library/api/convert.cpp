// From one file format to another.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "meshing/io/ugrid.h"
#include "tools/common/inputs.h"
#include "tools/common/text.h"
#include "tools/library/jobs/sources/field_source.h"
#include "weft/weft.h"

namespace weft {
namespace {

/// Adds the fields of a file to those that the input itself has.
void add_solution(const std::string& input, const std::string& file, MeshFile& contents) {
  Fields solution = read_fields(file);
  const std::size_t num_points = contents.mesh.points.size();
  if (solution.num_points != num_points)
    throw InputError(file, "",
                     fmt::format("belongs to another mesh: it has {} vertices, {} has {}",
                                 tools::grouped(std::uint64_t{solution.num_points}), input,
                                 tools::grouped(std::uint64_t{num_points})));
  tools::check_values(file, solution);
  contents.fields.num_points = num_points;
  std::ranges::move(solution.fields, std::back_inserter(contents.fields.fields));
}

}  // namespace

Converted convert(const std::string& input, const std::string& output, const std::string& solution,
                  const WriteOptions& options) {
  tools::keep_solution(input, output, solution);
  check_writable(output);
  MeshFile contents = read_mesh_file(input);
  tools::check_values(input, contents.fields);
  if (!solution.empty()) add_solution(input, solution, contents);
  const bool beside = !contents.fields.fields.empty() && holds_volumes(output) && !holds_fields(output);
  const std::string file = fields_beside(output);
  if (beside) check_writable(file);
  const bool has_mapbc = meshing::has_mapbc_for(input, output);
  if (has_mapbc) meshing::leave_to_mapbc(input, contents.names, contents.dropped);
  const Mesh& mesh = contents.mesh;
  Converted done{{mesh.points.size(), mesh.tets.size(), mesh.triangles.size(), mesh.edges.size()},
                 std::move(contents.dropped)};
  std::ranges::move(write_mesh_file(output, contents, options), std::back_inserter(done.dropped));
  if (beside) write_fields(file, contents.fields);
  if (has_mapbc) meshing::copy_mapbc(input, output);
  return done;
}

}  // namespace weft
