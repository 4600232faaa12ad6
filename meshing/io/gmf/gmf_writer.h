// What is written into GMF files: sections and rows.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf_format.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing::gmf {

/// Writes binary sections and rows, in this machine's byte order, to a sink with write_value() and
/// position(). `name` is the file's, for messages.
template <class Sink>
class BinaryWriter {
 public:
  BinaryWriter(std::string name, Sink& out, int version)
      : name_(std::move(name)), out_(out), encoding_(version) {}

  void header() {
    out_.template write_value<std::int32_t>(1);
    out_.template write_value<std::int32_t>(encoding_.version);
    begin_keyword(kDimension, header_size(encoding_));
    out_.template write_value<std::int32_t>(3);
  }

  void begin_section(const SectionShape& shape) {
    begin_keyword(shape.code, out_.position() + section_size(encoding_, shape));
    if (shape.counted) index(shape.count);
    if (shape.code != kSolAtVertices) return;
    out_.write_value(static_cast<std::int32_t>(shape.field_types.size()));
    for (const std::int32_t type : shape.field_types) out_.write_value(type);
  }
  void real(double value) {
    if (encoding_.real_size == 8) return out_.write_value(value);
    if (std::isfinite(value) && std::abs(value) > std::numeric_limits<float>::max()) {
      throw InputError(name_, "", "a value is too large for the 32-bit reals of GMF version 1");
    }
    out_.write_value(static_cast<float>(value));
  }
  /// An index or a reference.
  void index(std::int64_t value) {
    if (encoding_.index_size() == 8) return out_.write_value(value);
    out_.write_value(static_cast<std::int32_t>(value));
  }
  void bytes(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) out_.write_value(byte);
  }
  void end_row() {}
  void end() { begin_keyword(kEnd, 0); }

 private:
  void begin_keyword(Keyword code, std::uint64_t next) {
    out_.template write_value<std::int32_t>(code);
    if (encoding_.position_size() == 8) return out_.write_value(next);
    out_.write_value(static_cast<std::uint32_t>(next));
  }

  std::string name_;
  Sink& out_;
  Encoding encoding_;
};

/// Writes the same as text, to a sink with write(text); reals with as many digits as give them back exactly.
template <class Sink>
class TextWriter {
 public:
  TextWriter(Sink& out, int version) : out_(out), version_(version) {}

  void header() { out_.write("MeshVersionFormatted " + std::to_string(version_) + "\n\nDimension 3\n"); }

  void begin_section(const SectionShape& shape) {
    out_.write("\n" + std::string(keyword_name(shape.code)) + "\n");
    if (shape.counted) out_.write(std::to_string(shape.count) + "\n");
    if (shape.code != kSolAtVertices) return;
    out_.write(std::to_string(shape.field_types.size()));
    for (const std::int32_t type : shape.field_types) out_.write(" " + std::to_string(type));
    out_.write("\n");
  }
  void real(double value) { number(value); }
  void index(std::int64_t value) { number(value); }
  void bytes(std::span<const std::uint8_t>) { throw std::logic_error("a text file holds words"); }
  void end_row() {
    out_.write("\n");
    row_begins_ = true;
  }
  void end() { out_.write("\nEnd\n"); }

 private:
  template <class Number>
  void number(Number value) {
    std::array<char, 32> digits;  // the longest double has 24 characters
    char* begin = digits.data();
    if (!std::exchange(row_begins_, false)) *begin++ = ' ';
    const char* end = std::to_chars(begin, digits.data() + digits.size(), value).ptr;
    out_.write(std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data())));
  }

  Sink& out_;
  int version_;
  bool row_begins_ = true;
};

template <class Writer>
void write_vertices(Writer& out, std::span<const Point> points, std::span<const std::int32_t> refs) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int c = 0; c < 3; ++c) out.real(points[i][c]);
    out.index(refs[i]);
    out.end_row();
  }
}

/// Elements of 0-based numbers of points, 32 or 64 bits wide.
template <class Writer, class Number, std::size_t N>
void write_elements(Writer& out, const std::vector<std::array<Number, N>>& elements,
                    std::span<const std::int32_t> refs) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (const Number vertex : elements[i]) out.index(static_cast<std::int64_t>(vertex) + 1);
    out.index(refs[i]);
    out.end_row();
  }
}

/// 0-based numbers, 32 or 64 bits wide.
template <class Writer, class Number>
void write_indices(Writer& out, const std::vector<Number>& indices) {
  for (const Number index : indices) {
    out.index(static_cast<std::int64_t>(index) + 1);
    out.end_row();
  }
}

template <class Writer>
void write_solution_rows(Writer& out, const SolutionData& solution) {
  for (std::size_t i = 0; i < solution.num_points; ++i) {
    for (const Field& field : solution.fields) {
      const std::size_t length = components(field.kind);
      for (std::size_t c = 0; c < length; ++c) out.real(field.values[i * length + c]);
    }
    out.end_row();
  }
}

}  // namespace weft::meshing::gmf
