// The help formatter.
#include "tools/weft/terminal/help.h"

#include <utility>

namespace weft::tools {
namespace {

std::string short_name(const CLI::Option& option) {
  return option.get_snames().empty() ? "--" + option.get_lnames().front() : "-" + option.get_snames().front();
}

}  // namespace

HelpFormatter::HelpFormatter() { column_width(30); }

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  const bool flag = option->get_items_expected_max() == 0;
  const std::string placeholder = option->get_type_name();
  return flag || option->get_positional() || placeholder.empty() ? std::string() : " " + placeholder;
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  std::string text = CLI::Formatter::make_help(app, std::move(name), mode);
  for (auto at = text.find("\n\n\n"); at != std::string::npos; at = text.find("\n\n\n")) text.erase(at, 1);
  return text;
}

std::string HelpFormatter::make_usage(const CLI::App* app, std::string name) const {
  std::string usage = "Usage: " + (name.empty() ? app->get_name() : name);
  for (const CLI::Option* option : app->get_options())
    if (option->get_positional()) usage += " " + option->get_name(true);
  for (const CLI::Option* option : app->get_options())
    if (option->get_required() && !option->get_positional())
      usage += " " + short_name(*option) + " " + option->get_type_name();
  if (!app->get_subcommands([](const CLI::App*) { return true; }).empty()) usage += " SUBCOMMAND";
  return usage + " [options]\n";
}

}  // namespace weft::tools
