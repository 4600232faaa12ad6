// The bytes of an array of VTK's XML files as they are stored: raw or base64, also compressed; any range of
// them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "meshing/io/files/input_file.h"

namespace weft::meshing {

/// Where an array's bytes are in a file, and how.
struct VtkStorage {
  std::uint64_t begin = 0, end = 0;  ///< from its header to where its bytes end at the latest
  bool base64 = false, compressed = false, swapped = false, wide_headers = false;
};

/// One array that is no text. Ranges are read without what is before them, but in two cases: in a block of
/// compressed data, and in base64 with blanks in it, they are found by passing over what is before them, from
/// the end of the range that was read last on. Everything that is not as expected throws
/// InputError(file, entity, reason).
class VtkBytes {
 public:
  /// Reads what stands before the data. The file must outlive this.
  VtkBytes(const InputFile& file, std::string entity, const VtkStorage& storage);
  ~VtkBytes();
  VtkBytes(VtkBytes&&) noexcept;

  std::uint64_t size() const { return size_; }
  /// `count` bytes from `first` on, all below size(). What is needed to go on is given up at the end.
  void read(std::uint64_t first, std::uint64_t count, char* out);

 private:
  class Stored;
  class Inflater;

  void read_blocks(std::uint64_t num_blocks, std::uint64_t block_size, std::uint64_t last_size,
                   const VtkStorage& storage);
  std::uint64_t header(bool wide, bool swapped);
  std::uint64_t size_of_block(std::uint64_t block) const;
  [[noreturn]] void fail(const std::string& reason) const;
  [[noreturn]] void fail_truncated() const;

  const std::string& file_;
  std::string entity_;
  std::unique_ptr<Stored> stored_;
  std::unique_ptr<Inflater> inflater_;  ///< of compressed data
  std::uint64_t size_ = 0;
  std::uint64_t block_size_ = 0, last_size_ = 0;  ///< not compressed
  std::vector<std::uint64_t> places_;             ///< where compressed blocks begin, and the last one ends
};

/// Arrays are compressed in blocks of so many bytes; the last one of an array may be shorter.
inline constexpr std::uint64_t kVtkBlockSize = std::uint64_t{1} << 18;
inline std::uint64_t num_vtk_blocks(std::uint64_t bytes) {
  return (bytes + kVtkBlockSize - 1) / kVtkBlockSize;
}
/// One block, compressed.
std::vector<char> vtk_block(std::span<const char> bytes);
/// What stands before the compressed lengths of its blocks, and these before the blocks themselves.
inline std::array<std::uint64_t, 3> vtk_block_header(std::uint64_t bytes) {
  return {num_vtk_blocks(bytes), kVtkBlockSize, bytes % kVtkBlockSize};
}
/// The data of one array in compressed blocks, with their header, as VTK stores them.
std::vector<char> vtk_compressed(std::span<const char> data);

}  // namespace weft::meshing
