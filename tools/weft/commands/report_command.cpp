// `weft report`: the page of a run, or two runs compared.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "tools/weft/commands/commands.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kFooter = R"(Examples:
  weft report run/profile.json -o run.html
  weft report before/profile.json after/profile.json
  weft report before/profile.json after/profile.json -o compared.html

One file: writes the page again that `weft adapt --report DIR` leaves as DIR/report.html. Two: says what
got slower, by operation and rank, and how the meshes differ; with -o as a page too. report.json can be
compared as well.)";

struct ReportCommand {
  std::string a, b, output;
};

int run_report(const ReportCommand& command) {
  if (command.b.empty() && command.output.empty())
    throw CLI::RequiredError("give a second run to compare with, or -o for the page of this one",
                             CLI::ExitCodes::RequiredError);
  if (!command.output.empty()) check_writable(command.output);
  if (command.b.empty())
    write_report_page(command.a, command.output);
  else
    fmt::print("{}", compare_reports(command.a, command.b, command.output));
  return kDone;
}

}  // namespace

void add_report_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("report", "make the page of a run, or compare two runs");
  sub->footer(kFooter);
  auto command = std::make_shared<ReportCommand>();
  sub->add_option("A", command->a, "profile.json or report.json of a run")->type_name("FILE")->required();
  sub->add_option("B", command->b, "that of another one")->type_name("FILE");
  sub->add_option("-o,-x,--out", command->output, "the page, .html (also -out)")->type_name("FILE");
  sub->callback([command, &action] { action = [command] { return run_report(*command); }; });
}

}  // namespace weft::tools
