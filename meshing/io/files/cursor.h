// Moves through the bytes of a file, text or binary, and knows what it is reading, for messages.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/files/byte_order.h"
#include "meshing/io/files/text_numbers.h"

namespace weft::meshing {

/// A place in a file that lies in memory. Whatever is not as expected throws InputError(file, entity row,
/// reason); nothing is ever read beyond the end.
class Cursor {
 public:
  Cursor(const std::string& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  /// What is read from here on; rows are counted anew, behind the first `passed` ones.
  void enter(std::string entity, std::uint64_t passed = 0) {
    entity_ = std::move(entity);
    row_ = passed;
  }
  void next_row() { ++row_; }
  std::uint64_t row() const { return row_; }
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_, row_ == 0 ? entity_ : entity_ + " " + std::to_string(row_), reason);
  }

  const std::string& file() const { return file_; }
  std::size_t position() const { return at_; }
  void seek(std::size_t position) { at_ = std::min(position, bytes_.size()); }
  std::size_t remaining() const { return bytes_.size() - at_; }
  std::string_view rest() const { return bytes_.substr(at_); }
  bool at_end() const { return at_ == bytes_.size(); }
  /// Fails unless `count` rows of at least `size` bytes can still follow: bounds what a damaged count makes
  /// us allocate.
  void require(std::uint64_t count, std::uint64_t size) const {
    if (count <= remaining() / size) return;
    fail("the file is truncated, or its count of " + std::to_string(count) + " is wrong: only " +
         std::to_string(remaining()) + " bytes follow");
  }

  // Text

  void set_comment(char c) { comment_ = c; }
  void skip_blanks() {
    while (at_ < bytes_.size()) {
      if (is_space(bytes_[at_])) {
        ++at_;
      } else if (comment_ != 0 && bytes_[at_] == comment_) {
        at_ = std::min(bytes_.find('\n', at_), bytes_.size());
      } else {
        return;
      }
    }
  }
  /// The next word, empty at the end of the file.
  std::string_view word() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_space(bytes_[at_])) ++at_;
    return bytes_.substr(begin, at_ - begin);
  }
  /// The rest of the line without its end; the cursor moves behind it.
  std::string_view line() {
    const std::size_t begin = at_, end = std::min(bytes_.find('\n', at_), bytes_.size());
    at_ = std::min(end + 1, bytes_.size());
    std::string_view text = bytes_.substr(begin, end - begin);
    if (text.ends_with('\r')) text.remove_suffix(1);
    return text;
  }
  std::int64_t text_integer() {
    const std::string_view text = word();
    const auto value = parse_integer(text);
    if (!value) fail("expected an integer, found " + quoted(text));
    return *value;
  }
  double text_real() {
    const std::string_view text = word();
    const auto value = parse_real(text);
    if (!value) fail("expected a number, found " + quoted(text));
    return *value;
  }
  std::uint64_t text_count() {
    const std::int64_t value = text_integer();
    if (value < 0) fail("the count " + std::to_string(value) + " is negative");
    return static_cast<std::uint64_t>(value);
  }
  void expect_word(std::string_view expected) {
    const std::string_view found = word();
    if (found != expected) fail("expected " + std::string(expected) + ", found " + quoted(found));
  }

  // Binary

  void set_swapped(bool swapped) { swapped_ = swapped; }
  template <class T>
  T value() {
    if (remaining() < sizeof(T)) fail("the file is truncated");
    const T value = load<T>(bytes_.data() + at_, swapped_);
    at_ += sizeof(T);
    return value;
  }
  std::string_view take(std::uint64_t size) {
    require(size, 1);
    const std::string_view taken = bytes_.substr(at_, size);
    at_ += size;
    return taken;
  }

  // Checks

  double finite(double coordinate) const {
    if (!std::isfinite(coordinate)) fail("a coordinate is not finite");
    return coordinate;
  }
  /// An index that counts from `first`, as one that counts from 0.
  std::uint32_t index(std::int64_t index, std::int64_t first, std::uint64_t limit) const {
    const std::uint64_t from_zero = static_cast<std::uint64_t>(index) - static_cast<std::uint64_t>(first);
    if (index < first || from_zero >= limit) {
      fail("vertex index " + std::to_string(index) +
           (limit == 0 ? ", but the file has no vertices"
                       : " is out of range " + std::to_string(first) + ".." +
                             std::to_string(first + static_cast<std::int64_t>(limit) - 1)));
    }
    return static_cast<std::uint32_t>(from_zero);
  }
  std::int32_t ref(std::int64_t ref) const {
    if (!std::in_range<std::int32_t>(ref)) {
      fail("reference " + std::to_string(ref) + " does not fit 32 bits");
    }
    return static_cast<std::int32_t>(ref);
  }
  /// The largest number of entities that 32-bit ids with one invalid value can number.
  std::uint64_t entity_count(std::uint64_t count) const {
    constexpr std::uint64_t kMost = 0xFFFFFFFEu;
    if (count > kMost) {
      fail(std::to_string(count) + " entities exceed the limit of " + std::to_string(kMost));
    }
    return count;
  }

 private:
  const std::string& file_;
  std::string_view bytes_;
  std::size_t at_ = 0;
  std::string entity_;
  std::uint64_t row_ = 0;  ///< 1-based; 0: none yet
  char comment_ = 0;
  bool swapped_ = false;
};

}  // namespace weft::meshing
