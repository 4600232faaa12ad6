// Files of a rank, and the order in which they become a checkpoint.
#include "graph/adaptation/checkpoint_writer.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <system_error>
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

CheckpointWriter::CheckpointWriter(fs::path folder, double every, std::atomic<bool>* now,
                                   const std::atomic<bool>* interrupt, int rank, int ranks)
    : folder_(std::move(folder)),
      every_(every),
      now_(now),
      interrupt_(interrupt),
      rank_(rank),
      ranks_(ranks) {}

CheckpointWriter::~CheckpointWriter() {
  if (background_.joinable()) background_.join();
}

void CheckpointWriter::lock() {
  constexpr std::chrono::seconds kPatience(60);  // twice what a rank needs to see that another is dead
  if (rank_ == 0) lock_.emplace(folder_, kPatience);
}

void CheckpointWriter::begin(const CheckpointManifest& manifest) {
  manifest_ = manifest;
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
  if (background_.joinable() && !interrupted()) background_.join();
}

void CheckpointWriter::remove_unfinished() const { remove_incomplete(folder_, manifest_.first_number); }

CheckpointsWritten CheckpointWriter::written() const {
  const std::lock_guard lock(mutex_);
  return written_;
}

/// Rank 0 keeps the time; anybody may be asked for one.
bool CheckpointWriter::wanted() {
  if (!active_ || pending_ || interrupted()) return false;
  const bool asked = now_ != nullptr && now_->exchange(false);
  const bool due = rank_ == 0 && every_ > 0 && Clock::now() >= next_;
  asked_ |= asked;
  if (rank_ == 0) pending_ = asked || due;
  return asked || due;
}

void CheckpointWriter::object(std::uint64_t epoch, engine::Payload copy) {
  add(epoch, CheckpointRecord::Kind::object, copy);
}

/// Under the scheduler's lock.
void CheckpointWriter::message(std::uint64_t epoch, engine::Payload copy) {
  const std::lock_guard lock(messages_.mutex);
  if (epoch < messages_.epoch) return;
  if (epoch > messages_.epoch) {
    messages_.all.clear();
    messages_.lost = false;
    messages_.epoch = epoch;
  }
  try {
    messages_.all.push_back(std::move(copy));
  } catch (const std::bad_alloc&) {
    messages_.lost = true;
  }
}

/// Copies of an epoch that has been given up may come late.
void CheckpointWriter::add(std::uint64_t epoch, CheckpointRecord::Kind kind, const engine::Payload& copy) {
  std::unique_lock lock(mutex_, std::defer_lock);
  try {
    const std::vector<std::byte> packed = CheckpointFile::pack(copy);
    lock.lock();
    if (epoch < epoch_) return;
    begin_epoch(epoch);
    open_file();
    if (file_) file_->add(kind, id_of(copy), packed);
  } catch (const std::exception& error) {
    if (!lock) lock.lock();
    if (epoch < epoch_) return;
    begin_epoch(epoch);
    file_.reset();
    failure_ = error.what();
  }
}

void CheckpointWriter::begin_epoch(std::uint64_t epoch) {
  if (epoch == epoch_) return;
  file_.reset();
  failure_.clear();
  epoch_ = epoch;
}

void CheckpointWriter::open_file() {
  if (file_ || !failure_.empty() || epoch_ == given_up_) return;
  const fs::path folder = checkpoint_folder(folder_, manifest_.first_number + epoch_);
  fs::create_directories(folder);
  file_ = std::make_unique<CheckpointFile>(folder / rank_file(rank_));
}

/// After what is in the background already.
template <class Work>
void CheckpointWriter::in_background(Work work) {
  const auto before = std::make_shared<std::thread>(std::move(background_));
  const auto run = [before, work] {
    if (before->joinable()) before->join();
    work();
  };
  try {
    background_ = std::thread(run);
  } catch (const std::system_error&) {  // there is no thread to be had
    run();
  }
}

bool CheckpointWriter::add_messages(std::uint64_t epoch) {
  std::vector<engine::Payload> all;
  {
    const std::lock_guard lock(messages_.mutex);
    if (messages_.epoch == epoch) {
      if (messages_.lost) return false;
      all.swap(messages_.all);
    }
  }
  for (const engine::Payload& copy : all) add(epoch, CheckpointRecord::Kind::message, copy);
  return true;
}

/// A rank that has nothing writes a file too: the manifest names all.
bool CheckpointWriter::store(std::uint64_t epoch) {
  if (!add_messages(epoch)) return false;
  try {
    std::unique_ptr<CheckpointFile> file;
    {
      const std::lock_guard lock(mutex_);
      if (epoch < epoch_) return false;
      begin_epoch(epoch);
      open_file();
      file = std::move(file_);
    }
    if (!file) return false;
    file->commit();
    return true;
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    if (epoch == epoch_) failure_ = error.what();
    return false;
  }
}

/// Nobody's work had been cut short when it was copied here, if there is no interruption now. Else the
/// checkpoint never becomes one.
void CheckpointWriter::close(std::uint64_t epoch) {
  if (interrupted()) return;
  in_background([this, epoch] { stored_ = 2 * epoch + (store(epoch) ? 0 : 1); });
}

std::optional<bool> CheckpointWriter::stored(std::uint64_t epoch) {
  const std::uint64_t stored = stored_;
  if (stored / 2 != epoch) return {};
  if (rank_ != 0) asked_ = false;
  return stored % 2 == 0;
}

bool CheckpointWriter::wait_until_stored(std::uint64_t epoch) {
  if (background_.joinable()) background_.join();
  return stored(epoch).value_or(false);
}

void CheckpointWriter::finish(std::uint64_t epoch, bool whole) {
  pending_ = asked_ = false;
  schedule(std::min(every_, 2 * interval_));
  const fs::path folder = checkpoint_folder(folder_, manifest_.first_number + epoch);
  if (!whole) fail("a rank could not write its part of " + folder.string());
  in_background([this, folder, whole] {
    try {
      if (whole) return write_manifest(folder);
    } catch (const std::exception& error) {
      fail(error.what());
    }
    remove_checkpoint(folder);  // what the others have written of it takes room
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
    bytes += manifest.file_sizes.emplace_back(fs::file_size(folder / rank_file(r)));
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
  if (std::exchange(asked_, false)) now_->store(true);
  pending_ = false;
  const std::lock_guard lock(mutex_);
  file_.reset();
  given_up_ = epoch_;
}

}  // namespace weft::graph::adaptation
