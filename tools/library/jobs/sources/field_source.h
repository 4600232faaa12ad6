// The fields that are carried to a new mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/fields/mesh_pair.h"
#include "partition/communication/peers.h"
#include "partition/slice/mesh_slice.h"
#include "weft/weft.h"

namespace weft::tools {

/// All fields of all files, at the `num_points` vertices of `mesh_file`. One without a name gets that of its
/// file. Throws InputError naming file, field and vertex for the fields of another mesh and for values that
/// are no finite numbers.
Fields read_all_fields(const std::vector<std::string>& files, std::size_t num_points,
                       const std::string& mesh_file);

/// All ranks: the same at this rank's slice of points. Throws alike on all ranks.
Fields read_fields_of_slice(partition::Peers& peers, const std::vector<std::string>& files,
                            const partition::MeshSlice& slice, const std::string& mesh_file);

/// Throws InputError naming file, field and vertex for values that are no finite numbers. `first_vertex`,
/// from 0: what the first of these is in the file, or in a piece of it, which `piece` names ("piece 2, ").
void check_values(const std::string& file, const Fields& fields, std::uint64_t first_vertex = 0,
                  const std::string& piece = {});
/// What that throws of a field, counted from 1, and a vertex, from 0.
InputError not_finite(const std::string& file, std::size_t field, std::uint64_t vertex,
                      const std::string& piece = {});
/// The reason why fields at so many vertices are refused.
std::string of_another_mesh(const VertexCount& has, const std::string& mesh_file,
                            const VertexCount& vertices);

/// Warns of fields that the input itself holds and that are left behind, since no --field is given: not of
/// the metric, which a result has anew. `own`: their kinds and names.
std::vector<std::string> left_fields_warnings(const Files& files, const Options& options, const Fields& own);

/// Returns call(), a transfer of fields; an InputError from it is thrown again with the mesh whose fault it
/// is.
template <class Call>
auto naming_meshes(const std::string& from, const std::string& to, const Call& call) {
  try {
    return call();
  } catch (const meshing::NewMeshError& fault) {
    throw InputError(to, "", fault.what());
  } catch (const InputError& fault) {
    throw InputError(from, "", fault.what());
  }
}

}  // namespace weft::tools
