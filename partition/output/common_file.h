// A file that all ranks write together.
#pragma once

#include <filesystem>
#include <memory>
#include <utility>

#include "meshing/io/files/atomic_file.h"
#include "partition/communication/agreement.h"
#include "partition/communication/peers.h"

namespace weft::partition {

/// One file that all ranks write: rank 0 creates it and makes it appear.
class CommonFile {
 public:
  explicit CommonFile(std::filesystem::path name) : name_(std::move(name)) {}

  /// All ranks.
  void create(Peers& peers) {
    agree_on(peers, [&] {
      if (peers.rank() == 0) file_ = std::make_unique<meshing::AtomicFile>(name_);
    });
    temporary_ = text_of_first(peers, file_ ? file_->temporary().string() : "");
  }
  const std::filesystem::path& name() const { return name_; }
  const std::filesystem::path& temporary() const { return temporary_; }
  /// On rank 0, when all have written.
  void commit() { file_->commit(); }

 private:
  std::filesystem::path name_, temporary_;
  std::unique_ptr<meshing::AtomicFile> file_;  ///< on rank 0
};

}  // namespace weft::partition
