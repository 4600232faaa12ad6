// Hashes, and states on their way to the disk and back.
#include "tools/library/jobs/mesh_checkpoints.h"

#include <bit>
#include <exception>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "engine/base/serialize.h"
#include "graph/adaptation/checkpoint_files.h"
#include "meshing/base/error.h"
#include "tools/library/jobs/resources/stopwatch.h"
#include "tools/library/version.h"

namespace weft::tools {
namespace {

namespace fs = std::filesystem;
using graph::adaptation::CheckpointManifest;
using graph::adaptation::CheckpointPlace;
using meshing::InputError;

/// Other states than those of another form.
constexpr std::uint64_t kForm = 1;
/// In the manifest, where a run in subdomains has their number.
constexpr std::uint32_t kOneMesh = 0;

class Hash {
 public:
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.data(), values.size() * sizeof(T));
  }
  void add(const std::string& text) { add(text.data(), text.size()); }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(std::uint64_t value) { add(&value, sizeof value); }
  std::uint64_t value() const { return value_; }

 private:
  void add(const void* data, std::size_t size) { value_ = graph::adaptation::hash_bytes(data, size, value_); }

  std::uint64_t value_ = kForm;
};

void add(Hash& hash, const meshing::MeshData& mesh) {
  hash.add(mesh.points);
  hash.add(mesh.point_refs);
  hash.add(mesh.tets);
  hash.add(mesh.tet_refs);
  hash.add(mesh.triangles);
  hash.add(mesh.triangle_refs);
  hash.add(mesh.edges);
  hash.add(mesh.edge_refs);
  for (const auto* marked :
       {&mesh.corners, &mesh.required_points, &mesh.ridges, &mesh.required_edges, &mesh.required_triangles})
    hash.add(*marked);
  hash.add(mesh.association.model);
}

void add(Hash& hash, const Options& options) {
  hash.add(options.geometry.ridge_angle);
  hash.add(options.geometry.hausd);
  hash.add(options.geometry.model);
  hash.add(options.geometry.model_scale);
  const AllowedOperations& allowed = options.allowed;
  hash.add(std::uint64_t{allowed.insert} | std::uint64_t{allowed.swap} << 1 |
           std::uint64_t{allowed.move} << 2);
}

meshing::AdaptationState read_state(const CheckpointPlace& place) {
  const fs::path file = place.folder / graph::adaptation::rank_file(0);
  const graph::adaptation::CheckpointReader reader(file);
  if (reader.index().size() != 1) throw InputError(file.string(), "", "is no state of one mesh");
  try {
    return engine::unpacked<meshing::AdaptationState>(reader.read(reader.index()[0]));
  } catch (const engine::UnpackError& error) {
    throw InputError(file.string(), "", std::string("is no state of one mesh: ") + error.what());
  }
}

}  // namespace

std::uint64_t hash_of_run(const meshing::MeshData& input, const meshing::MeshData& background,
                          const meshing::LogMetricField& metric, const Options& options) {
  Hash hash;
  hash.add(std::string(kVersion) + " " + std::to_string(meshing::kOrderOfPasses));
  add(hash, input);
  if (&background != &input) add(hash, background);
  hash.add(metric);
  add(hash, options);
  return hash.value();
}

MeshCheckpoints::MeshCheckpoints(const CheckpointOptions& options, std::uint64_t run)
    : writer_(options.folder, options.every, options.now, nullptr, 0, 1) {
  CheckpointManifest manifest;
  manifest.run = run;
  manifest.subdomains = kOneMesh;
  writer_.lock();
  manifest.first_number = graph::adaptation::last_number(options.folder);
  writer_.begin(manifest);
}

MeshCheckpoints::~MeshCheckpoints() {
  if (background_.joinable()) background_.join();
}

bool MeshCheckpoints::wanted() { return !busy_ && writer_.wanted(); }

void MeshCheckpoints::keep(const std::function<meshing::AdaptationState()>& copy) {
  if (background_.joinable()) background_.join();
  Stopwatch watch;
  ++epoch_;
  busy_ = true;
  try {
    background_ = std::thread([this, state = copy()]() mutable {
      write(std::move(state));
      busy_ = false;
    });
  } catch (const std::exception&) {  // no memory for the copy, or no thread
    finish_epoch(false);
    busy_ = false;
  }
  seconds_ += watch.lap();
}

void MeshCheckpoints::write(meshing::AdaptationState&& state) {
  bool whole = false;
  try {
    writer_.object(epoch_, engine::packed(std::move(state)));
    writer_.close(epoch_);
    whole = writer_.wait_until_stored(epoch_);
  } catch (const std::exception&) {  // no memory for what is packed
  }
  finish_epoch(whole);
}

/// Where there is no memory even for the words that say so, a flag does.
void MeshCheckpoints::finish_epoch(bool whole) {
  lost_ = false;
  try {
    writer_.finish(epoch_, whole);
  } catch (const std::exception&) {
    lost_ = true;
  }
}

void MeshCheckpoints::finish(CheckpointStats& stats) {
  if (background_.joinable()) background_.join();
  writer_.end();
  writer_.remove_unfinished();
  const graph::adaptation::CheckpointsWritten written = writer_.written();
  stats.written = written.written;
  stats.bytes = static_cast<double>(written.bytes);
  stats.seconds = seconds_;
  stats.failure = lost_ ? "there was no memory" : written.failure;
}

std::optional<FoundState> find_state(const std::string& folder, std::uint64_t run,
                                     std::vector<std::string>& warnings) {
  std::exception_ptr first;
  for (const CheckpointPlace& place : graph::adaptation::find_checkpoints(folder)) {
    if (place.manifest.subdomains != kOneMesh)
      throw InputError(place.folder.string(), "", "is a checkpoint of a run in subdomains, and this is none");
    if (place.manifest.run != run)
      throw InputError(
          place.folder.string(), "",
          "is a checkpoint of another run: the input, the metric or an option is not the same, or "
          "the program is another");
    try {
      return FoundState{read_state(place), place.folder.string()};
    } catch (const InputError& error) {
      if (!first) first = std::current_exception();
      warnings.emplace_back(error.what());
    }
  }
  if (first) std::rethrow_exception(first);
  return {};
}

}  // namespace weft::tools
