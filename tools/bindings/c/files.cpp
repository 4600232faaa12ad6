// From files to files.
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "tools/bindings/c/asked.h"
#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"
#include "weft/replay.h"

namespace weft::c {
namespace {

using Encoding = WriteOptions::Encoding;
constexpr std::array<std::pair<const char*, Encoding>, 3> kEncodings = {
    {{"binary", Encoding::binary}, {"ascii", Encoding::ascii}, {"big-endian", Encoding::big_endian}}};

Encoding encoding_of(const char* word) {
  const std::string text = require_text(word, "encoding");
  for (const auto& [name, encoding] : kEncodings)
    if (text == name) return encoding;
  throw OptionError("--encoding", "'" + printable(text) + "' is none of binary, ascii, big-endian");
}

weft_write_settings default_write() {
  const WriteOptions options;
  return {sizeof(weft_write_settings), "binary", options.gmsh_version, options.compress, options.pieces};
}

WriteOptions write_options_of(const weft_write_settings* settings) {
  weft_write_settings known = default_write();
  if (settings) copy_sized(&known, sizeof known, settings, settings->size, "settings");
  if (known.msh_version != 4 && known.msh_version != 2)
    throw OptionError("--msh-version", std::to_string(known.msh_version) + " is neither 4 nor 2");
  if (known.pieces < 1 || known.pieces > 100000)
    throw OptionError("--pieces", std::to_string(known.pieces) + " is not from 1 to 100000");
  WriteOptions options;
  options.encoding = encoding_of(known.encoding);
  options.gmsh_version = known.msh_version;
  options.compress = known.compress != 0;
  options.pieces = known.pieces;
  return options;
}

std::string text_of(const std::vector<Dropped>& dropped) {
  std::string text;
  for (const Dropped& d : dropped)
    text += d.what + (d.count > 0 ? ": " + std::to_string(d.count) : std::string()) + "\n";
  return text;
}

weft_file_settings default_files() {
  const SimulatedRanks simulated;
  weft_file_settings s{};
  s.size = sizeof s;
  s.page = 1;
  s.simulate_network = "2us,10GB/s";
  s.simulate_slowdown = simulated.slowdown;
  return s;
}

Files files_of(const char* input, const char* output, const weft_file_settings& s) {
  Files files;
  files.input = require_text(input, "input");
  files.output = require_text(output, "output");
  files.background = text_or_none(s.background);
  require_array(s.fields, s.num_fields, 1, "fields");
  for (std::int64_t i = 0; i < s.num_fields; ++i) files.fields.push_back(require_text(s.fields[i], "fields"));
  files.report = text_or_none(s.report);
  files.page = s.page != 0;
  files.case_name = text_or_none(s.case_name);
  files.graph = text_or_none(s.graph);
  files.trace = text_or_none(s.trace);
  return files;
}

std::shared_ptr<ResultObject> adapt_as_asked(const Files& files, const weft_file_settings& s,
                                             const Options& options) {
  auto object = std::make_shared<ResultObject>();
  if (s.simulate_ranks == 0) {
    object->files = std::make_shared<FilesResult>(adapt_files(files, options));
    return object;
  }
  const SimulatedRanks ranks{s.simulate_ranks, require_text(s.simulate_network, "simulate_network"),
                             s.simulate_slowdown, s.simulate_cores};
  auto simulated = std::make_shared<SimulatedFilesResult>(adapt_files_on(ranks, files, options));
  object->summary = summary(*simulated);
  object->files = std::move(simulated);
  return object;
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_adapt_files(const char* input, const char* output, const weft_options* options,
                             weft_result** result) {
  return weft_adapt_files_with(input, output, nullptr, options, result);
}

weft_status weft_file_settings_default(weft_file_settings* settings) {
  return guarded([&] {
    require_place(settings, "settings");
    fill_sized(*settings, default_files(), "settings");
  });
}

weft_status weft_adapt_files_with(const char* input, const char* output, const weft_file_settings* settings,
                                  const weft_options* options, weft_result** result) {
  return guarded([&] {
    require_place(result, "result");
    weft_file_settings known = default_files();
    if (settings) copy_sized(&known, sizeof known, settings, settings->size, "settings");
    const Asked asked(options);
    give(result, adapt_as_asked(files_of(input, output, known), known, *asked));
  });
}

weft_status weft_write_settings_default(weft_write_settings* settings) {
  return guarded([&] {
    require_place(settings, "settings");
    fill_sized(*settings, default_write(), "settings");
  });
}

weft_status weft_convert(const char* input, const char* output, const char* solution,
                         const weft_write_settings* settings, weft_text** dropped) {
  return guarded([&] {
    const weft::Converted done = weft::convert(require_text(input, "input"), require_text(output, "output"),
                                               text_or_none(solution), write_options_of(settings));
    if (dropped) give_text(dropped, text_of(done.dropped));
  });
}

}  // extern "C"
