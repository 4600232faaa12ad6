#include "meshing/base/load_part.h"

#include <dlfcn.h>

#include <array>
#include <filesystem>

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOtherVersion = " is of another version of weft";

/// The folder of the library or program that holds this code.
fs::path own_folder() {
  Dl_info info;
  if (dladdr(reinterpret_cast<void*>(&own_folder), &info) == 0 || !info.dli_fname) return {};
  std::error_code ignored;
  return fs::weakly_canonical(info.dli_fname, ignored).parent_path();
}

/// When this was loaded: a relative name means another file once the program has gone to another folder.
const fs::path kOwnFolder = own_folder();

/// Beside this code, where an installation has its libraries (which may be two folders up: those for some
/// processors only lie in glibc-hwcaps/LEVEL), and where a build has them.
std::array<fs::path, 6> folders() {
  const fs::path& own = kOwnFolder;
  return {own, own / "weft", own / "../lib", own / "../lib/weft", own / "../../weft", WEFT_PARTS_FOLDER};
}

}  // namespace

Part load_part(const char* file, const char* entry, int interface) {
  Part part;
  std::error_code ignored;
  for (const fs::path& folder : folders()) {
    const fs::path place = folder / file;
    if (!fs::exists(place, ignored)) continue;
    void* library = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) {
      part.reason = dlerror();
      continue;
    }
    const auto function = reinterpret_cast<PartEntry>(dlsym(library, entry));
    part.offer = function ? function(interface) : nullptr;
    if (part.offer) return part;
    part.reason = place.string() + kOtherVersion;
  }
  return part;
}

std::string missing_part_text(const Part& part, const char* file, const char* uses, const char* package) {
  if (part.reason.empty()) return std::string(file) + ", a part of weft, is missing: install weft again";
  if (part.reason.ends_with(kOtherVersion)) return part.reason + ": install weft again";
  return std::string(uses) + " cannot be loaded (" + part.reason + "): install " + package +
         " (Debian, Ubuntu)";
}

}  // namespace weft::meshing
