#include "tools/weft/options/field_options.h"

#include <CLI/CLI.hpp>
#include <map>

#include "tools/weft/options/option_checks.h"

namespace weft::tools {

CLI::Option* add_field_options(CLI::App& command, FieldChoice& choice, const std::string& owner,
                               const std::string& group) {
  static const std::map<std::string, TransferMethod> methods = {
      {"linear", TransferMethod::linear}, {"conservative", TransferMethod::conservative}};
  CLI::Option* fields = command
                            .add_option("--field", choice.files,
                                        "fields at the vertices of " + owner + " to transfer, also " + owner +
                                            " itself; repeatable")
                            ->type_name("FILE")
                            ->expected(1)
                            ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
                            ->group(group);
  command
      .add_option("--transfer", choice.method,
                  "linear (default) or conservative (preserves integrals and definite tensors)")
      ->transform(one_of(methods))
      ->type_name("HOW")
      ->needs(fields)
      ->group(group);
  return fields;
}

}  // namespace weft::tools
