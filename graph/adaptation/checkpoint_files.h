// Checkpoints on disk: a folder of numbered folders, each with a file of every rank that took part and, as
// the last that is written, a manifest. Without its manifest a checkpoint does not exist.
//
//   DIR/7/rank-0  rank-1 ...   records one after another, then their index
//   DIR/7/complete             the manifest
//
// Files appear under their names when they are whole and on the disk. Records carry a hash each.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/rank.h"
#include "engine/base/serialize.h"
#include "meshing/io/files/atomic_file.h"

namespace weft::graph::adaptation {

/// What a checkpoint is of. It can be gone on from by a run for which all but `home_ranks` is the same.
struct CheckpointManifest {
  std::uint64_t run = 0;  ///< hash of the input, its metric, the plan and the program
  std::uint32_t subdomains = 0;
  int home_ranks = 1;                     ///< AdaptationPlan::home_ranks
  std::uint64_t first_number = 0;         ///< folders of this run's checkpoints count from here; not written
  std::vector<std::uint64_t> file_sizes;  ///< of rank-0, rank-1 ...

  std::string text() const;
  /// Empty for a text that is none.
  static std::optional<CheckpointManifest> parse(const std::string& text);
};

/// One checkpoint that is complete.
struct CheckpointPlace {
  std::uint64_t number = 0;
  std::filesystem::path folder;
  CheckpointManifest manifest;
};

/// The complete checkpoints of a folder whose files are there with the sizes that the manifest says, the
/// latest first.
std::vector<CheckpointPlace> find_checkpoints(const std::filesystem::path& folder);
/// The highest number of any, complete or not; 0: there is none.
std::uint64_t last_number(const std::filesystem::path& folder);
/// Removes all but the `keep` latest that are complete, and older ones that never became so. Nothing but
/// files of checkpoints, wherever they are, and folders that are empty then.
void remove_old_checkpoints(const std::filesystem::path& folder, std::size_t keep);

/// Removes those with numbers above `after` that are not complete.
void remove_incomplete(const std::filesystem::path& folder, std::uint64_t after);

/// One, complete or not.
void remove_checkpoint(const std::filesystem::path& folder);

/// Keeps other runs from writing checkpoints into a folder, which it makes. Where it cannot be locked it is
/// not. Throws meshing::InputError when another still does after `patience`: processes of a run that was
/// killed may take a while to notice.
class CheckpointLock {
 public:
  CheckpointLock(const std::filesystem::path& folder, std::chrono::milliseconds patience);
  ~CheckpointLock();
  CheckpointLock(const CheckpointLock&) = delete;
  CheckpointLock& operator=(const CheckpointLock&) = delete;

 private:
  int descriptor_ = -1;
};

std::filesystem::path checkpoint_folder(const std::filesystem::path& folder, std::uint64_t number);
std::string rank_file(int rank);
inline constexpr const char* kManifestName = "complete";

struct CheckpointRecord {
  enum class Kind : std::uint64_t { object, message };  ///< as wide as the rest: nothing is padded
  Kind kind = Kind::object;
  engine::ObjectId object;  ///< it, or that the message is for
  std::uint64_t begin = 0, size = 0, hash = 0;
};

/// Writes one rank's file. Throws meshing::InputError.
class CheckpointFile {
 public:
  explicit CheckpointFile(const std::filesystem::path& path) : file_(path) {}
  /// A payload as it is written: packed. To be made outside of locks.
  static std::vector<std::byte> pack(const engine::Payload& payload);
  void add(CheckpointRecord::Kind kind, engine::ObjectId object, std::span<const std::byte> packed);
  /// Makes it appear, on the disk.
  void commit();

 private:
  meshing::AtomicFile file_;
  std::vector<CheckpointRecord> index_;
};

/// Reads it. Throws meshing::InputError, which names the file, for one that is damaged.
class CheckpointReader {
 public:
  explicit CheckpointReader(const std::filesystem::path& path);
  ~CheckpointReader();
  CheckpointReader(const CheckpointReader&) = delete;
  CheckpointReader& operator=(const CheckpointReader&) = delete;

  const std::vector<CheckpointRecord>& index() const { return index_; }
  engine::Payload read(const CheckpointRecord& record) const;

 private:
  void read_at(std::uint64_t begin, void* to, std::size_t size) const;
  [[noreturn]] void refuse(const char* why) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::vector<CheckpointRecord> index_;
};

/// Makes names in a folder last through a power cut.
void sync_folder(const std::filesystem::path& folder);

/// A hash of bytes, eight at a time.
std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t seed);

}  // namespace weft::graph::adaptation
