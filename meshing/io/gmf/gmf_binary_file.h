// Binary GMF files: the chain of keywords, and the rows of a section.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/byte_order.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/gmf/gmf_format.h"

namespace weft::meshing::gmf {

inline std::int64_t load_int(const std::byte* from, std::size_t size, bool swapped) {
  if (size == 8) return load<std::int64_t>(from, swapped);
  return load<std::int32_t>(from, swapped);
}

inline double load_real(const std::byte* from, std::size_t size, bool swapped) {
  if (size == 8) return load<double>(from, swapped);
  return load<float>(from, swapped);
}

/// Reads rows of one section in order, through a buffer.
class BinaryRows {
 public:
  /// Rows of `reals` reals and then `indices` integers each. Throws InputError unless all rows of the section
  /// fill it.
  BinaryRows(const InputFile& file, const Encoding& encoding, const Section& section, std::size_t reals,
             std::size_t indices, RowRange range);

  void begin_row() {
    ++row_;
    if (next_ == filled_) refill();
  }
  double real() { return load_real(advance(encoding_.real_size), encoding_.real_size, encoding_.swapped); }
  std::int64_t integer() {
    return load_int(advance(encoding_.index_size()), encoding_.index_size(), encoding_.swapped);
  }
  void finish() const {}

  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_.name(), std::string(section_.keyword->name) + " " + std::to_string(row_), reason);
  }

 private:
  static constexpr std::uint64_t kBufferSize = std::uint64_t{1} << 20;

  const std::byte* advance(std::size_t size) {
    const std::byte* at = buffer_.get() + next_;
    next_ += size;
    return at;
  }
  void refill() {
    filled_ = std::min(capacity_, end_ - position_);
    file_.read_at(position_, buffer_.get(), filled_);
    position_ += filled_;
    next_ = 0;
  }

  const InputFile& file_;
  const Encoding encoding_;
  const Section section_;
  const std::uint64_t row_size_;
  std::unique_ptr<std::byte[]> buffer_;
  std::uint64_t capacity_ = 0, filled_ = 0, next_ = 0;  ///< of the buffer; whole rows
  std::uint64_t position_, end_;                        ///< in the file: of what is not read yet
  std::uint64_t row_;                                   ///< 1-based, for messages
};

/// A binary file: its header, and its chain of keywords cut into sections.
class BinaryFile {
 public:
  explicit BinaryFile(const std::filesystem::path& path);
  /// A file whose layout is known already. Throws InputError when its size is another now.
  BinaryFile(const std::filesystem::path& path, const GmfLayout& layout);

  const std::string& name() const { return file_.name(); }
  const GmfLayout& layout() const { return layout_; }
  BinaryRows rows(const Section& section, std::size_t reals, std::size_t indices, RowRange range) const {
    return BinaryRows(file_, layout_.encoding, section, reals, indices, range);
  }

  /// All bytes of a section behind its count.
  std::vector<std::uint8_t> bytes(const Section& section) const;

  /// The types of the fields in a solution section; moves the section's begin to its first row.
  std::vector<std::int64_t> take_solution_types(Section& section) const;

 private:
  std::int64_t int_at(std::uint64_t position, std::size_t size) const;
  std::optional<std::uint64_t> scan_keyword(std::uint64_t position);
  void note_keyword(std::int64_t code, std::uint64_t begin, std::uint64_t end);
  void note_value(std::int64_t code, std::int64_t value);

  InputFile file_;
  GmfLayout layout_;
  bool has_dimension_ = false;
};

}  // namespace weft::meshing::gmf
