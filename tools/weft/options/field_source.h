// Which fields a command carries to its new mesh, how, and what to say about it afterwards.
#pragma once

#include <string>
#include <vector>

#include "meshing/fields/transfer.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace weft::tools {

struct FieldRequest {
  std::vector<std::string> files;  ///< --field
  meshing::TransferMethod method = meshing::TransferMethod::linear;

  bool given() const { return !files.empty(); }
};

/// Declares --field, whose fields belong to the mesh called `owner` in the help, and --transfer. Returns
/// --field.
CLI::Option* add_field_options(CLI::App& command, FieldRequest& request, const std::string& owner,
                               const std::string& group);

/// All fields of all files, at the `num_points` vertices of `mesh_file`. One without a name gets that of its
/// file. Throws InputError naming file, field and vertex for the fields of another mesh and for values that
/// are no finite numbers.
meshing::SolutionData read_fields(const FieldRequest& request, std::size_t num_points,
                                  const std::string& mesh_file);

/// A table: integrals, their change, and what comes back when the result is interpolated to the old mesh.
std::string accounts_text(const std::vector<meshing::ComponentAccount>& accounts,
                          meshing::TransferMethod method);
/// What the user should know: vertices outside the old mesh, and bounds that the integral could not keep.
std::vector<std::string> transfer_warnings(const meshing::Transfer& transfer, const std::string& mesh_file);

}  // namespace weft::tools
