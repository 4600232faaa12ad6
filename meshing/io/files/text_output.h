// Text into a file (whatever has write()): words with blanks between them, numbers with as many digits as
// give them back exactly.
#pragma once

#include <array>
#include <charconv>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "meshing/io/files/atomic_file.h"

namespace weft::meshing {

/// Text that is to be written later; has what files have.
struct TextInMemory {
  std::string text;
  void write(std::string_view more) { text += more; }
  template <class T>
  void write_value(T value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
};

template <class Out = AtomicFile>
class TextOutput {
 public:
  /// `line_begins`: it does not go on with a line.
  explicit TextOutput(Out& file, bool line_begins = true) : file_(file), line_begins_(line_begins) {}

  /// A whole line.
  void line(std::string_view text) {
    file_.write(text);
    file_.write("\n");
  }
  void word(std::string_view text) {
    if (!std::exchange(line_begins_, false)) file_.write(" ");
    file_.write(text);
  }
  template <class Number>
  void number(Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    std::array<char, 32> digits;  // the longest double has 24 characters
    const char* end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    word({digits.data(), static_cast<std::size_t>(end - digits.data())});
  }
  template <class... Numbers>
  void numbers(Numbers... values) {
    (number(values), ...);
  }
  void end_line() {
    file_.write("\n");
    line_begins_ = true;
  }

 private:
  Out& file_;
  bool line_begins_;
};

}  // namespace weft::meshing
