// A mesh file of compressed blocks that all ranks write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include "meshing/io/vtk/vtu_blocks.h"
#include "partition/communication/even_shares.h"
#include "partition/communication/peers.h"
#include "partition/output/common_file.h"
#include "partition/output/common_text.h"

namespace weft::partition {

/// Until it can appear. Each rank compresses as many blocks as any other, ranges of the file.
class CommonBlocks {
 public:
  /// `for_parts` as in CommonText; `whole` outlives the object.
  CommonBlocks(const std::filesystem::path& name, const meshing::WholeMesh& whole,
               std::function<void(const PartAction&)> for_parts)
      : file_(name), blocks_(whole), for_parts_(std::move(for_parts)) {}

  /// All ranks.
  void create(Peers& peers);
  /// This rank's blocks. Throws meshing::InputError.
  void write();
  /// All ranks, when all have written.
  void deliver(Peers& peers) { file_.deliver(peers); }
  /// On rank 0, when all has been delivered.
  void commit() { file_.commit(); }

 private:
  std::vector<Bytes> pieces_of_blocks(const Peers& peers, const EvenShares& shares) const;
  void compress(std::vector<Bytes> pieces, std::uint64_t count);

  CommonFile file_;
  meshing::VtuBlocks blocks_;
  std::function<void(const PartAction&)> for_parts_;
  std::uint64_t first_ = 0;                    ///< block of this rank
  std::vector<std::vector<char>> compressed_;  ///< from it on
  std::vector<std::uint64_t> before_;          ///< by array: bytes of other ranks before this one's
};

}  // namespace weft::partition
