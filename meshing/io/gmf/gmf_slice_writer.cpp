// Places of rows, and the rows themselves through the writer of whole files.
#include "meshing/io/gmf/gmf_slice_writer.h"

#include <stdexcept>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf_association.h"

namespace weft::meshing {

using namespace gmf;

GmfPlan::GmfPlan(const std::filesystem::path& name, std::vector<SectionShape> shapes, int version)
    : name_(name.string()), version_(choose_version(name_, version, shapes)), shapes_(std::move(shapes)) {
  if (is_text(name))
    throw InputError(name_, "", "a text file cannot be written in parts; .meshb and .solb can");
}

GmfPlan GmfPlan::of_mesh(const std::filesystem::path& name, const MeshCounts& counts, int version) {
  return {name, mesh_shapes(counts), version};
}

GmfPlan GmfPlan::of_solution(const std::filesystem::path& name, std::uint64_t num_points,
                             const std::vector<Field::Kind>& fields, int version) {
  return {name, {solution_shape(num_points, fields)}, version};
}

std::uint64_t GmfPlan::row_position(Keyword section, std::uint64_t row) const {
  const Encoding encoding(version_);
  std::uint64_t position = header_size(encoding);
  for (const SectionShape& shape : shapes_) {
    if (shape.code == section && row <= shape.count) {
      return position + section_head_size(encoding, shape) +
             row * (shape.bytes + encoding.row_size(shape.reals, shape.indices));
    }
    position += section_size(encoding, shape);
  }
  throw std::out_of_range("GMF: row " + std::to_string(row) + " of " + std::string(keyword_name(section)));
}

GmfSliceWriter::GmfSliceWriter(const std::filesystem::path& file, const GmfPlan& plan)
    : plan_(plan), file_(file, plan.name()), out_(plan.name(), file_, plan.version()) {}

void GmfSliceWriter::frame() {
  file_.seek(0);
  out_.header();
  for (const SectionShape& shape : plan_.sections()) {
    out_.begin_section(shape);
    file_.seek(plan_.row_position(shape.code, shape.count));
  }
  out_.end();
}

bool GmfSliceWriter::begin_rows(Keyword section, std::uint64_t first, std::uint64_t count) {
  if (count == 0) return false;  // the file may lack the section
  plan_.row_position(section, first + count);
  file_.seek(plan_.row_position(section, first));
  return true;
}

void GmfSliceWriter::vertices(std::uint64_t first, std::span<const Point> points,
                              std::span<const std::int32_t> refs) {
  if (begin_rows(kVertices, first, points.size())) write_vertices(out_, points, refs);
}

void GmfSliceWriter::indices(Keyword section, std::uint64_t first,
                             const std::vector<std::uint64_t>& indices) {
  if (begin_rows(section, first, indices.size())) write_indices(out_, indices);
}

void GmfSliceWriter::on_model(Keyword section, std::uint64_t first, const std::vector<ModelRow>& rows) {
  if (!begin_rows(section, first, rows.size())) return;
  const std::size_t reals = find_keyword(section)->reals;
  for (const ModelRow& row : rows) {
    out_.index(static_cast<std::int64_t>(row.vertex) + 1);
    out_.index(row.id);
    for (std::size_t i = 0; i < reals; ++i) out_.real(row.reals[i]);
    out_.end_row();
  }
}

void GmfSliceWriter::model(const Association& carried) {
  if (begin_rows(kByteFlow, 0, carried.model.empty() ? 0 : 1))
    write_model(out_, carried, carried.model_in_words);
}

void GmfSliceWriter::solution(std::uint64_t first, const SolutionData& part) {
  if (begin_rows(kSolAtVertices, first, part.num_points)) write_solution_rows(out_, part);
}

}  // namespace weft::meshing
