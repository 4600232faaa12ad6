// Files of a rank, and the order in which they become a checkpoint.
#include "graph/adaptation/checkpoint_writer.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "meshing/base/error.h"

namespace weft::graph::adaptation {
namespace {

namespace fs = std::filesystem;

/// Objects and messages both begin with the id of the object that they are, or are for.
engine::ObjectId id_of(const engine::Payload& copy) {
  engine::ObjectId id;
  if (copy.bytes.size() >= sizeof id) std::memcpy(&id, copy.bytes.data(), sizeof id);
  return id;
}

}  // namespace

CheckpointWriter::CheckpointWriter(fs::path folder, double every, std::atomic<bool>* now, int rank, int ranks)
    : folder_(std::move(folder)), every_(every), now_(now), rank_(rank), ranks_(ranks) {}

CheckpointWriter::~CheckpointWriter() {
  if (background_.joinable()) background_.join();
}

void CheckpointWriter::begin(const CheckpointManifest& manifest) {
  manifest_ = manifest;
  manifest_.file_sizes.assign(static_cast<std::size_t>(ranks_), 0);
  constexpr double kFirst = 10;  // seconds
  schedule(std::min(every_, kFirst));
  pending_ = false;
  active_ = true;
}

void CheckpointWriter::schedule(double seconds) {
  interval_ = seconds;
  next_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

void CheckpointWriter::end() {
  active_ = false;
  give_up();
}

void CheckpointWriter::remove_unfinished() const { remove_incomplete(folder_, manifest_.first_number); }

CheckpointsWritten CheckpointWriter::written() const {
  const std::lock_guard lock(mutex_);
  return written_;
}

/// Rank 0 keeps the time; anybody may be asked for one.
bool CheckpointWriter::wanted() {
  if (!active_ || pending_) return false;
  const bool asked = now_ != nullptr && now_->exchange(false);
  const bool due = rank_ == 0 && every_ > 0 && Clock::now() >= next_;
  asked_ |= asked;
  if (rank_ == 0) pending_ = asked || due;
  return asked || due;
}

void CheckpointWriter::object(std::uint64_t epoch, engine::Payload copy) {
  add(epoch, CheckpointRecord::Kind::object, copy);
}

void CheckpointWriter::message(std::uint64_t epoch, engine::Payload copy) {
  add(epoch, CheckpointRecord::Kind::message, copy);
}

/// A rank that has nothing writes a file too: the manifest names all.
void CheckpointWriter::add(std::uint64_t epoch, CheckpointRecord::Kind kind, const engine::Payload& copy) {
  const std::vector<std::byte> packed =
      copy.size() > 0 ? CheckpointFile::pack(copy) : std::vector<std::byte>{};
  const std::lock_guard lock(mutex_);
  try {
    if (epoch != epoch_) {
      file_.reset();
      failure_.clear();
      epoch_ = epoch;
      const fs::path folder = checkpoint_folder(folder_, manifest_.first_number + epoch);
      fs::create_directories(folder);
      file_ = std::make_unique<CheckpointFile>(folder / rank_file(rank_));
    }
    if (file_ && copy.size() > 0) file_->add(kind, id_of(copy), packed);
  } catch (const std::exception& error) {
    file_.reset();
    failure_ = error.what();
  }
}

template <class Work>
void CheckpointWriter::in_background(Work work) {
  if (background_.joinable()) background_.join();
  background_ = std::thread(std::move(work));
}

void CheckpointWriter::close(std::uint64_t epoch) {
  add(epoch, CheckpointRecord::Kind::object, {});
  stored_ = -1;
  if (rank_ != 0) asked_ = false;
  in_background([this] {
    const std::lock_guard lock(mutex_);
    try {
      if (file_) file_->commit();
    } catch (const std::exception& error) {
      failure_ = error.what();
    }
    file_.reset();
    stored_ = failure_.empty() ? 1 : 0;
  });
}

std::optional<bool> CheckpointWriter::stored(std::uint64_t) {
  const int stored = stored_;
  if (stored < 0) return {};
  return stored == 1;
}

bool CheckpointWriter::wait_until_stored() {
  if (background_.joinable()) background_.join();
  return stored_ == 1;
}

void CheckpointWriter::finish(std::uint64_t epoch, bool whole) {
  pending_ = asked_ = false;
  schedule(std::min(every_, 2 * interval_));
  const fs::path folder = checkpoint_folder(folder_, manifest_.first_number + epoch);
  if (!whole) return fail("a rank could not write its part of " + folder.string());
  in_background([this, folder] {
    try {
      write_manifest(folder);
    } catch (const std::exception& error) {
      fail(error.what());
    }
  });
}

void CheckpointWriter::fail(const std::string& why) {
  const std::lock_guard lock(mutex_);
  written_.failure = failure_.empty() ? why : failure_;
}

void CheckpointWriter::write_manifest(const fs::path& folder) {
  CheckpointManifest manifest = manifest_;
  std::uint64_t bytes = 0;
  for (int r = 0; r < ranks_; ++r)
    bytes += manifest.file_sizes[static_cast<std::size_t>(r)] = fs::file_size(folder / rank_file(r));
  sync_folder(folder);
  meshing::AtomicFile file(folder / kManifestName);
  file.write(manifest.text());
  file.commit();
  sync_folder(folder);
  sync_folder(folder_);
  remove_old_checkpoints(folder_, kKept);
  const std::lock_guard lock(mutex_);
  ++written_.written;
  written_.bytes = bytes;
  written_.failure.clear();
}

/// Who has asked for one still wants it.
void CheckpointWriter::give_up() {
  if (background_.joinable()) background_.join();
  if (std::exchange(asked_, false)) now_->store(true);
  pending_ = false;
  const std::lock_guard lock(mutex_);
  file_.reset();
}

}  // namespace weft::graph::adaptation
