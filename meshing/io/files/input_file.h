// A file to read from: opened with care, read at positions or whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace weft::meshing {

/// A regular file that is read at given positions, never beyond its end. Not mapped: a mapped file that
/// another process truncates would kill this one. Every failure throws InputError naming the file.
class InputFile {
 public:
  explicit InputFile(const std::filesystem::path& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::string& name() const { return name_; }
  std::uint64_t size() const { return size_; }

  void read_at(std::uint64_t position, void* out, std::uint64_t size) const;

 private:
  [[noreturn]] void fail_read(int error) const;

  std::string name_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// All bytes of a file in memory.
class FileBytes {
 public:
  explicit FileBytes(const std::filesystem::path& path);

  const std::string& name() const { return name_; }
  std::string_view bytes() const { return {bytes_.get(), size_}; }
  /// For parsers that work in place.
  char* data() { return bytes_.get(); }

 private:
  std::string name_;
  std::size_t size_ = 0;
  std::unique_ptr<char[]> bytes_;
};

}  // namespace weft::meshing
