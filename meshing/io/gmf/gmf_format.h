// The Gamma Mesh Format itself, as its readers and writers share it: keywords, encodings, where rows lie.
// Facts of the format follow libMeshb (https://github.com/LoicMarechal/libMeshb).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {
namespace gmf {

inline constexpr std::int64_t kMaxInt32 = std::numeric_limits<std::int32_t>::max();

enum Keyword : std::int32_t {
  kDimension = 3,
  kVertices = 4,
  kEdges = 5,
  kTriangles = 6,
  kTetrahedra = 8,
  kCorners = 13,
  kRidges = 14,
  kRequiredVertices = 15,
  kRequiredEdges = 16,
  kRequiredTriangles = 17,
  kVerticesOnNodes = 40,  ///< VerticesOnGeometricVertices, ...Edges, ...Triangles
  kVerticesOnEdges = 41,
  kVerticesOnFaces = 42,
  kEnd = 54,
  kSolAtVertices = 62,
  kParallelVertexCommunicators = 71,  ///< ParMmg's; written, not read
  kParallelCommunicatorVertices = 73,
  kByteFlow = 126,  ///< a CAD model; refine and libMeshb lay it out differently, see gmf_association.h
  kFloatingPointPrecision = 155,
};

/// A keyword that means something here; others are skipped.
struct KeywordInfo {
  std::int32_t code;
  std::string_view name;
  std::size_t reals = 0, indices = 0;  ///< in a row; of a solution the file says it
  bool foreign_volume = false;         ///< volume elements that a tetrahedral mesh cannot keep
  const char* dropped = nullptr;       ///< what other elements without a place here are called
};

/// nullptr for a keyword without a meaning here.
const KeywordInfo* find_keyword(std::int32_t code);
const KeywordInfo* find_keyword(std::string_view name);
std::string_view keyword_name(Keyword code);

/// How numbers are stored: sizes in bytes by version, and the byte order.
struct Encoding {
  int version = 2;
  bool swapped = false;
  std::size_t real_size = 8;

  explicit Encoding(int v = 2, bool s = false) : version(v), swapped(s), real_size(v == 1 ? 4 : 8) {}
  std::size_t index_size() const { return version >= 4 ? 8 : 4; }
  std::size_t position_size() const { return version >= 3 ? 8 : 4; }
  std::uint64_t row_size(std::size_t reals, std::size_t indices) const {
    return reals * real_size + indices * index_size();
  }
};

/// Where the rows of one keyword lie in the file.
struct Section {
  const KeywordInfo* keyword;
  std::uint64_t count;       ///< rows it claims to have
  std::uint64_t begin, end;  ///< bytes, from behind the count to the next keyword
};

/// Some rows of a section.
struct RowRange {
  std::uint64_t first, count;
};
inline RowRange all_rows(const Section& section) { return {0, section.count}; }
/// Throws std::out_of_range for rows that the section does not have.
void check_range(const Section& section, RowRange rows);

/// Throws InputError unless the file's dimension is 3.
void check_dimension(const std::string& file, std::int64_t dimension);

bool is_text(const std::filesystem::path& path);
/// .meshb or .mesh.
bool is_mesh(const std::filesystem::path& path);

}  // namespace gmf

/// What a file claims to hold and where it lies there: all that is needed to read any part of it.
class GmfLayout {
 public:
  std::uint64_t num_points() const { return count(gmf::kVertices); }
  std::uint64_t num_tets() const { return count(gmf::kTetrahedra); }
  std::uint64_t num_triangles() const { return count(gmf::kTriangles); }
  std::uint64_t num_edges() const { return count(gmf::kEdges); }
  /// Vertices that the solution in the file has values for.
  std::uint64_t num_solution_points() const { return count(gmf::kSolAtVertices); }

  const gmf::Section* find(gmf::Keyword code) const;
  const std::vector<gmf::Section>& sections() const { return sections_; }
  /// Throws InputError for a keyword that comes twice or has more entities than ids can number.
  void add(const std::string& file, const gmf::Section& section);
  /// Throws InputError where the file has volume elements other than linear tets.
  void refuse_foreign_volumes(const std::string& file) const;
  /// Elements that are no volumes and have no place in a mesh.
  std::vector<Dropped> dropped() const;

  gmf::Encoding encoding;       ///< of a binary file
  std::uint64_t file_size = 0;  ///< bytes

 private:
  std::uint64_t count(gmf::Keyword code) const;

  std::vector<gmf::Section> sections_;  ///< those that mean something here, each at most once
};

namespace gmf {

/// Throws InputError when a file's size is not that of its layout.
void check_size(const std::string& file, const GmfLayout& layout, std::uint64_t size);

/// The rows of one section to be written.
struct SectionShape {
  Keyword code;
  std::uint64_t count;
  std::size_t reals, indices;                  ///< a row
  std::vector<std::int32_t> field_types = {};  ///< of a solution
  bool counted = true;                         ///< the rows follow their count
  std::size_t bytes = 0;                       ///< a row, where it is neither reals nor indices
};

/// Bytes from a section's keyword to its first row, and to the next keyword.
std::uint64_t section_head_size(const Encoding& encoding, const SectionShape& shape);
std::uint64_t section_size(const Encoding& encoding, const SectionShape& shape);
/// Bytes in front of the first section: code, version and Dimension.
std::uint64_t header_size(const Encoding& encoding);

/// Counts of the entities of a mesh.
struct MeshCounts {
  std::uint64_t points = 0, edges = 0, triangles = 0, tets = 0, corners = 0, ridges = 0, required_points = 0,
                required_edges = 0, required_triangles = 0;
  std::uint64_t on_nodes = 0, on_edges = 0, on_faces = 0;  ///< records of Association
  std::uint64_t model_rows = 0;                            ///< of ByteFlow: bytes, or words
  bool model_in_words = false;
};
/// A text file holds a model in words only.
MeshCounts counts_of(const MeshData& mesh, bool text = false);
/// The sections a mesh needs, in the order of the file. Empty ones are left out, except the vertices without
/// which nothing reads it.
std::vector<SectionShape> mesh_shapes(const MeshCounts& counts);
/// The one section of a solution with such fields, at least one.
SectionShape solution_shape(std::uint64_t num_points, const std::vector<Field::Kind>& fields);
/// The kinds of a solution's fields. Throws std::logic_error where values and number of points differ.
std::vector<Field::Kind> kinds_of(const SolutionData& solution);

/// The version to write: the wanted one, or for 0 the one that most programs read. Throws InputError naming
/// `file` where the wanted one does not exist or cannot hold the sections.
int choose_version(const std::string& file, int wanted, const std::vector<SectionShape>& shapes);

}  // namespace gmf
}  // namespace weft::meshing
