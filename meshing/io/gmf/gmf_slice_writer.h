// Writes parts of one GMF file, by as many writers as hold parts of the mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "meshing/io/files/file_part.h"
#include "meshing/io/files/text_output.h"
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

/// What one file will be: its version and its sections, and their places where it is binary. It follows from
/// the counts of the whole mesh alone, so that all writers have the same. Files are those of write_gmf_mesh
/// and write_gmf_solution.
class GmfPlan {
 public:
  /// `name`: of the file, for messages. Version 0 chooses as write_gmf_mesh does; throws InputError where an
  /// explicit one cannot hold the sections.
  static GmfPlan of_mesh(const std::filesystem::path& name, const gmf::MeshCounts& counts, int version = 0);
  static GmfPlan of_solution(const std::filesystem::path& name, std::uint64_t num_points,
                             const std::vector<Field::Kind>& fields, int version = 0);

  const std::string& name() const { return name_; }
  bool is_text() const { return text_; }
  int version() const { return version_; }
  std::span<const gmf::SectionShape> sections() const { return shapes_; }
  /// Of a binary file, where the row is or, one behind the last, where the section ends. Throws
  /// std::out_of_range for rows that the section does not have, and for a section that the file does not
  /// have.
  std::uint64_t row_position(gmf::Keyword section, std::uint64_t row) const;
  /// Of a text file: what stands before the rows of each section, and behind all of them.
  std::vector<std::string> text_heads() const;

 private:
  GmfPlan(const std::filesystem::path& name, std::vector<gmf::SectionShape> shapes, int version);

  std::string name_;
  bool text_;
  int version_;
  std::vector<gmf::SectionShape> shapes_;
};

/// One writer. Rows are numbered from 0 in the whole file; those that nobody writes are undefined. References
/// have the length of their entities; numbers of vertices, edges and triangles are 0-based in the whole mesh.
/// Throws InputError when writing fails and std::out_of_range for rows that the plan does not have.
///
/// Rows of text have no places until the length of those before them is known. So they are written twice: to
/// a writer without a file, for their lengths, and to one that is told the places that follow.
class GmfSliceWriter {
 public:
  /// The target's file exists, and becomes the one that the plan names when all have written.
  GmfSliceWriter(PartTarget target, const GmfPlan& plan);
  /// Of a text file: measures rows only.
  explicit GmfSliceWriter(const GmfPlan& plan);

  /// Of a text file: where the next row of each section goes. Rows of a section must come in their order.
  void set_text_places(std::vector<std::uint64_t> places) { text_places_ = std::move(places); }
  const std::vector<std::uint64_t>& text_places() const { return text_places_; }

  /// All that is no row: to be written by one of the writers. `heads`: of a text file, the places of
  /// text_heads().
  void frame(std::span<const std::uint64_t> heads = {});
  void vertices(std::uint64_t first, std::span<const Point> points, std::span<const std::int32_t> refs);
  template <std::size_t N>
  void elements(gmf::Keyword section, std::uint64_t first,
                const std::vector<std::array<std::uint64_t, N>>& elements,
                std::span<const std::int32_t> refs) {
    write(section, first, elements.size(), [&](auto& out) { gmf::write_elements(out, elements, refs); });
  }
  void indices(gmf::Keyword section, std::uint64_t first, const std::vector<std::uint64_t>& indices);
  void on_model(gmf::Keyword section, std::uint64_t first, const std::vector<gmf::ModelRow>& rows);
  /// The CAD model that the file carries, whole: by one of the writers.
  void model(const Association& carried);
  void solution(std::uint64_t first, const SolutionData& part);
  /// Everything to the disk. Nothing may be written afterwards.
  void finish() { file_->finish(); }

 private:
  template <class Rows>
  void write(gmf::Keyword section, std::uint64_t first, std::uint64_t count, const Rows& rows) {
    if (count == 0) return;  // the file may lack the section
    if (!plan_.is_text()) {
      seek_rows(section, first, count);
      return rows(*binary_);
    }
    TextInMemory text;
    gmf::TextWriter<TextInMemory> out(text, plan_.version());
    rows(out);
    put_text(section, text.text);
  }
  void seek_rows(gmf::Keyword section, std::uint64_t first, std::uint64_t count);
  void put_text(gmf::Keyword section, const std::string& rows);

  const GmfPlan& plan_;
  std::unique_ptr<FilePart> file_;  ///< none: rows are measured
  std::optional<gmf::BinaryWriter<FilePart>> binary_;
  std::vector<std::uint64_t> text_places_;
};

}  // namespace weft::meshing
