// Writes a file so that it appears whole or not at all: beside the target, then renamed over it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>

namespace weft::meshing {

/// Buffered output to a temporary file in the target's directory. Only `commit` makes the target appear (or
/// replaces it); without it the destructor removes the temporary. Every failure throws
/// InputError(target, "", "cannot write: ..."). A symbolic link as target is followed, not replaced.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t size) {
    if (size > kBufferSize - used_) {
      write_large(data, size);
    } else if (size > 0) {  // an empty vector's data may be null, which memcpy must not get
      std::memcpy(buffer_.get() + used_, data, size);
      used_ += size;
    }
  }
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// The bytes of one number as they lie in memory.
  template <class T>
  void write_value(T value) {
    write(&value, sizeof value);
  }

  /// Bytes written so far: the position of the next one.
  std::uint64_t position() const { return flushed_ + used_; }

  /// Where the bytes go until `commit`: for libraries that write a file by its name. They may replace it.
  const std::filesystem::path& temporary() const { return temporary_; }

  /// Flushes to the disk, closes and renames. Nothing may be written afterwards.
  void commit();

 private:
  static constexpr std::size_t kBufferSize = std::size_t{4} << 20;

  void write_large(const void* data, std::size_t size);
  void flush();
  void write_through(const std::byte* data, std::size_t size);
  [[noreturn]] void fail(int error) const;

  std::filesystem::path target_;     ///< as the user named it, for messages
  std::filesystem::path resolved_;   ///< where it really lies
  std::filesystem::path temporary_;  ///< empty once renamed
  int descriptor_ = -1;
  std::unique_ptr<std::byte[]> buffer_;
  std::size_t used_ = 0;
  std::uint64_t flushed_ = 0;
};

/// While files of a pair are replaced one after the other: one that is left by an exception gets back what
/// was there when this was made (nothing where nothing was), on file systems that have hard links.
class FormerFile {
 public:
  explicit FormerFile(const std::filesystem::path& target);
  ~FormerFile();
  FormerFile(const FormerFile&) = delete;
  FormerFile& operator=(const FormerFile&) = delete;

 private:
  std::filesystem::path target_;
  std::filesystem::path link_;  ///< another name of what was there; empty: there was nothing, or no link
  bool is_new_;
  int exceptions_;
};

}  // namespace weft::meshing
