// Places of rows, and the rows themselves through the writer of whole files.
#include "meshing/io/gmf/gmf_slice_writer.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "meshing/base/error.h"
#include "meshing/io/gmf/gmf_association.h"

namespace weft::meshing {

using namespace gmf;

GmfPlan::GmfPlan(const std::filesystem::path& name, std::vector<SectionShape> shapes, int version)
    : name_(name.string()),
      text_(gmf::is_text(name)),
      version_(choose_version(name_, version, shapes)),
      shapes_(std::move(shapes)) {}

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

std::vector<std::string> GmfPlan::text_heads() const {
  std::vector<std::string> heads;
  TextInMemory head;
  TextWriter<TextInMemory> out(head, version_);
  out.header();
  for (const SectionShape& shape : shapes_) {
    out.begin_section(shape);
    heads.push_back(std::exchange(head.text, {}));
  }
  out.end();
  heads.push_back(std::move(head.text));
  return heads;
}

GmfSliceWriter::GmfSliceWriter(PartTarget target, const GmfPlan& plan)
    : plan_(plan), file_(std::make_unique<FilePart>(std::move(target))) {
  if (!plan.is_text()) binary_.emplace(plan.name(), *file_, plan.version());
}

GmfSliceWriter::GmfSliceWriter(const GmfPlan& plan)
    : plan_(plan), text_places_(plan.sections().size() + 1, 0) {}

void GmfSliceWriter::frame(std::span<const std::uint64_t> heads) {
  if (plan_.is_text()) {
    const std::vector<std::string> texts = plan_.text_heads();
    for (std::size_t s = 0; s < texts.size(); ++s) {
      file_->seek(heads[s]);
      file_->write(texts[s]);
    }
    return;
  }
  file_->seek(0);
  binary_->header();
  for (const SectionShape& shape : plan_.sections()) {
    binary_->begin_section(shape);
    file_->seek(plan_.row_position(shape.code, shape.count));
  }
  binary_->end();
}

void GmfSliceWriter::seek_rows(Keyword section, std::uint64_t first, std::uint64_t count) {
  plan_.row_position(section, first + count);
  file_->seek(plan_.row_position(section, first));
}

void GmfSliceWriter::put_text(Keyword section, const std::string& rows) {
  const auto shape = std::ranges::find(plan_.sections(), section, &SectionShape::code);
  if (shape == plan_.sections().end())
    throw std::out_of_range("GMF: rows of " + std::string(keyword_name(section)));
  std::uint64_t& place = text_places_[static_cast<std::size_t>(shape - plan_.sections().begin())];
  if (file_) {
    file_->seek(place);
    file_->write(rows);
  }
  place += rows.size();
}

void GmfSliceWriter::vertices(std::uint64_t first, std::span<const Point> points,
                              std::span<const std::int32_t> refs) {
  write(kVertices, first, points.size(), [&](auto& out) { write_vertices(out, points, refs); });
}

void GmfSliceWriter::indices(Keyword section, std::uint64_t first,
                             const std::vector<std::uint64_t>& indices) {
  write(section, first, indices.size(), [&](auto& out) { write_indices(out, indices); });
}

void GmfSliceWriter::on_model(Keyword section, std::uint64_t first, const std::vector<ModelRow>& rows) {
  const std::size_t reals = find_keyword(section)->reals;
  write(section, first, rows.size(), [&](auto& out) {
    for (const ModelRow& row : rows) {
      out.index(static_cast<std::int64_t>(row.vertex) + 1);
      out.index(row.id);
      for (std::size_t i = 0; i < reals; ++i) out.real(row.reals[i]);
      out.end_row();
    }
  });
}

void GmfSliceWriter::model(const Association& carried) {
  write(kByteFlow, 0, carried.model.empty() ? 0 : 1,
        [&](auto& out) { write_model(out, carried, plan_.is_text() || carried.model_in_words); });
}

void GmfSliceWriter::solution(std::uint64_t first, const SolutionData& part) {
  write(kSolAtVertices, first, part.num_points, [&](auto& out) { write_solution_rows(out, part); });
}

}  // namespace weft::meshing
