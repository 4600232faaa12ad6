// The options that say which fields are carried along, and how.
#pragma once

#include <string>
#include <vector>

#include "weft/weft.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace weft::tools {

struct FieldChoice {
  std::vector<std::string> files;  ///< --field
  TransferMethod method = TransferMethod::linear;
};

/// Declares --field, whose fields belong to the mesh called `owner` in the help, and --transfer. Returns
/// --field.
CLI::Option* add_field_options(CLI::App& command, FieldChoice& choice, const std::string& owner,
                               const std::string& group);

}  // namespace weft::tools
