// Models come through the part of weft that knows OpenCASCADE.
#include "meshing/cad/load_model.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <string_view>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/base/load_part.h"
#include "meshing/io/files/child_process.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 7> kExtensions = {".step", ".stp", ".iges", ".igs",
                                                         ".brep", ".brp", ".egads"};

const CadReader& reader(const std::string& path) {
  static const Part part = load_part("libweft_cad.so", kCadEntryName, kCadInterface);
  if (part.offer) return *static_cast<const CadReader*>(part.offer);
  throw InputError(path, "",
                   part.reason.empty()
                       ? "reading CAD models needs OpenCASCADE, and this weft was built without: install "
                         "libocct-data-exchange-dev (Debian, Ubuntu) and build weft again"
                       : "OpenCASCADE cannot be loaded (" + part.reason +
                             "): install libocct-data-exchange-7.6 (Debian, Ubuntu)");
}

std::string lower_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension;
}

/// A file that vanishes at the end of its life.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::vector<std::uint8_t>& bytes) {
    std::string name = (fs::temp_directory_path() / "weft-XXXXXX.egads").string();
    const int descriptor = mkstemps(name.data(), 6);
    if (descriptor < 0) throw InputError(name, "", "cannot be created");
    close(descriptor);
    path_ = name;
    std::ofstream file(path_, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (file.flush()) return;
    ::unlink(path_.c_str());
    throw InputError(path_, "", "cannot be written: is the disk full?");
  }
  ~TemporaryFile() { ::unlink(path_.c_str()); }  // as a path it would take memory
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// An empty one; none where no file can be made.
std::optional<TemporaryFile> temporary_file() {
  try {
    return std::optional<TemporaryFile>(std::in_place, std::vector<std::uint8_t>());
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// The text of an InputError without the file's name.
std::string without_name(const std::string& text, const std::string& file) {
  const std::string head = file + ": ";
  return text.starts_with(head) ? text.substr(head.size()) : text;
}

/// Seconds for a file: of the slowest known, a face with 2,500 holes, it takes ten a megabyte.
unsigned patience_for(const std::string& path) {
  constexpr double kLeast = 120, kOfMegabyte = 60;
  std::error_code failed;
  const std::uintmax_t bytes = fs::file_size(path, failed);
  return static_cast<unsigned>(kLeast + (failed ? 0 : kOfMegabyte * 1e-6 * static_cast<double>(bytes)));
}

/// Who holds it is the only one of this library within OpenCASCADE: a process that is begun meanwhile would
/// wait for ever for what another thread had locked.
std::mutex& in_use() {
  static std::mutex mutex;
  return mutex;
}

/// Damaged files crash OpenCASCADE's readers, or keep them busy for ever: another process reads, and hands
/// the shapes over, which takes little time.
std::shared_ptr<const GeometryModel> read_model(const std::string& path) {
  const CadReader& cad = reader(path);
  const std::scoped_lock lock(in_use());
  const std::optional<TemporaryFile> kept = temporary_file();
  const unsigned patience = patience_for(path);
  const auto issue = issue_of_child(
      [&] {
        cad.keep(path, kept ? kept->path() : "");
        return std::string();
      },
      patience);
  if (!issue)
    throw InputError(path, "",
                     "the file is damaged: OpenCASCADE crashes on it, or does not end within " +
                         std::to_string(patience) + " seconds");
  if (!issue->empty()) throw InputError(path, "", without_name(*issue, path));
  if (kept)
    if (auto model = cad.read_kept(path, kept->path())) return model;
  return cad.read(path);
}

}  // namespace

bool is_model_name(const std::string& path) {
  return std::ranges::find(kExtensions, lower_extension(path)) != kExtensions.end();
}

std::string model_extensions() { return ".step, .stp, .iges, .igs, .brep, .brp and .egads"; }

std::shared_ptr<const GeometryModel> load_model(const std::string& path) {
  if (!is_model_name(path))
    throw InputError(path, "", "is no CAD model by its extension, known here are " + model_extensions());
  if (!fs::is_regular_file(path)) throw InputError(path, "", "there is no such file");
  return read_model(path);
}

std::shared_ptr<const GeometryModel> load_carried_model(const Association& association,
                                                        const std::string& mesh_name) {
  if (association.model.empty())
    throw InputError(mesh_name, "ByteFlow", "the mesh carries no CAD model: name one with --geometry");
  reader(mesh_name);  // whether there is one, before all else
  const TemporaryFile file(association.model);
  try {
    return read_model(file.path());
  } catch (const InputError& error) {
    throw InputError(
        mesh_name, "ByteFlow",
        "the CAD model that the mesh carries cannot be read: " + without_name(error.what(), file.path()));
  }
}

MeshData tessellate_model(const std::string& path, const GeometryModel& model,
                          const CadTessellation& options) {
  const std::scoped_lock lock(in_use());
  return reader(path).tessellate(model, options);
}

}  // namespace weft::meshing
