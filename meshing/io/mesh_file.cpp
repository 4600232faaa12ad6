// The table of formats: which extension is read and written by what.
#include "meshing/io/mesh_file.h"

#include <string>

#include "meshing/error.h"
#include "meshing/io/gmf.h"
#include "meshing/io/vtu.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_extension(const fs::path& path, const std::string& known) {
  const std::string extension = path.extension().string();
  throw InputError(path.string(), "",
                   (extension.empty() ? "no extension" : "unexpected extension " + extension) +
                       ", known here are " + known);
}

bool is_gmf_mesh(const fs::path& path) { return path.extension() == ".meshb" || path.extension() == ".mesh"; }
bool is_gmf_solution(const fs::path& path) {
  return path.extension() == ".solb" || path.extension() == ".sol";
}
bool is_vtu(const fs::path& path) { return path.extension() == ".vtu"; }

}  // namespace

MeshData read_mesh(const fs::path& path) {
  if (is_vtu(path)) throw InputError(path.string(), "", "VTU files can be written, not read");
  if (!is_gmf_mesh(path)) fail_extension(path, ".meshb and .mesh");
  return read_gmf_mesh(path);
}

SolutionData read_solution(const fs::path& path) {
  if (!is_gmf_solution(path)) fail_extension(path, ".solb and .sol");
  return read_gmf_solution(path);
}

void write_mesh(const fs::path& path, const MeshData& mesh, const SolutionData* fields) {
  if (is_vtu(path)) return write_vtu(path, mesh, fields);
  if (!is_gmf_mesh(path)) fail_extension(path, ".meshb, .mesh and .vtu");
  write_gmf_mesh(path, mesh);
  if (!fields) return;
  fs::path beside = path;
  beside.replace_extension(path.extension() == ".meshb" ? ".solb" : ".sol");
  write_gmf_solution(beside, *fields);
}

void write_solution(const fs::path& path, const SolutionData& solution) {
  if (!is_gmf_solution(path)) fail_extension(path, ".solb and .sol");
  write_gmf_solution(path, solution);
}

}  // namespace weft::meshing
