// Writes parts of one binary GMF file, by as many writers as hold parts of the mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "meshing/io/files/file_part.h"
#include "meshing/io/gmf/gmf_format.h"
#include "meshing/io/gmf/gmf_writer.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

namespace gmf {
/// A vertex on an entity of a CAD model: Association's records with a number of the whole mesh.
struct ModelRow {
  std::uint64_t vertex;
  std::int32_t id;
  std::array<double, 3> reals;  ///< as many as the section's rows have
};
}  // namespace gmf

/// What one file will be: its version and the places of its sections. It follows from the counts of the whole
/// mesh alone, so that all writers have the same. Files are those of write_gmf_mesh and write_gmf_solution.
class GmfPlan {
 public:
  /// `name`: of the file, for messages. Version 0 chooses as write_gmf_mesh does; throws InputError where an
  /// explicit one cannot hold the sections, and for a text file, whose rows have no fixed places.
  static GmfPlan of_mesh(const std::filesystem::path& name, const gmf::MeshCounts& counts, int version = 0);
  static GmfPlan of_solution(const std::filesystem::path& name, std::uint64_t num_points,
                             const std::vector<Field::Kind>& fields, int version = 0);

  const std::string& name() const { return name_; }
  int version() const { return version_; }
  std::span<const gmf::SectionShape> sections() const { return shapes_; }
  /// Where the row is or, one behind the last, where the section ends. Throws std::out_of_range for rows that
  /// the section does not have, and for a section that the file does not have.
  std::uint64_t row_position(gmf::Keyword section, std::uint64_t row) const;

 private:
  GmfPlan(const std::filesystem::path& name, std::vector<gmf::SectionShape> shapes, int version);

  std::string name_;
  int version_;
  std::vector<gmf::SectionShape> shapes_;
};

/// One writer. Rows are numbered from 0 in the whole file; those that nobody writes are undefined. References
/// have the length of their entities; numbers of vertices, edges and triangles are 0-based in the whole mesh.
/// Throws InputError when writing fails and std::out_of_range for rows that the plan does not have.
class GmfSliceWriter {
 public:
  /// `file` exists, and becomes the one that the plan names when all have written.
  GmfSliceWriter(const std::filesystem::path& file, const GmfPlan& plan);

  /// All that is no row: to be written by one of the writers.
  void frame();
  void vertices(std::uint64_t first, std::span<const Point> points, std::span<const std::int32_t> refs);
  template <std::size_t N>
  void elements(gmf::Keyword section, std::uint64_t first,
                const std::vector<std::array<std::uint64_t, N>>& elements,
                const std::vector<std::int32_t>& refs) {
    if (!begin_rows(section, first, elements.size())) return;
    gmf::write_elements(out_, elements, refs);
  }
  void indices(gmf::Keyword section, std::uint64_t first, const std::vector<std::uint64_t>& indices);
  void on_model(gmf::Keyword section, std::uint64_t first, const std::vector<gmf::ModelRow>& rows);
  /// The CAD model that the file carries, whole: by one of the writers.
  void model(const Association& carried);
  void solution(std::uint64_t first, const SolutionData& part);
  /// Everything to the disk. Nothing may be written afterwards.
  void finish() { file_.finish(); }

 private:
  bool begin_rows(gmf::Keyword section, std::uint64_t first, std::uint64_t count);

  const GmfPlan& plan_;
  FilePart file_;
  gmf::BinaryWriter<FilePart> out_;
};

}  // namespace weft::meshing
