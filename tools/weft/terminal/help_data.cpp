#include "tools/weft/terminal/help_data.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "engine/json/json.h"
#include "tools/weft/terminal/help.h"

namespace weft::tools {
namespace {

using Json = nlohmann::ordered_json;

Json option_data(const CLI::Option& option) {
  const bool flag = option.get_items_expected_max() == 0;
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  Json data;
  data["names"] = names;
  data["value"] = flag                      ? std::string()
                  : option.get_positional() ? option.get_name(true)
                                            : option.get_type_name();
  data["kind"] = flag ? std::string() : option.get_type_name();
  data["positional"] = option.get_positional();
  data["required"] = option.get_required();
  data["repeatable"] = option.get_expected_max() > 1;
  data["group"] = option.get_group();
  data["text"] = option.get_description();
  return data;
}

Json command_data(const CLI::App& app, const std::string& path) {
  Json data;
  data["name"] = path;
  data["text"] = app.get_description();
  std::string usage = HelpFormatter().make_usage(&app, path);
  while (!usage.empty() && usage.back() == '\n') usage.pop_back();
  data["usage"] = usage;
  data["options"] = Json::array();
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty()) data["options"].push_back(option_data(*option));
  data["footer"] = app.get_footer();
  data["commands"] = Json::array();
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    data["commands"].push_back(command_data(*sub, path + " " + sub->get_name()));
  return data;
}

}  // namespace

std::string help_data(const CLI::App& app) { return command_data(app, app.get_name()).dump(1); }

}  // namespace weft::tools
