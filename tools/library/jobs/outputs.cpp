// Temporary names, renames and clean-up.
#include "tools/library/jobs/outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <system_error>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/mesh_file.h"
#include "meshing/io/ugrid.h"
#include "tools/common/text.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using meshing::InputError;

/// A name in the same folder (so that a rename is atomic) with the same extension (which chooses the format).
/// Whatever still lies under it when the object goes is removed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& target) : target_(target) {
    const fs::path resolved =
        fs::is_symlink(target) && fs::exists(target) ? fs::canonical(target) : fs::path(target);
    resolved_ = resolved.string();
    path_ =
        (resolved.parent_path() / (".weft-" + std::to_string(getpid()) + "-" + resolved.filename().string()))
            .string();
  }
  ~TemporaryFile() { ::unlink(path_.c_str()); }  // as a path it would take memory
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  /// Calls write(path); an error it throws is made to name the target, which the user knows.
  template <class Write>
  void fill(const Write& write) const {
    try {
      write(path_);
    } catch (const InputError& error) {
      std::string text = error.what();
      const auto at = text.find(path_);
      if (at != std::string::npos) text.replace(at, path_.size(), target_);
      throw InputError("", "", text);
    }
  }

  void commit() const {
    std::error_code error;
    fs::rename(path_, resolved_, error);
    if (error) throw InputError(target_, "", "cannot write: " + error.message());
  }

 private:
  std::string target_, resolved_, path_;
};

}  // namespace

OutputPaths output_paths(const std::string& mesh) {
  if (fs::path(mesh).extension() == ".pvtu") return {mesh, mesh, mesh};
  const fs::path solution = meshing::solution_beside(mesh);
  const std::string fields = solution.stem().string() + "-fields" + solution.extension().string();
  return {mesh, solution.string(), (solution.parent_path() / fields).string()};
}

void check_writable(const std::string& path) {
  meshing::require_part(path);
  meshing::AtomicFile probe{path};
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error && fs::is_directory(path)) return;
  throw InputError(path, "", "cannot be made a folder" + (error ? ": " + error.message() : std::string()));
}

void write_mesh_with_solution(const OutputPaths& paths, const meshing::MeshData& mesh,
                              const meshing::SolutionData& solution, const meshing::SolutionData& fields,
                              const meshing::RefNames& names) {
  std::optional<TemporaryFile> solution_file, fields_file;
  const auto fill = [&](std::optional<TemporaryFile>& file, const std::string& path,
                        const meshing::SolutionData& values) {
    if (path == paths.mesh) return;
    file.emplace(path);
    file->fill([&](const std::string& temporary) { meshing::write_solution(temporary, values); });
  };
  fill(solution_file, paths.solution, solution);
  if (!fields.fields.empty()) fill(fields_file, paths.fields, fields);
  meshing::SolutionData inside;
  if (meshing::holds_fields(paths.mesh)) {
    inside = solution;
    std::ranges::copy(fields.fields, std::back_inserter(inside.fields));
  }
  const meshing::FormerFile mesh_before(paths.mesh), fields_before(paths.fields);
  // The mesh appears whole or not at all by itself; it is not renamed because some formats name other files
  // in it.
  meshing::write_mesh_contents(paths.mesh, {mesh, inside, names});
  if (fields_file) fields_file->commit();
  if (solution_file) solution_file->commit();
}

void write_mesh_and_fields(const std::string& path, const meshing::MeshData& mesh,
                           const meshing::SolutionData& fields, const meshing::RefNames& names) {
  const bool inside = fields.fields.empty() || meshing::holds_fields(path);
  std::optional<TemporaryFile> beside;
  if (!inside) {
    beside.emplace(meshing::solution_beside(path).string());
    beside->fill([&](const std::string& file) { meshing::write_solution(file, fields); });
  }
  const meshing::FormerFile before(path);
  meshing::write_mesh_contents(path, {mesh, inside ? fields : meshing::SolutionData{}, names});
  if (beside) beside->commit();
}

std::vector<std::string> loss_warnings(const std::string& mesh, const std::string& from,
                                       meshing::ContentCounts input, const meshing::RefNames& names,
                                       bool on_model) {
  std::vector<std::string> warnings;
  if (!on_model && input.on_model > 0)
    warnings.push_back(fmt::format(
        "the input's {} records of vertices on a CAD model are not kept: --geometry makes them anew",
        grouped(input.on_model)));
  if (!on_model) input.on_model = input.models = 0;
  const meshing::RefNames none;
  const meshing::RefNames& in_the_mesh = meshing::has_mapbc_for(from, mesh) ? none : names;
  for (const Dropped& lost : meshing::lost_in(mesh, input, {}, in_the_mesh))
    warnings.push_back(fmt::format("{} does not keep the input's {}{}", mesh,
                                   lost.count > 0 ? grouped(lost.count) + " " : "", lost.what));
  return warnings;
}

void write_text(const std::string& path, const std::string& text) {
  meshing::AtomicFile file{path};
  file.write(text);
  file.commit();
}

}  // namespace weft::tools
