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
#include "meshing/io/files/cursor.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/text_numbers.h"
#include "meshing/io/gmf/gmf_format.h"

namespace weft::meshing::gmf {

/// Cuts a file into words, of which each is valid until the next; a '#' begins a comment that lasts to the
/// end of the line.
class Words {
 public:
  Words(const InputFile& file, std::uint64_t begin) : in_(file, begin) { in_.set_comment('#'); }

  /// The next word, empty at the end of the file.
  std::string_view next() { return in_.word(); }
  std::uint64_t position() const { return in_.position(); }

 private:
  Cursor in_;
};

/// Reads rows of one section in order: the counterpart of BinaryRows. Rows in front of the range are passed
/// over.
class TextRows {
 public:
  TextRows(const InputFile& file, const Section& section, std::size_t reals, std::size_t indices,
           RowRange range);

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

/// An ASCII file, cut into sections at the words that are keywords. No more than a window of it is in memory.
class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path);
  /// A file whose layout is known already. Throws InputError when its size is another now.
  TextFile(const std::filesystem::path& path, const GmfLayout& layout);

  const std::string& name() const { return file_.name(); }
  const GmfLayout& layout() const { return layout_; }
  TextRows rows(const Section& section, std::size_t reals, std::size_t indices, RowRange range) const {
    return TextRows(file_, section, reals, indices, range);
  }

  /// The types of the fields in a solution section; moves the section's begin to its first row.
  std::vector<std::int64_t> take_solution_types(Section& section) const;

 private:
  std::uint64_t next_count(Words& words, const std::string& entity, const std::string& expected) const;
  std::string scan_keyword(const std::string& word, Words& words);

  InputFile file_;
  GmfLayout layout_;
  bool has_dimension_ = false;
};

}  // namespace weft::meshing::gmf
