// libFuzzer target: every reader of meshes and fields. The first byte of an input chooses the format, the
// rest is the file. Anything but a result or an InputError is a finding.
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "weft/weft.h"

namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 14> kExtensions = {".meshb", ".mesh", ".solb", ".sol",  ".msh",
                                                     ".ugrid", ".su2",  ".vtu",  ".pvtu", ".cgns",
                                                     ".stl",   ".ply",  ".obj",  ".off"};

void read(const std::string& path) {
  const std::string extension = fs::path(path).extension();
  try {
    if (extension == ".solb" || extension == ".sol") {
      weft::read_fields(path);
      return;
    }
    weft::MeshFile file = weft::read_mesh_file(path);
    weft::verify(file.mesh);
    if (!file.mesh.tets.empty()) weft::repair(file.mesh);
  } catch (const weft::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const fs::path path = fs::temp_directory_path() /
                        ("weft-fuzz-" + std::to_string(getpid()) + kExtensions[data[0] % kExtensions.size()]);
  {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
  }
  read(path.string());
  fs::remove(path);
  return 0;
}
