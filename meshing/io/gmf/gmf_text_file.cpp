// Cuts an ASCII file into sections, believing nothing it claims.
#include "meshing/io/gmf/gmf_text_file.h"

#include <utility>

namespace weft::meshing::gmf {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Whether a word is a keyword (known or not) rather than a value.
bool is_keyword(std::string_view word) {
  return !word.empty() && is_letter(word.front()) && !parse_real(word);  // nan and inf are values
}

}  // namespace

TextRows::TextRows(const InputFile& file, const Section& section, std::size_t reals, std::size_t indices,
                   RowRange range)
    : file_(file.name()),
      section_(section),
      words_(file, section.begin),
      row_(range.first),
      ends_section_(range.first + range.count == section.count) {
  // Every number takes a digit and a blank, which bounds what a damaged count can make us allocate.
  const std::uint64_t most = (file.size() - section.begin + 1) / 2 / (reals + indices);
  if (section.count > most) {
    throw InputError(file_, std::string(section.keyword->name),
                     std::to_string(section.count) + " rows are more than the file can hold");
  }
  check_range(section, range);
  for (std::uint64_t w = range.first * (reals + indices); w > 0; --w) words_.next();
}

void TextRows::finish() {
  if (!ends_section_) return;
  const std::string_view word = words_.next();
  if (words_.position() > section_.end) return;
  throw InputError(file_, std::string(section_.keyword->name),
                   "there are more values than its count of " + std::to_string(section_.count) +
                       " rows needs: found " + quoted(word));
}

TextFile::TextFile(const std::filesystem::path& path) : file_(path) {
  layout_.file_size = file_.size();
  Words words(file_, 0);
  if (words.next() != "MeshVersionFormatted") {
    throw InputError(name(), "", "not an ASCII GMF file (it does not begin with MeshVersionFormatted)");
  }
  const std::uint64_t version = next_count(words, "MeshVersionFormatted", "a version");
  if (version < 1 || version > 4) {
    throw InputError(name(), "", "GMF version " + std::to_string(version) + " is unknown (1 to 4 are)");
  }
  std::string word(words.next());
  while (word != "End") {
    if (word.empty()) throw InputError(name(), "", "the file is truncated: no keyword End");
    word = scan_keyword(word, words);
  }
  if (!has_dimension_) throw InputError(name(), "Dimension", "is missing");
}

TextFile::TextFile(const std::filesystem::path& path, const GmfLayout& layout)
    : file_(path), layout_(layout) {
  check_size(name(), layout, file_.size());
}

std::vector<std::int64_t> TextFile::take_solution_types(Section& section) const {
  const std::string entity(section.keyword->name);
  Words words(file_, section.begin);
  const std::uint64_t count = next_count(words, entity, "a number of fields");
  if (count > file_.size()) throw InputError(name(), entity, "the number of fields is damaged");
  std::vector<std::int64_t> types(count);
  for (std::int64_t& type : types) {
    type = static_cast<std::int64_t>(next_count(words, entity, "a field's type"));
  }
  section.begin = words.position();
  return types;
}

std::uint64_t TextFile::next_count(Words& words, const std::string& entity,
                                   const std::string& expected) const {
  const std::string_view word = words.next();
  const std::optional<std::int64_t> value = parse_integer(word);
  if (!value || *value < 0)
    throw InputError(name(), entity, "expected " + expected + ", found " + quoted(word));
  return static_cast<std::uint64_t>(*value);
}

/// Notes a keyword; passes over its values and returns the word behind them.
std::string TextFile::scan_keyword(const std::string& entity, Words& words) {
  const KeywordInfo* keyword = find_keyword(entity);
  Section section{keyword, 0, 0, 0};
  if (entity == "Dimension") {
    if (std::exchange(has_dimension_, true)) throw InputError(name(), entity, "appears twice");
    check_dimension(name(), static_cast<std::int64_t>(next_count(words, entity, "a dimension")));
  } else if (keyword) {
    section.count = next_count(words, entity, "a count");
  }
  section.begin = section.end = words.position();
  std::string_view word;
  for (word = words.next(); !word.empty() && !is_keyword(word); word = words.next()) {
    section.end = words.position();
  }
  if (keyword) layout_.add(name(), section);
  return std::string(word);
}

}  // namespace weft::meshing::gmf
