// Moves through the bytes of a file, text or binary, and knows what it is reading, for messages.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/files/byte_order.h"
#include "meshing/io/files/coordinates.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/text_numbers.h"

namespace weft::meshing {

/// A place in a file that lies in memory, or of which a window of some MB does: it moves on with the place,
/// and what has been returned of it is valid until the next call. Whatever is not as expected throws
/// InputError(file, entity row, reason); nothing is ever read beyond the end.
class Cursor {
 public:
  Cursor(const std::string& file, std::string_view bytes)
      : file_(file), bytes_(bytes), file_size_(bytes.size()) {}
  /// By windows; `source` must outlive the cursor.
  explicit Cursor(const InputFile& source, std::uint64_t position = 0, std::uint64_t end = ~std::uint64_t{0})
      : file_(source.name()), source_(&source), file_size_(std::min(source.size(), end)) {
    seek(position);
  }
  Cursor(const Cursor&) = delete;
  Cursor& operator=(const Cursor&) = delete;

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
  std::size_t position() const { return window_ + at_; }
  void seek(std::size_t position) {
    if (source_ && (position < window_ || position > window_ + bytes_.size())) {
      window_ = std::min<std::size_t>(position, file_size_);
      bytes_ = {};
      at_ = 0;
    } else {
      at_ = std::min(position - window_, bytes_.size());
    }
  }
  std::size_t remaining() const { return file_size_ - position(); }
  /// So many bytes of what follows, or all where it is less.
  std::string_view ahead(std::uint64_t size) {
    hold(std::min<std::uint64_t>(size, remaining()));
    return bytes_.substr(at_, size);
  }
  /// All that follows; of a file in memory only.
  std::string_view rest() const { return bytes_.substr(at_); }
  bool at_end() const { return position() == file_size_; }
  /// Moves to where this text is next; stays, and returns false, where it is not.
  bool find(std::string_view text);
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
    while (at_ < bytes_.size() || fetch(at_)) {
      if (is_space(bytes_[at_])) {
        ++at_;
      } else if (comment_ != 0 && bytes_[at_] == comment_) {
        at_ = line_end();
      } else {
        return;
      }
    }
  }
  /// The next word, empty at the end of the file.
  std::string_view word() {
    skip_blanks();
    std::size_t end = at_;
    while ((end < bytes_.size() || fetch(end)) && !is_space(bytes_[end]) && !begins_comment(bytes_[end]))
      ++end;
    const std::size_t begin = std::exchange(at_, end);
    return bytes_.substr(begin, end - begin);
  }
  /// The rest of the line without its end; the cursor moves behind it.
  std::string_view line() {
    const std::size_t end = line_end(), begin = at_;  // in this order: the window may move
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
    hold(sizeof(T));
    const T value = load<T>(bytes_.data() + at_, swapped_);
    at_ += sizeof(T);
    return value;
  }
  std::string_view take(std::uint64_t size) {
    require(size, 1);
    hold(size);
    const std::string_view taken = bytes_.substr(at_, size);
    at_ += size;
    return taken;
  }

  // Checks

  void set_coordinates(Coordinates wanted) { coordinates_ = wanted; }
  /// Fails where it is none of those wanted: by default, where it is not finite.
  double coordinate(double value) const {
    if (!passes(value, coordinates_)) fail("a coordinate is not finite");
    return value;
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
  bool begins_comment(char c) const { return comment_ != 0 && c == comment_; }
  /// The end of this line in `bytes_`.
  std::size_t line_end() {
    std::size_t end = at_;
    while ((end = std::min(bytes_.find('\n', end), bytes_.size())) == bytes_.size() && fetch(end)) {
    }
    return end;
  }
  /// Makes the window go on behind its end, `at` being a place in it behind at_; what is before at_ is given
  /// up, and both move. False at the end of the file.
  bool fetch(std::size_t& at) { return window_ + bytes_.size() < file_size_ && read_on(at); }
  bool read_on(std::size_t& at);
  /// So many bytes from here on, which the file has, are in the window.
  void hold(std::uint64_t size) {
    for (std::size_t at = at_; bytes_.size() - at_ < size;) fetch(at);
  }

  const std::string& file_;
  const InputFile* source_ = nullptr;
  std::string buffer_;        ///< of a window
  std::string_view bytes_;    ///< the file or the window
  std::uint64_t file_size_;   ///< bytes
  std::uint64_t window_ = 0;  ///< where bytes_ begin in the file
  std::size_t at_ = 0;        ///< in bytes_
  std::string entity_;
  std::uint64_t row_ = 0;  ///< 1-based; 0: none yet
  char comment_ = 0;
  bool swapped_ = false;
  Coordinates coordinates_ = Coordinates::finite;
};

}  // namespace weft::meshing
