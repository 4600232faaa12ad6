// What became of fields that were carried to another mesh, as text.
#pragma once

#include <string>
#include <vector>

#include "weft/data.h"

namespace weft::tools {

/// A table: integrals, their change, and what comes back when the result is interpolated to the old mesh.
std::string accounts_text(const std::vector<ComponentAccount>& accounts, TransferMethod method);
/// What the user should know: vertices outside the old mesh, and bounds that the integral could not keep.
std::vector<std::string> transfer_warnings(const Transfer& transfer, const std::string& mesh_file);

}  // namespace weft::tools
