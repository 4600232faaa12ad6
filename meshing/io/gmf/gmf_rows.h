// What is read from the rows of a GMF section, of files of either kind. `File` is BinaryFile or TextFile.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/io/files/mesh_stream.h"
#include "meshing/io/gmf/gmf.h"
#include "meshing/io/gmf/gmf_format.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing::gmf {

/// A 1-based index of one of `limit` entities, as a 0-based one.
template <class Rows>
std::uint32_t read_index(Rows& rows, std::uint64_t limit, const char* entity) {
  const std::int64_t index = rows.integer();
  if (index < 1 || static_cast<std::uint64_t>(index) > limit) {
    const std::string what = std::string(entity) + " index " + std::to_string(index);
    rows.fail(limit == 0 ? what + ", but the file has none"
                         : what + " is out of range 1.." + std::to_string(limit));
  }
  return static_cast<std::uint32_t>(index - 1);
}

template <class Rows>
std::int32_t read_ref(Rows& rows) {
  const std::int64_t ref = rows.integer();
  if (ref < -kMaxInt32 - 1 || ref > kMaxInt32) {
    rows.fail("reference " + std::to_string(ref) + " does not fit 32 bits");
  }
  return static_cast<std::int32_t>(ref);
}

/// The section of a keyword without which there is nothing to read.
template <class File>
const Section& required_section(const File& file, Keyword code, const char* issue) {
  const Section* section = file.layout().find(code);
  if (!section) throw InputError(file.name(), std::string(keyword_name(code)), issue);
  return *section;
}

template <class File>
const Section& vertices_section(const File& file) {
  return required_section(file, kVertices, "are missing");
}

template <class File>
auto rows_of(const File& file, const Section& section, RowRange range) {
  return file.rows(section, section.keyword->reals, section.keyword->indices, range);
}

template <class Rows>
Point read_point(Rows& rows, Coordinates wanted = Coordinates::finite) {
  Point p;
  for (int c = 0; c < 3; ++c) {
    p[c] = rows.real();
    if (!passes(p[c], wanted)) rows.fail("a coordinate is not finite");
  }
  return p;
}

template <std::size_t N, class Rows>
std::array<std::uint32_t, N> read_element(Rows& rows, std::uint64_t num_points) {
  std::array<std::uint32_t, N> element;
  for (std::uint32_t& vertex : element) vertex = read_index(rows, num_points, "vertex");
  return element;
}

template <class File>
void read_vertices(const File& file, const Section& section, RowRange range, std::vector<Point>& points,
                   std::vector<std::int32_t>& refs, Coordinates wanted = Coordinates::finite) {
  auto rows = rows_of(file, section, range);
  points.resize(range.count);
  refs.resize(range.count);
  for (std::size_t i = 0; i < points.size(); ++i) {
    rows.begin_row();
    points[i] = read_point(rows, wanted);
    refs[i] = read_ref(rows);
  }
  rows.finish();
}

template <std::size_t N, class File>
void read_elements(const File& file, const Section& section, RowRange range,
                   std::vector<std::array<std::uint32_t, N>>& elements, std::vector<std::int32_t>& refs) {
  const std::uint64_t num_points = file.layout().num_points();
  auto rows = rows_of(file, section, range);
  elements.resize(range.count);
  refs.resize(range.count);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    rows.begin_row();
    elements[i] = read_element<N>(rows, num_points);
    refs[i] = read_ref(rows);
  }
  rows.finish();
}

/// All rows of a section, each by `read`, with their references into the stream.
template <class T, class File, class Read>
void stream_rows(const File& file, const Section& section, StreamedRows<T> out,
                 StreamedRows<std::int32_t> out_refs, const Read& read) {
  auto rows = rows_of(file, section, all_rows(section));
  for (std::uint64_t i = 0; i < section.count; ++i) {
    rows.begin_row();
    out.add(read(rows));
    out_refs.add(read_ref(rows));
  }
  rows.finish();
  out.pass();
  out_refs.pass();
}

template <class File>
void stream_vertices(const File& file, const Section& section, MeshStream& stream) {
  stream_rows<Point>(file, section, {stream, &MeshStream::take_points},
                     {stream, &MeshStream::take_point_refs}, [](auto& rows) { return read_point(rows); });
}

template <class File>
void stream_tets(const File& file, const Section& section, MeshStream& stream) {
  const std::uint64_t num_points = file.layout().num_points();
  stream_rows<std::array<std::uint32_t, 4>>(file, section, {stream, &MeshStream::take_tets},
                                            {stream, &MeshStream::take_tet_refs},
                                            [&](auto& rows) { return read_element<4>(rows, num_points); });
}

/// The rows of a section that are in the range's part.
inline RowRange part_of(const Section& section, const MeshRange& range) {
  const std::uint64_t begin = range.part_begin(section.count);
  return {begin, range.part_end(section.count) - begin};
}

template <std::size_t N, class File>
void read_part_of_elements(const File& file, Keyword code, const MeshRange& range,
                           std::vector<std::array<std::uint32_t, N>>& elements,
                           std::vector<std::int32_t>& refs) {
  const Section* section = file.layout().find(code);
  if (section) read_elements(file, *section, part_of(*section, range), elements, refs);
}

/// The range's part of the list.
template <class File>
void read_indices(const File& file, Keyword code, const MeshRange& range, std::uint64_t limit,
                  const char* entity, std::vector<std::uint32_t>& indices) {
  const Section* section = file.layout().find(code);
  if (!section) return;
  const RowRange part = part_of(*section, range);
  auto rows = rows_of(file, *section, part);
  indices.resize(part.count);
  for (std::uint32_t& index : indices) {
    rows.begin_row();
    index = read_index(rows, limit, entity);
  }
  rows.finish();
}

/// A list of marks: of entities of which there are `limit`.
struct MarkList {
  Keyword code;
  std::vector<std::uint32_t> MeshData::*indices;
  std::uint64_t limit;
  const char* entity;
};
inline std::array<MarkList, 5> mark_lists(const GmfLayout& layout) {
  const std::uint64_t points = layout.num_points(), edges = layout.num_edges(),
                      triangles = layout.num_triangles();
  return {{{kCorners, &MeshData::corners, points, "vertex"},
           {kRequiredVertices, &MeshData::required_points, points, "vertex"},
           {kRidges, &MeshData::ridges, edges, "edge"},
           {kRequiredEdges, &MeshData::required_edges, edges, "edge"},
           {kRequiredTriangles, &MeshData::required_triangles, triangles, "triangle"}}};
}

/// The range's part of triangles, edges and all marks.
template <class File>
void read_boundary(const File& file, const MeshRange& range, MeshData& mesh) {
  read_part_of_elements(file, kTriangles, range, mesh.triangles, mesh.triangle_refs);
  read_part_of_elements(file, kEdges, range, mesh.edges, mesh.edge_refs);
  for (const auto& [code, indices, limit, entity] : mark_lists(file.layout()))
    read_indices(file, code, range, limit, entity, mesh.*indices);
}

/// Triangles, edges and all marks into the stream.
template <class File>
void stream_boundary(const File& file, MeshStream& stream) {
  const std::uint64_t points = file.layout().num_points();
  StreamedBoundary boundary(stream);
  // The arrays of `boundary` are others each time that it has passed rows on.
  const auto pass_rows = [&](Keyword code, auto add_row) {
    const Section* section = file.layout().find(code);
    if (!section) return;
    auto rows = rows_of(file, *section, all_rows(*section));
    for (std::uint64_t i = 0; i < section->count; ++i) {
      rows.begin_row();
      add_row(boundary.rows.rows, rows);
      boundary.pass_if_full();
    }
    rows.finish();
  };
  pass_rows(kTriangles, [&](MeshData& mesh, auto& rows) {
    mesh.triangles.push_back(read_element<3>(rows, points));
    mesh.triangle_refs.push_back(read_ref(rows));
  });
  pass_rows(kEdges, [&](MeshData& mesh, auto& rows) {
    mesh.edges.push_back(read_element<2>(rows, points));
    mesh.edge_refs.push_back(read_ref(rows));
  });
  for (const MarkList& list : mark_lists(file.layout()))
    pass_rows(list.code, [&](MeshData& mesh, auto& rows) {
      (mesh.*list.indices).push_back(read_index(rows, list.limit, list.entity));
    });
  boundary.pass();
}

/// Empty fields of the kinds that a solution section announces. Throws InputError for unknown ones, or none.
std::vector<Field> make_fields(const std::string& file, const std::vector<std::int64_t>& types);

/// The rows of a solution that choose(section) names.
template <class File, class Choose>
SolutionData read_solution_rows(const File& file, const Choose& choose) {
  Section section = required_section(file, kSolAtVertices, "is missing: no solution at vertices");
  const RowRange range = choose(section);
  SolutionData solution;
  solution.fields = make_fields(file.name(), file.take_solution_types(section));
  std::size_t row_length = 0;
  for (const Field& field : solution.fields) row_length += components(field.kind);
  auto rows = file.rows(section, row_length, 0, range);
  solution.num_points = range.count;
  for (Field& field : solution.fields) field.values.resize(range.count * components(field.kind));
  for (std::size_t i = 0; i < solution.num_points; ++i) {
    rows.begin_row();
    for (Field& field : solution.fields) {
      const std::size_t length = components(field.kind);
      for (std::size_t c = 0; c < length; ++c) field.values[i * length + c] = rows.real();
    }
  }
  rows.finish();
  return solution;
}

}  // namespace weft::meshing::gmf
