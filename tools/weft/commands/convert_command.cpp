// `weft convert`: from one file format to another.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/common/text.h"
#include "tools/weft/commands/commands.h"
#include "tools/weft/options/option_checks.h"
#include "tools/weft/options/verbosity.h"
#include "tools/weft/terminal/exit_codes.h"
#include "weft/on_ranks.h"
#include "weft/weft.h"

namespace weft::tools {
namespace {

constexpr const char* kConvertFooter = R"(Examples:
  weft convert fine.meshb fine.vtu --sol fine.solb --compress
  weft convert wing.msh wing.lb8.ugrid

Volumes: .meshb .mesh (Gamma), .msh (Gmsh), .ugrid (as .lb8.ugrid, .b8.ugrid, .lb8l.ugrid, ...; ASCII
without), .su2, .vtu .pvtu (VTK), .cgns. Surfaces: .stl .obj .off .ply. Each is read and written.
Fields of the input and of --sol are written into the result if its format holds fields, else beside it
into a .solb (beside a .mesh into a .sol). Whatever is dropped is listed: what weft cannot represent and
what the new format cannot hold.)";

struct ConvertCommand {
  std::string input, output, solution;
  WriteOptions options;
  int pieces = 0;  ///< 0: as many as are usual
  Verbosity verbosity;
};

std::string dropped_text(const std::vector<Dropped>& dropped) {
  std::string text;
  for (const Dropped& d : dropped) {
    text += d.count > 0 ? fmt::format("dropped {}: {}\n", d.what, grouped(d.count))
                        : fmt::format("dropped {}\n", d.what);
  }
  return text;
}

void tell(const ConvertCommand& command, const MeshCounts& counts) {
  command.verbosity.print("{}: {}, {}, {}\n", command.output, counted(counts.vertices, "vertex"),
                          counted(counts.tets, "tet"), counted(counts.triangles, "triangle"));
}

int run_on_ranks(const ConvertCommand& command) {
  WriteOptions options = command.options;
  options.pieces = command.pieces;
  const ConvertedOnRanks done = convert_on_ranks(command.input, command.solution, command.output, options);
  if (!done.first) return kDone;
  for (const std::string& warning : done.warnings) command.verbosity.print("warning: {}\n", warning);
  tell(command, done.counts);
  command.verbosity.print("{}", dropped_text(done.dropped));
  return kDone;
}

int run_convert(const ConvertCommand& command) {
  if (under_mpirun()) {
    if (can_convert_on_ranks(command.input, command.solution, command.output, command.options))
      return run_on_ranks(command);
    const PlaceOnRanks place = place_on_ranks();
    if (place.rank != 0) return kDone;
    if (place.ranks > 1 && !command.verbosity.quiet) fmt::print(stderr, "{}", done_by_first("convert"));
  }
  Progress progress(command.verbosity.style());
  progress.phase("converting");
  WriteOptions options = command.options;
  if (command.pieces > 0) options.pieces = command.pieces;
  const Converted done = convert(command.input, command.output, command.solution, options);
  progress.finish();
  tell(command, done.counts);
  command.verbosity.print("{}", dropped_text(done.dropped));
  return kDone;
}

void add_choices(CLI::App& sub, WriteOptions& options, int& pieces) {
  static const std::map<std::string, WriteOptions::Encoding> encodings = {
      {"binary", WriteOptions::Encoding::binary},
      {"ascii", WriteOptions::Encoding::ascii},
      {"big-endian", WriteOptions::Encoding::big_endian}};
  sub.add_option("--encoding", options.encoding,
                 "binary (default) or ascii, of .msh, .stl, .ply and .vtu; big-endian, of .ply")
      ->transform(one_of(encodings))
      ->type_name("WORD");
  static const std::map<std::string, int> versions = {{"4.1", 4}, {"2.2", 2}};
  sub.add_option("--msh-version", options.gmsh_version, "4.1 (default) or 2.2, of .msh")
      ->transform(one_of(versions))
      ->type_name("V");
  sub.add_flag("--compress", options.compress, "compress the arrays of a .vtu or .pvtu");
  sub.add_option("--pieces", pieces, "pieces of a .pvtu; default 2, of more ranks one each")
      ->check(CLI::Range(1, 100000).description(""))
      ->type_name("N");
}

/// An option that the output's format has no use for is a mistake in one of them.
void check_choices(const CLI::App& sub, const ConvertCommand& command) {
  static const std::map<std::string, std::vector<std::string>> formats = {
      {"--encoding", {".msh", ".stl", ".ply", ".vtu", ".pvtu"}},
      {"--msh-version", {".msh"}},
      {"--compress", {".vtu", ".pvtu"}},
      {"--pieces", {".pvtu"}}};
  const std::string extension = std::filesystem::path(command.output).extension().string();
  for (const auto& [option, extensions] : formats)
    if (sub.count(option) > 0 && std::ranges::find(extensions, extension) == extensions.end())
      throw CLI::ValidationError(
          option, fmt::format("is for {}, not for '{}'", fmt::join(extensions, ", "), command.output));
  using Encoding = WriteOptions::Encoding;
  if (command.options.encoding == Encoding::big_endian && extension != ".ply")
    throw CLI::ValidationError("--encoding", "big-endian is for .ply, not for '" + command.output + "'");
  if (command.options.encoding == Encoding::ascii && command.options.compress)
    throw CLI::ValidationError("--compress", "is for binary arrays, not for --encoding ascii");
}

}  // namespace

void add_convert_command(CLI::App& app, Action& action) {
  CLI::App* sub = app.add_subcommand("convert", "convert a mesh and its fields to another format");
  sub->footer(kConvertFooter);
  auto command = std::make_shared<ConvertCommand>();
  sub->add_option("IN", command->input, "the mesh")->type_name("FILE")->required();
  sub->add_option("OUT", command->output, "the result; its extension names the format")
      ->type_name("FILE")
      ->check(mesh_output_name())
      ->required();
  sub->add_option("--sol,--metric", command->solution,
                  "fields at the vertices, .solb or .sol (also -sol, -met)")
      ->type_name("FILE");
  add_choices(*sub, command->options, command->pieces);
  add_verbosity(*sub, command->verbosity);
  sub->callback([command, &action, sub] {
    check_choices(*sub, *command);
    action = [command] { return run_convert(*command); };
  });
}

}  // namespace weft::tools
