// A file that all ranks write together.
#pragma once

#include <filesystem>
#include <memory>
#include <utility>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/file_part.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// One file that all ranks write: rank 0 creates it and makes it appear. Of very many ranks some write for
/// others too (Peers::most_writers): a file system serves few writers better, and each the rows of
/// neighbours.
class CommonFile {
 public:
  explicit CommonFile(std::filesystem::path name) : name_(std::move(name)) {}

  /// All ranks.
  void create(Peers& peers);
  /// Whether this rank has created it.
  bool is_mine() const { return file_ != nullptr; }
  const std::filesystem::path& name() const { return name_; }
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Where this rank's part goes.
  meshing::PartTarget target() { return {temporary_, name_.string(), writes_ ? nullptr : &kept_}; }
  /// All ranks, when all have written to their targets. Throws what agree_on() throws.
  void deliver(Peers& peers);
  /// On rank 0, when all has been delivered.
  void commit() { file_->commit(); }

 private:
  std::filesystem::path name_, temporary_;
  std::unique_ptr<meshing::AtomicFile> file_;  ///< on rank 0
  bool writes_ = true;
  meshing::PlacedBytes kept_;  ///< of a rank for which another one writes
};

}  // namespace weft::partition
