// How `--help` is laid out: 110 columns at most, option names on the left, one line each.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace weft::tools {

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();
  /// The placeholder only: the parser's own adds types, defaults and checks in a jumble.
  std::string make_option_opts(const CLI::Option* option) const override;
  /// One blank line between groups instead of two.
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  /// Names the positional and required arguments.
  std::string make_usage(const CLI::App* app, std::string name) const override;
};

}  // namespace weft::tools
