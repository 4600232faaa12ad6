// `weft report`: the page of a run, or two runs compared.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "tools/weft/commands/commands.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kReportFooter = R"(Examples:
  weft report run/profile.json -o run.html
  weft report before/profile.json after/profile.json
  weft report before/profile.json after/profile.json -o compared.html

One file: writes the page that `weft adapt --report DIR` wrote as DIR/report.html again. Two files: prints
what became slower, by operation and rank, and how the meshes differ; with -o also as a page. A report.json
can be compared too.)";

struct ReportCommand {
  std::string a, b, output;
  Verbosity verbosity;
};

int run_report(const ReportCommand& command) {
  if (command.b.empty() && command.output.empty())
    throw CLI::RequiredError("give a second run to compare with, or -o to write the page of this one",
                             CLI::ExitCodes::RequiredError);
  if (!command.output.empty()) check_writable(command.output);
  Progress progress(command.verbosity.style());
  std::string text;
  progress.phase("reading");
  if (command.b.empty())
    write_report_page(command.a, command.output);
  else
    text = compare_reports(command.a, command.b, command.output);
  progress.finish();
  command.verbosity.print("{}", text);
  return kDone;
}

}  // namespace

void add_report_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("report", "write the page of a run, or compare two runs");
  sub->footer(kReportFooter);
  auto command = std::make_shared<ReportCommand>();
  sub->add_option("A", command->a, "profile.json or report.json of a run")->type_name("FILE")->required();
  sub->add_option("B", command->b, "profile.json or report.json of another run")->type_name("FILE");
  sub->add_option("-o,-x,--out", command->output, "the page, .html (also -out)")->type_name("FILE");
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action] { action = [command] { return run_report(*command); }; });
}

}  // namespace weft::tools
