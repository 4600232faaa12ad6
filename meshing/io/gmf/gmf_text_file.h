// ASCII GMF files: words, the keywords among them, and the rows of a section.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/text_numbers.h"
#include "meshing/io/gmf/gmf_format.h"

namespace weft::meshing::gmf {

/// Cuts text into words; a '#' begins a comment that lasts to the end of the line.
class Words {
 public:
  Words(std::string_view text, std::uint64_t begin) : text_(text), at_(begin) {}

  /// The next word, empty at the end of the text.
  std::string_view next() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '#') ++at_;
    return text_.substr(begin, at_ - begin);
  }
  std::uint64_t position() const { return at_; }

 private:
  void skip_blanks() {
    while (at_ < text_.size()) {
      if (text_[at_] == '#') {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (is_space(text_[at_])) {
        ++at_;
      } else {
        return;
      }
    }
  }

  std::string_view text_;
  std::size_t at_;
};

/// Reads rows of one section in order: the counterpart of BinaryRows. Rows in front of the range are passed
/// over.
class TextRows {
 public:
  TextRows(const std::string& file, std::string_view text, const Section& section, std::size_t reals,
           std::size_t indices, RowRange range);

  void begin_row() { ++row_; }
  double real() {
    const std::string_view word = words_.next();
    const std::optional<double> value = parse_real(word);
    if (!value) fail("expected a number, found " + quoted(word));
    return *value;
  }
  std::int64_t integer() {
    const std::string_view word = words_.next();
    const std::optional<std::int64_t> value = parse_integer(word);
    if (!value) fail("expected an integer, found " + quoted(word));
    return *value;
  }
  /// Behind the last row of the section more values mean that the count is wrong.
  void finish();

  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(file_, std::string(section_.keyword->name) + " " + std::to_string(row_), reason);
  }

 private:
  const std::string& file_;
  const Section section_;
  Words words_;
  std::uint64_t row_;
  bool ends_section_;
};

/// An ASCII file: read whole, and cut into sections at the words that are keywords.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path);
  /// A file whose layout is known already. Throws InputError when its size is another now.
  TextFile(const std::filesystem::path& path, const GmfLayout& layout);

  const std::string& name() const { return file_.name(); }
  const GmfLayout& layout() const { return layout_; }
  TextRows rows(const Section& section, std::size_t reals, std::size_t indices, RowRange range) const {
    return TextRows(name(), text(), section, reals, indices, range);
  }

  /// The types of the fields in a solution section; moves the section's begin to its first row.
  std::vector<std::int64_t> take_solution_types(Section& section) const;

 private:
  std::string_view text() const { return file_.bytes(); }
  std::uint64_t next_count(Words& words, const std::string& entity, const std::string& expected) const;
  std::string_view scan_keyword(std::string_view word, Words& words);

  FileBytes file_;
  GmfLayout layout_;
  bool has_dimension_ = false;
};

}  // namespace weft::meshing::gmf
