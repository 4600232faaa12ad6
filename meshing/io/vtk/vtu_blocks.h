// A VTU file of compressed arrays, by many writers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "meshing/io/files/file_part.h"
#include "meshing/io/files/part_writer.h"

namespace weft::meshing {

/// The bytes of its arrays, cut into the blocks that are compressed one by one: the bytes of a block come
/// from the writers that have rows in it, and one of them compresses it. Once the lengths of all compressed
/// blocks are known each has its place, and the bytes are those of write_vtu().
class VtuBlocks {
 public:
  /// `whole` must outlive it.
  explicit VtuBlocks(const WholeMesh& whole);
  ~VtuBlocks();

  /// Those of all arrays, in the order of the file.
  std::uint64_t count() const { return first_.back(); }
  std::size_t num_arrays() const { return first_.size() - 1; }
  std::size_t array_of(std::uint64_t block) const;
  /// In bytes, not compressed.
  std::uint64_t size(std::uint64_t block) const;

  using Use = std::function<void(std::uint64_t block, std::uint64_t first_byte, std::span<const std::byte>)>;
  /// What a part has of blocks.
  void for_rows(const MeshPart& part, const Use& use) const;
  /// What nobody's part has: corners.
  void for_corners(const Use& use) const;

  static std::vector<char> compressed(std::span<const std::byte> block);

  /// Where compressed blocks go. `of_arrays`: the bytes of all blocks of each array.
  void place(std::span<const std::uint64_t> of_arrays);
  /// By one writer: all that is no block.
  void write_frame(FilePart& out) const;
  /// A compressed block, of which so many bytes are before it in the same array.
  void write_block(FilePart& out, std::uint64_t block, std::uint64_t before,
                   std::span<const char> bytes) const;

 private:
  struct Plan;
  template <class Rows>
  void cut(std::size_t array, std::uint64_t offset, const Rows& rows, const Use& use) const;
  std::uint64_t header_size(std::size_t array) const;

  const WholeMesh& whole_;
  std::unique_ptr<const Plan> plan_;
  std::vector<std::uint64_t> first_;   ///< blocks before each array, and of all
  std::vector<std::uint64_t> places_;  ///< of the arrays, and behind the last
  std::string head_;
};

}  // namespace weft::meshing
