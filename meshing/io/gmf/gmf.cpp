// Whole GMF files: reading is put together of gmf_rows.h, writing of gmf_writer.h.
#include "meshing/io/gmf/gmf.h"

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/single_precision.h"
#include "meshing/io/gmf/gmf_association.h"
#include "meshing/io/gmf/gmf_binary_file.h"
#include "meshing/io/gmf/gmf_rows.h"
#include "meshing/io/gmf/gmf_text_file.h"
#include "meshing/io/gmf/gmf_writer.h"

namespace weft::meshing {
namespace {

using namespace gmf;

template <class File>
MeshContents read_contents_of(const File& file, Coordinates wanted) {
  file.layout().refuse_foreign_volumes(file.name());
  MeshContents contents;
  MeshData& mesh = contents.mesh;
  const Section& vertices = vertices_section(file);
  read_vertices(file, vertices, all_rows(vertices), mesh.points, mesh.point_refs, wanted);
  read_part_of_elements(file, kTetrahedra, {}, mesh.tets, mesh.tet_refs);
  read_boundary(file, {}, mesh);
  read_association(file, mesh.association);
  contents.fields.num_points = mesh.points.size();
  contents.dropped = file.layout().dropped();
  return contents;
}

void check_lengths(const MeshData& mesh) {
  if (mesh.point_refs.size() != mesh.points.size() || mesh.tet_refs.size() != mesh.tets.size() ||
      mesh.triangle_refs.size() != mesh.triangles.size() || mesh.edge_refs.size() != mesh.edges.size()) {
    throw std::logic_error("write_gmf_mesh: an entity array and its references differ in length");
  }
}

template <class Writer>
void write_section_rows(Writer& out, const MeshData& mesh, Keyword code, bool model_in_words) {
  switch (code) {
    case kVertices:
      return write_vertices(out, mesh.points, mesh.point_refs);
    case kEdges:
      return write_elements(out, mesh.edges, mesh.edge_refs);
    case kTriangles:
      return write_elements(out, mesh.triangles, mesh.triangle_refs);
    case kTetrahedra:
      return write_elements(out, mesh.tets, mesh.tet_refs);
    case kCorners:
      return write_indices(out, mesh.corners);
    case kRidges:
      return write_indices(out, mesh.ridges);
    case kRequiredVertices:
      return write_indices(out, mesh.required_points);
    case kRequiredEdges:
      return write_indices(out, mesh.required_edges);
    case kRequiredTriangles:
      return write_indices(out, mesh.required_triangles);
    case kVerticesOnNodes:
      return write_nodes(out, mesh.association);
    case kVerticesOnEdges:
      return write_edges(out, mesh.association);
    case kVerticesOnFaces:
      return write_faces(out, mesh.association);
    case kByteFlow:
      return write_model(out, mesh.association, model_in_words);
    default:
      throw std::logic_error("write_gmf_mesh: a section without rows");
  }
}

/// What the two sections of communicators need beside those of the mesh.
void add_communicator_shapes(std::span<const GmfCommunicator> communicators,
                             std::vector<SectionShape>& shapes) {
  std::uint64_t points = 0;
  for (const GmfCommunicator& communicator : communicators) points += communicator.points.size();
  shapes.push_back({kParallelVertexCommunicators, communicators.size(), 0, 2});
  shapes.push_back({kParallelCommunicatorVertices, points, 0, 3, {}, false});
}

template <class Writer>
void write_row(Writer& out, std::initializer_list<std::int64_t> numbers) {
  for (const std::int64_t number : numbers) out.index(number);
  out.end_row();
}

/// Parts and communicators count from 0, vertices from 1.
template <class Writer>
void write_communicators(Writer& out, std::span<const GmfCommunicator> communicators, Keyword code) {
  for (std::size_t c = 0; c < communicators.size(); ++c) {
    const auto& [part, points, global] = communicators[c];
    if (code == kParallelVertexCommunicators)
      write_row(out, {part, static_cast<std::int64_t>(points.size())});
    for (std::size_t i = 0; code == kParallelCommunicatorVertices && i < points.size(); ++i)
      write_row(out, {std::int64_t{points[i]} + 1, static_cast<std::int64_t>(global[i]) + 1,
                      static_cast<std::int64_t>(c)});
  }
}

/// A file of these sections, whose rows write_rows(writer, keyword) writes.
template <class WriteRows>
void write_file(const std::filesystem::path& path, int version, const std::vector<SectionShape>& shapes,
                const WriteRows& write_rows) {
  version = choose_version(path.string(), version, shapes);
  AtomicFile file(path);
  const auto write_with = [&](auto&& out) {
    out.header();
    for (const SectionShape& shape : shapes) {
      out.begin_section(shape);
      write_rows(out, shape.code);
    }
    out.end();
  };
  if (is_text(path)) {
    write_with(TextWriter<AtomicFile>(file, version));
  } else {
    write_with(BinaryWriter<AtomicFile>(path.string(), file, version));
  }
  file.commit();
}

}  // namespace

MeshContents read_gmf(const std::filesystem::path& path, Coordinates wanted) {
  return is_text(path) ? read_contents_of(TextFile(path), wanted)
                       : read_contents_of(BinaryFile(path), wanted);
}

MeshData read_gmf_mesh(const std::filesystem::path& path, Coordinates wanted) {
  return read_gmf(path, wanted).mesh;
}

SolutionData read_gmf_solution(const std::filesystem::path& path) {
  return is_text(path) ? read_solution_rows(TextFile(path), all_rows)
                       : read_solution_rows(BinaryFile(path), all_rows);
}

void write_gmf_mesh(const std::filesystem::path& path, const MeshData& mesh, int version) {
  check_lengths(mesh);
  if (version == 1 && !is_text(path)) refuse_if_rounding_breaks(mesh, path.string());
  const MeshCounts counts = counts_of(mesh, is_text(path));
  write_file(path, version, mesh_shapes(counts),
             [&](auto& out, Keyword code) { write_section_rows(out, mesh, code, counts.model_in_words); });
}

void write_gmf_part(const std::filesystem::path& path, const MeshData& mesh,
                    std::span<const GmfCommunicator> communicators, int version) {
  check_lengths(mesh);
  if (version == 1 && !is_text(path)) refuse_if_rounding_breaks(mesh, path.string());
  const MeshCounts counts = counts_of(mesh, is_text(path));
  std::vector<SectionShape> shapes = mesh_shapes(counts);
  add_communicator_shapes(communicators, shapes);
  write_file(path, version, shapes, [&](auto& out, Keyword code) {
    const bool of_mesh = code != kParallelVertexCommunicators && code != kParallelCommunicatorVertices;
    if (of_mesh) return write_section_rows(out, mesh, code, counts.model_in_words);
    write_communicators(out, communicators, code);
  });
}

void write_gmf_solution(const std::filesystem::path& path, const SolutionData& solution, int version) {
  write_file(path, version, {solution_shape(solution.num_points, kinds_of(solution))},
             [&](auto& out, Keyword) { write_solution_rows(out, solution); });
}

}  // namespace weft::meshing
