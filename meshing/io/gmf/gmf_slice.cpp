// The same readers as for whole files, on ranges of rows.
#include "meshing/io/gmf/gmf_slice.h"

#include <stdexcept>

#include "meshing/io/gmf/gmf_association.h"
#include "meshing/io/gmf/gmf_binary_file.h"
#include "meshing/io/gmf/gmf_rows.h"
#include "meshing/io/gmf/gmf_text_file.h"

namespace weft::meshing {
namespace {

using namespace gmf;

/// read(file) of a file of either kind, whose layout is known.
template <class Read>
auto read_with(const std::filesystem::path& path, const GmfLayout& layout, const Read& read) {
  return is_text(path) ? read(TextFile(path, layout)) : read(BinaryFile(path, layout));
}

template <class File>
GmfLayout checked_layout(const File& file) {
  const GmfLayout& layout = file.layout();
  layout.refuse_foreign_volumes(file.name());
  for (const Section& section : layout.sections()) {
    const bool rows_known = section.keyword->reals + section.keyword->indices > 0;
    if (rows_known) rows_of(file, section, {0, 0});
  }
  return layout;
}

}  // namespace

GmfLayout read_gmf_layout(const std::filesystem::path& path) {
  return is_text(path) ? checked_layout(TextFile(path)) : checked_layout(BinaryFile(path));
}

GmfPoints read_gmf_points(const std::filesystem::path& path, const GmfLayout& layout, std::uint64_t first,
                          std::uint64_t count) {
  return read_with(path, layout, [&](const auto& file) {
    GmfPoints part;
    read_vertices(file, vertices_section(file), {first, count}, part.points, part.refs);
    return part;
  });
}

GmfTets read_gmf_tets(const std::filesystem::path& path, const GmfLayout& layout, std::uint64_t first,
                      std::uint64_t count) {
  return read_with(path, layout, [&](const auto& file) {
    GmfTets part;
    const Section* section = file.layout().find(kTetrahedra);
    if (!section && first + count > 0) throw std::out_of_range("GMF: the file has no tets");
    if (section) read_elements(file, *section, {first, count}, part.tets, part.refs);
    return part;
  });
}

MeshData read_gmf_boundary(const std::filesystem::path& path, const GmfLayout& layout,
                           const MeshRange& range) {
  return read_with(path, layout, [&](const auto& file) {
    MeshData mesh;
    read_boundary(file, range, mesh);
    read_records_on_model(file, range, mesh.association);
    return mesh;
  });
}

MeshContents stream_gmf(const std::filesystem::path& path, MeshStream& stream) {
  const GmfLayout layout = read_gmf_layout(path);
  return read_with(path, layout, [&](const auto& file) {
    stream_vertices(file, vertices_section(file), stream);
    if (const Section* tets = layout.find(kTetrahedra)) stream_tets(file, *tets, stream);
    stream_boundary(file, stream);
    MeshContents contents;
    read_records_on_model(file, {}, contents.mesh.association);
    contents.dropped = layout.dropped();
    return contents;
  });
}

Association read_gmf_model(const std::filesystem::path& path, const GmfLayout& layout) {
  return read_with(path, layout, [](const auto& file) {
    Association association;
    read_model(file, association);
    return association;
  });
}

SolutionData read_gmf_solution_slice(const std::filesystem::path& path, const GmfLayout& layout,
                                     std::uint64_t first, std::uint64_t count) {
  return read_with(path, layout, [&](const auto& file) {
    return read_solution_rows(file, [&](const Section&) { return RowRange{first, count}; });
  });
}

}  // namespace weft::meshing
