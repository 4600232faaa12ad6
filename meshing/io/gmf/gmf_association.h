// What GMF files record of a CAD model: which vertices lie where on it, and the model itself.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "meshing/io/gmf/gmf_binary_file.h"
#include "meshing/io/gmf/gmf_rows.h"
#include "meshing/io/gmf/gmf_text_file.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing::gmf {

template <class Rows>
double read_parameter(Rows& rows) {
  const double value = rows.real();
  if (!std::isfinite(value)) rows.fail("a parameter is not finite");
  return value;
}

/// Calls read(record, rows) for each row of the range's part of a section, behind its vertex and id.
template <class File, class Record, class Read>
void read_records(const File& file, Keyword code, const MeshRange& range, std::vector<Record>& records,
                  const Read& read) {
  const Section* section = file.layout().find(code);
  if (!section) return;
  const RowRange part = part_of(*section, range);
  auto rows = rows_of(file, *section, part);
  records.resize(part.count);
  for (Record& record : records) {
    rows.begin_row();
    record.vertex = read_index(rows, file.layout().num_points(), "vertex");
    record.id = read_ref(rows);
    read(record, rows);
  }
  rows.finish();
}

/// The words of libMeshb's layout: a length in bytes, then the bytes four at a time.
template <class Rows>
std::vector<std::uint8_t> read_model_words(Rows& rows, std::uint64_t count) {
  std::vector<std::uint8_t> bytes;
  rows.begin_row();
  const std::int64_t length = rows.integer();
  if (length < 0 || (static_cast<std::uint64_t>(length) + 3) / 4 != count - 1)
    rows.fail("a length of " + std::to_string(length) + " bytes does not fit " + std::to_string(count) +
              " words");
  for (std::uint64_t i = 1; i < count; ++i) {
    rows.begin_row();
    const auto word = static_cast<std::uint32_t>(rows.integer());
    for (int k = 0; k < 4; ++k) bytes.push_back(static_cast<std::uint8_t>(word >> (8 * k)));
  }
  rows.finish();
  bytes.resize(static_cast<std::size_t>(length));
  return bytes;
}

/// A text file has words only; of binary ones refine's have as many bytes as rows.
inline bool is_raw(const TextFile&, const Section&) { return false; }
inline bool is_raw(const BinaryFile&, const Section& s) { return s.end - s.begin == s.count; }
inline std::vector<std::uint8_t> raw_bytes(const TextFile&, const Section&) { return {}; }
inline std::vector<std::uint8_t> raw_bytes(const BinaryFile& file, const Section& section) {
  return file.bytes(section);
}

template <class File>
void read_model(const File& file, Association& association) {
  const Section* section = file.layout().find(kByteFlow);
  if (!section || section->count == 0) return;
  association.model_in_words = !is_raw(file, *section);
  if (!association.model_in_words) {
    association.model = raw_bytes(file, *section);
    return;
  }
  auto rows = file.rows(*section, 0, 1, all_rows(*section));
  association.model = read_model_words(rows, section->count);
}

/// The range's part of the records, without the model.
template <class File>
void read_records_on_model(const File& file, const MeshRange& range, Association& a) {
  read_records(file, kVerticesOnNodes, range, a.nodes, [](auto&, auto&) {});
  read_records(file, kVerticesOnEdges, range, a.edges, [](Association::OnEdge& record, auto& rows) {
    record.t = read_parameter(rows);
    record.last = read_parameter(rows);
  });
  read_records(file, kVerticesOnFaces, range, a.faces, [](Association::OnFace& record, auto& rows) {
    record.u = read_parameter(rows);
    record.v = read_parameter(rows);
    record.last = read_parameter(rows);
  });
}

template <class File>
void read_association(const File& file, Association& a) {
  read_records_on_model(file, {}, a);
  read_model(file, a);
}

template <class Writer>
void write_nodes(Writer& out, const Association& a) {
  for (const auto& record : a.nodes) {
    out.index(std::int64_t{record.vertex} + 1);
    out.index(record.id);
    out.end_row();
  }
}

template <class Writer>
void write_edges(Writer& out, const Association& a) {
  for (const auto& record : a.edges) {
    out.index(std::int64_t{record.vertex} + 1);
    out.index(record.id);
    out.real(record.t);
    out.real(record.last);
    out.end_row();
  }
}

template <class Writer>
void write_faces(Writer& out, const Association& a) {
  for (const auto& record : a.faces) {
    out.index(std::int64_t{record.vertex} + 1);
    out.index(record.id);
    out.real(record.u);
    out.real(record.v);
    out.real(record.last);
    out.end_row();
  }
}

/// The model as the section was announced: bytes, or words behind their length.
template <class Writer>
void write_model(Writer& out, const Association& a, bool in_words) {
  if (!in_words) return out.bytes(a.model);
  out.index(static_cast<std::int64_t>(a.model.size()));
  out.end_row();
  for (std::size_t i = 0; i < a.model.size(); i += 4) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 4 && i + k < a.model.size(); ++k)
      word |= std::uint32_t{a.model[i + k]} << (8 * k);
    out.index(static_cast<std::int32_t>(word));
    out.end_row();
  }
}

}  // namespace weft::meshing::gmf
