// `dot` reads one temporary file and writes another: pipes in both directions could wait for each other.
#include "tools/library/report/graphviz.h"

#include <stdlib.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "engine/base/text.h"
#include "meshing/base/error.h"
#include "tools/common/shell_command.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using meshing::InputError;

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (fs::temp_directory_path() / "weft-graph-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw InputError("", "", "no temporary folder can be made");
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

constexpr int kMostSeconds = 60;
constexpr int kTimedOut = 124;  // as coreutils' timeout says it

std::string text_in(const fs::path& path) {
  std::ostringstream text = engine::text_stream();
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

std::string svg_of(const std::string& dot) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "graph.dot", std::ios::binary) << dot;
  const std::atomic<bool> never = false;
  const ShellResult result =
      run_shell("exec timeout " + std::to_string(kMostSeconds) + " dot -Tsvg -o graph.svg graph.dot",
                folder.path(), folder.path() / "log", never);
  if (result.status == kTimedOut)
    throw InputError("", "",
                     "is too large for Graphviz, which had not drawn it after a minute: filter it, use "
                     "--collapse, or write .dot for another program");
  if (result.status == 127) throw InputError("", "", "SVG needs Graphviz's `dot`, which is not installed");
  if (result.status != 0) throw InputError("", "", "Graphviz failed: " + text_in(folder.path() / "log"));
  return text_in(folder.path() / "graph.svg");
}

}  // namespace weft::tools
