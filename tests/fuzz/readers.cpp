// libFuzzer target: every reader. The first line of an input is the extension that names its format, the rest
// is the file. Anything but a result or an InputError is a finding; what is read on several ranks must be
// refused on all of them.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "graph/adaptation/checkpoint_files.h"
#include "meshing/base/error.h"
#include "meshing/io/mesh_file.h"
#include "meshing/mesh/structured_box.h"
#include "tests/partition/communication/threads_peers.h"
#include "tools/library/jobs/mesh_checkpoints.h"
#include "tools/library/jobs/sources/shares.h"
#include "tools/weft/jobs/loop.h"
#include "weft/replay.h"

namespace {

namespace fs = std::filesystem;
using weft::InputError;
using weft::graph::adaptation::CheckpointManifest;

constexpr int kRanks = 2;

/// A folder of this process, which is empty when an input has been tried.
const fs::path& folder() {
  static const fs::path path = fs::temp_directory_path() / ("weft-fuzz-" + std::to_string(getpid()));
  return path;
}

template <class Read>
void refusing(const Read& read) {
  try {
    read();
  } catch (const InputError&) {
  }
}

template <class Read>
void on_ranks(const Read& read) {
  for (const std::exception_ptr& thrown : weft::support::run_ranks_caught(kRanks, read))
    if (thrown) refusing([&] { std::rethrow_exception(thrown); });
}

void read_mesh(const std::string& path) {
  refusing([&] {
    weft::MeshFile file = weft::read_mesh_file(path);
    weft::verify(file.mesh);
    if (!file.mesh.tets.empty())
      weft::repair(file.mesh);
    else if (!file.mesh.triangles.empty())
      weft::repair_surface(file.mesh);
  });
  on_ranks([&](weft::partition::Peers& peers) {
    weft::tools::read_mesh_share(peers, path, weft::meshing::OtherVolumes::dropped);
  });
  if (weft::meshing::can_be_in_pieces(path))
    on_ranks([&](weft::partition::Peers& peers) { weft::tools::read_own_fields_share(peers, path); });
}

void read_fields(const std::string& path) {
  weft::partition::MeshSlice whole;
  refusing([&] { whole.num_points = weft::read_fields(path).num_points; });
  on_ranks([&](weft::partition::Peers& peers) {
    weft::partition::MeshSlice slice = whole;
    const auto share = weft::tools::share_of(whole.num_points, peers.rank(), peers.ranks());
    slice.first_point = share.first;
    slice.points.resize(share.count);
    weft::tools::read_fields_share(peers, path, slice, [](std::uint64_t) { return std::string("another"); });
  });
}

void read_pieces(const std::string& path) {
  weft::meshing::write_mesh(folder() / "piece.vtu", weft::meshing::structured_box({}));
  read_mesh(path);
}

/// Names of the boundaries of a mesh without any.
void read_boundary_names(const std::string& path) {
  const fs::path mesh = fs::path(path).replace_extension(".ugrid");
  std::ofstream(mesh) << "3 1 0 0 0 0 0\n0 0 0\n1 0 0\n0 1 0\n1 2 3\n1\n";
  refusing([&] { weft::read_mesh_file(mesh.string()); });
}

/// As marker of a cycle of `weft loop` that is done.
void read_marker(const std::string& path) {
  weft::tools::LoopConfig config;
  config.file = "fuzz";
  config.solver = "false";
  config.folder = folder() / "loop";
  config.mesh = path;  // it is there: no more is asked of it
  fs::create_directories(config.folder / "000");
  fs::copy_file(path, config.folder / "000/done.json");
  fs::copy_file(path, config.folder / "000/solution.solb");
  refusing([&] { weft::tools::run_loop(config, {.quiet = true}); });
}

void read_json(const std::string& path) {
  const std::string page = (folder() / "page.html").string();
  for (const char* format : {"json", "dot", "graphml"}) refusing([&] { weft::graph_text(path, format); });
  weft::ReplayOptions elsewhere;
  elsewhere.ranks = kRanks;
  refusing([&] { weft::replay(path, elsewhere); });
  refusing([&] { weft::write_report_page(path, page); });
  refusing([&] { weft::compare_reports(path, path, page); });
  refusing([&] { weft::tools::read_loop_config(path); });
  read_marker(path);
}

void find_state(std::uint64_t run) {
  std::vector<std::string> warnings;
  refusing([&] { weft::tools::find_state(folder().string(), run, warnings); });
}

/// The file of a rank, as it is, and its bytes as a record that is whole.
void read_checkpoint(const std::string& path) {
  const fs::path place = weft::graph::adaptation::checkpoint_folder(folder(), 1);
  const fs::path file = place / weft::graph::adaptation::rank_file(0);
  fs::create_directories(place);
  const auto find = [&] {
    CheckpointManifest manifest;
    manifest.file_sizes = {fs::file_size(file)};
    std::ofstream(place / weft::graph::adaptation::kManifestName) << manifest.text();
    find_state(manifest.run);
  };
  fs::copy_file(path, file);
  find();
  std::ifstream in(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  weft::graph::adaptation::CheckpointFile record(file);
  record.add({}, {}, std::as_bytes(std::span(bytes)));
  record.commit();
  find();
}

void read_manifest(const std::string& path) {
  const fs::path place = weft::graph::adaptation::checkpoint_folder(folder(), 1);
  fs::create_directories(place);
  fs::copy_file(path, place / weft::graph::adaptation::kManifestName);
  find_state(0);
}

using Reader = void (*)(const std::string& path);
const std::map<std::string_view, Reader> kReaders = {
    {".lb8.ugrid", read_mesh},  {".b8.ugrid", read_mesh},    {".ugrid", read_mesh},
    {".meshb", read_mesh},      {".mesh", read_mesh},        {".msh", read_mesh},
    {".su2", read_mesh},        {".vtu", read_mesh},         {".pvtu", read_pieces},
    {".cgns", read_mesh},       {".stl", read_mesh},         {".ply", read_mesh},
    {".obj", read_mesh},        {".off", read_mesh},         {".solb", read_fields},
    {".sol", read_fields},      {".json", read_json},        {".mapbc", read_boundary_names},
    {".rank", read_checkpoint}, {".manifest", read_manifest}};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::size_t end = input.substr(0, 12).find('\n');
  if (end == std::string_view::npos) return 0;
  const std::string_view extension = input.substr(0, end), contents = input.substr(end + 1);
  const auto reader = kReaders.find(extension);
  if (reader == kReaders.end()) return 0;
  fs::create_directories(folder());
  const std::string path = (folder() / ("input" + std::string(extension))).string();
  std::ofstream(path, std::ios::binary).write(contents.data(), static_cast<std::streamsize>(contents.size()));
  reader->second(path);
  fs::remove_all(folder());
  return 0;
}
