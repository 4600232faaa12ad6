// Cuts a binary file into sections, believing nothing it claims.
#include "meshing/io/gmf/gmf_binary_file.h"

#include <array>

namespace weft::meshing::gmf {
namespace {

Encoding read_header(const InputFile& file) {
  std::array<std::byte, 8> header;
  if (file.size() < header.size()) throw InputError(file.name(), "", "too short for a binary GMF file");
  file.read_at(0, header.data(), header.size());
  const auto code = load<std::uint32_t>(header.data(), false);
  if (code != 1 && code != 0x01000000u) {
    throw InputError(file.name(), "", "not a binary GMF file (its first word is neither 1 nor 1 swapped)");
  }
  const std::int64_t version = load_int(header.data() + 4, 4, code != 1);
  if (version < 1 || version > 4) {
    throw InputError(file.name(), "", "GMF version " + std::to_string(version) + " is unknown (1 to 4 are)");
  }
  return Encoding(static_cast<int>(version), code != 1);
}

std::string describe(std::int64_t code) {
  const KeywordInfo* keyword = find_keyword(static_cast<std::int32_t>(code));
  return keyword ? std::string(keyword->name) : "keyword " + std::to_string(code);
}

}  // namespace

BinaryRows::BinaryRows(const InputFile& file, const Encoding& encoding, const Section& section,
                       std::size_t reals, std::size_t indices, RowRange range)
    : file_(file), encoding_(encoding), section_(section), row_size_(encoding.row_size(reals, indices)) {
  const std::uint64_t bytes = section.end - section.begin;
  // Division first: the product of a damaged count may overflow.
  if (section.count > bytes / row_size_ || section.count * row_size_ != bytes) {
    throw InputError(file.name(), std::string(section.keyword->name),
                     std::to_string(section.count) + " rows of " + std::to_string(row_size_) +
                         " bytes do not fill the section's " + std::to_string(bytes) + " bytes");
  }
  check_range(section, range);
  row_ = range.first;
  position_ = section.begin + range.first * row_size_;
  end_ = position_ + range.count * row_size_;
  capacity_ = std::min(end_ - position_, std::max(row_size_, kBufferSize / row_size_ * row_size_));
  buffer_ = std::make_unique_for_overwrite<std::byte[]>(capacity_);
}

BinaryFile::BinaryFile(const std::filesystem::path& path) : file_(path) {
  layout_.encoding = read_header(file_);
  layout_.file_size = file_.size();
  std::uint64_t position = 8;
  while (const std::optional<std::uint64_t> next = scan_keyword(position)) position = *next;
  if (!has_dimension_) throw InputError(name(), "Dimension", "is missing");
}

BinaryFile::BinaryFile(const std::filesystem::path& path, const GmfLayout& layout)
    : file_(path), layout_(layout) {
  check_size(name(), layout, file_.size());
}

std::vector<std::uint8_t> BinaryFile::bytes(const Section& section) const {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(section.end - section.begin));
  file_.read_at(section.begin, bytes.data(), bytes.size());
  return bytes;
}

std::vector<std::int64_t> BinaryFile::take_solution_types(Section& section) const {
  const std::int64_t count = section.end - section.begin < 4 ? -1 : int_at(section.begin, 4);
  if (count < 0 || static_cast<std::uint64_t>(count) > (section.end - section.begin - 4) / 4) {
    throw InputError(name(), std::string(section.keyword->name), "the number of fields is damaged");
  }
  std::vector<std::int64_t> types(static_cast<std::size_t>(count));
  section.begin += 4;
  for (std::int64_t& type : types) {
    type = int_at(section.begin, 4);
    section.begin += 4;
  }
  return types;
}

std::int64_t BinaryFile::int_at(std::uint64_t position, std::size_t size) const {
  std::array<std::byte, 8> bytes;
  file_.read_at(position, bytes.data(), size);
  return load_int(bytes.data(), size, layout_.encoding.swapped);
}

/// Notes the keyword at `position`; returns where the next one is, nothing at the End. That of Mmg's
/// solutions, and of its meshes before version 5.5, has no position.
std::optional<std::uint64_t> BinaryFile::scan_keyword(std::uint64_t position) {
  if (position + 4 == file_.size() && int_at(position, 4) == kEnd) return std::nullopt;
  const std::uint64_t begin = position + 4 + layout_.encoding.position_size();
  if (begin > file_.size()) throw InputError(name(), "", "the file is truncated: no keyword End");
  const std::int64_t code = int_at(position, 4);
  if (code == kEnd) return std::nullopt;
  const auto next = static_cast<std::uint64_t>(int_at(position + 4, layout_.encoding.position_size()));
  // Forward only, which also rules out cycles and a chain that stops (position 0) without End.
  if (next < begin || next > file_.size()) {
    throw InputError(name(), describe(code),
                     "the next keyword's position " + std::to_string(static_cast<std::int64_t>(next)) +
                         " is not in " + std::to_string(begin) + ".." + std::to_string(file_.size()) +
                         ": the file is truncated or damaged");
  }
  note_keyword(code, begin, next);
  return next;
}

void BinaryFile::note_keyword(std::int64_t code, std::uint64_t begin, std::uint64_t end) {
  if (code == kDimension || code == kFloatingPointPrecision) {
    if (end - begin < 4) throw InputError(name(), describe(code), "its value is missing");
    note_value(code, int_at(begin, 4));
  } else if (const KeywordInfo* keyword = find_keyword(static_cast<std::int32_t>(code))) {
    const std::size_t size = layout_.encoding.index_size();
    if (end - begin < size) throw InputError(name(), describe(code), "its count is missing");
    const std::int64_t count = int_at(begin, size);
    if (count < 0) throw InputError(name(), describe(code), "its count is negative");
    layout_.add(name(), {keyword, static_cast<std::uint64_t>(count), begin + size, end});
  }
}

void BinaryFile::note_value(std::int64_t code, std::int64_t value) {
  if (code == kDimension) {
    if (has_dimension_) throw InputError(name(), "Dimension", "appears twice");
    check_dimension(name(), value);
    has_dimension_ = true;
  } else if (value == 32 || value == 64) {
    layout_.encoding.real_size = static_cast<std::size_t>(value / 8);
  }
}

}  // namespace weft::meshing::gmf
