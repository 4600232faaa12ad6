// libFuzzer target: every reader of meshes and fields. The first line of an input is the extension that names
// its format, the rest is the file. Anything but a result or an InputError is a finding.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "weft/weft.h"

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 16> kExtensions = {
    ".lb8.ugrid", ".b8.ugrid", ".meshb", ".mesh", ".solb", ".sol", ".msh", ".ugrid",
    ".su2",       ".vtu",      ".pvtu",  ".cgns", ".stl",  ".ply", ".obj", ".off"};

void read(const std::string& path, std::string_view extension) {
  try {
    if (extension == ".solb" || extension == ".sol") {
      weft::read_fields(path);
      return;
    }
    weft::MeshFile file = weft::read_mesh_file(path);
    weft::verify(file.mesh);
    if (!file.mesh.tets.empty())
      weft::repair(file.mesh);
    else if (!file.mesh.triangles.empty())
      weft::repair_surface(file.mesh);
  } catch (const weft::InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t end = input.substr(0, 12).find('\n');
  if (end == std::string_view::npos) return 0;
  const std::string_view extension = input.substr(0, end), contents = input.substr(end + 1);
  if (std::find(kExtensions.begin(), kExtensions.end(), extension) == kExtensions.end()) return 0;
  const fs::path path =
      fs::temp_directory_path() / ("weft-fuzz-" + std::to_string(getpid()) + std::string(extension));
  std::ofstream(path, std::ios::binary).write(contents.data(), static_cast<std::streamsize>(contents.size()));
  read(path.string(), extension);
  fs::remove(path);
  return 0;
}
