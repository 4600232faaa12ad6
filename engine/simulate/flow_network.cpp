// Finds and loads the part that knows SimGrid: a library of its own, so that nothing else needs it.
#include "engine/simulate/flow_network.h"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace weft::engine {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPartName = "libweft_simgrid.so";

/// The folder of the library or program that holds this code.
fs::path own_folder() {
  Dl_info info;
  if (dladdr(reinterpret_cast<void*>(&own_folder), &info) == 0 || !info.dli_fname) return {};
  std::error_code ignored;
  return fs::weakly_canonical(info.dli_fname, ignored).parent_path();
}

/// When this was loaded: a relative name means another file once the program has gone to another folder.
const fs::path kOwnFolder = own_folder();

/// Beside this code, where an installation has its libraries, and where a build has them.
std::vector<fs::path> places() {
  const fs::path& own = kOwnFolder;
  return {own / kPartName,
          own / "weft" / kPartName,
          own / "../lib" / kPartName,
          own / "../lib/weft" / kPartName,
          own / "../../weft" / kPartName,
#ifdef WEFT_PARTS_FOLDER
          fs::path(WEFT_PARTS_FOLDER) / kPartName
#endif
  };
}

struct Part {
  FlowEntry entry = nullptr;
  std::string reason;  ///< why there is none
};

Part load_part() {
  Part part;
  std::error_code ignored;
  for (const fs::path& place : places()) {
    if (!fs::exists(place, ignored)) continue;
    if (void* library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      part.entry = reinterpret_cast<FlowEntry>(dlsym(library, kFlowEntryName));
      if (part.entry) return part;
    }
    if (const char* error = dlerror()) part.reason = error;
  }
  return part;
}

}  // namespace

std::unique_ptr<FlowNetwork> make_flow_network(const NetworkModel& network, int ranks) {
  static const Part part = load_part();
  if (!part.entry)
    throw std::invalid_argument(
        part.reason.empty()
            ? "fat-tree and dragonfly need SimGrid, and this weft was built without: install "
              "libsimgrid-dev (Debian, Ubuntu) and build weft again"
            : "SimGrid cannot be loaded (" + part.reason + "): install libsimgrid3.32 (Debian, Ubuntu)");
  std::unique_ptr<FlowNetwork> made(part.entry(kFlowInterface, &network, ranks));
  if (!made) throw std::invalid_argument(std::string(kPartName) + " is of another version of weft");
  return made;
}

}  // namespace weft::engine
