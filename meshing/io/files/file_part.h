// Writes at given positions of a file that exists already and that others write into at the same time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace weft::meshing {

/// What one writer has of a file: a position, a length and so many bytes, again and again.
using PlacedBytes = std::vector<std::byte>;

/// Where a part of a file goes.
struct PartTarget {
  std::filesystem::path file;
  std::string name;             ///< what messages call the file, which may be a temporary one
  PlacedBytes* kept = nullptr;  ///< where not null the bytes go there, and the file is left alone
};

/// Buffered output to one part of a file after another. Every failure throws InputError(name, "",
/// "cannot write: ...").
class FilePart {
 public:
  explicit FilePart(PartTarget target);
  ~FilePart();
  FilePart(const FilePart&) = delete;
  FilePart& operator=(const FilePart&) = delete;

  /// Where the next byte goes.
  void seek(std::uint64_t position) {
    if (position == this->position()) return;
    flush();
    flushed_ = position;
  }
  std::uint64_t position() const { return flushed_ + used_; }

  void write(const void* data, std::size_t size);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// The bytes of one number as they lie in memory.
  template <class T>
  void write_value(T value) {
    if (sizeof value > kBufferSize - used_) flush();
    std::memcpy(buffer_.get() + used_, &value, sizeof value);
    used_ += sizeof value;
  }

  /// What another writer has kept.
  void write_kept(const PlacedBytes& kept);

  /// Everything to the disk. Nothing may be written afterwards.
  void finish();

 private:
  static constexpr std::size_t kBufferSize = std::size_t{1} << 20;

  void flush();
  void keep_buffer();
  [[noreturn]] void fail(int error) const;

  PartTarget target_;
  int descriptor_ = -1;
  std::unique_ptr<std::byte[]> buffer_;
  std::size_t used_ = 0;
  std::uint64_t flushed_ = 0;  ///< position of the buffer's first byte
};

}  // namespace weft::meshing
