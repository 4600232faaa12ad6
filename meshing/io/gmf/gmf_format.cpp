// Tables and sums: what the format fixes and what follows from it.
#include "meshing/io/gmf/gmf_format.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "meshing/base/error.h"

namespace weft::meshing {
namespace gmf {
namespace {

/// The largest entity count that 32-bit ids with one invalid value can number.
constexpr std::uint64_t kMaxEntities = 0xFFFFFFFEu;

constexpr KeywordInfo kKeywords[] = {
    {kVertices, "Vertices", 3, 1},
    {kEdges, "Edges", 0, 3},
    {kTriangles, "Triangles", 0, 4},
    {kTetrahedra, "Tetrahedra", 0, 5},
    {kCorners, "Corners", 0, 1},
    {kRidges, "Ridges", 0, 1},
    {kRequiredVertices, "RequiredVertices", 0, 1},
    {kRequiredEdges, "RequiredEdges", 0, 1},
    {kRequiredTriangles, "RequiredTriangles", 0, 1},
    {kVerticesOnNodes, "VerticesOnGeometricVertices", 0, 2},
    {kVerticesOnEdges, "VerticesOnGeometricEdges", 2, 2},
    {kVerticesOnFaces, "VerticesOnGeometricTriangles", 3, 2},
    {kByteFlow, "ByteFlow"},
    {kSolAtVertices, "SolAtVertices"},
    {7, "Quadrilaterals", 0, 0, false, "quadrilaterals"},
    {24, "TrianglesP2", 0, 0, false, "triangles of second order"},
    {25, "EdgesP2", 0, 0, false, "edges of second order"},
    {27, "QuadrilateralsQ2", 0, 0, false, "quadrilaterals of second order"},
    {88, "QuadrilateralsQ3", 0, 0, false, "quadrilaterals of third order"},
    {89, "QuadrilateralsQ4", 0, 0, false, "quadrilaterals of fourth order"},
    {90, "TrianglesP3", 0, 0, false, "triangles of third order"},
    {91, "TrianglesP4", 0, 0, false, "triangles of fourth order"},
    {92, "EdgesP3", 0, 0, false, "edges of third order"},
    {93, "EdgesP4", 0, 0, false, "edges of fourth order"},
    {9, "Prisms", 0, 0, true},
    {10, "Hexahedra", 0, 0, true},
    {30, "TetrahedraP2", 0, 0, true},
    {33, "HexahedraQ2", 0, 0, true},
    {46, "Polyhedra", 0, 0, true},
    {49, "Pyramids", 0, 0, true},
    {86, "PrismsP2", 0, 0, true},
    {87, "PyramidsP2", 0, 0, true},
    {96, "TetrahedraP3", 0, 0, true},
    {97, "TetrahedraP4", 0, 0, true},
    {98, "HexahedraQ3", 0, 0, true},
    {99, "HexahedraQ4", 0, 0, true},
    {100, "PyramidsP3", 0, 0, true},
    {101, "PyramidsP4", 0, 0, true},
    {102, "PrismsP3", 0, 0, true},
    {103, "PrismsP4", 0, 0, true},
    {200, "Prisms9", 0, 0, true},
    {201, "Hexahedra12", 0, 0, true},
    {207, "PolyhedraHeaders", 0, 0, true},
};

template <class Key>
const KeywordInfo* find_by(Key KeywordInfo::*member, const Key& key) {
  const auto found = std::ranges::find(kKeywords, key, member);
  return found == std::end(kKeywords) ? nullptr : found;
}

std::uint64_t written_size(const Encoding& encoding, const std::vector<SectionShape>& shapes) {
  std::uint64_t size = header_size(encoding) + 4 + encoding.position_size();  // with the keyword End
  for (const SectionShape& shape : shapes) size += section_size(encoding, shape);
  return size;
}

/// libMeshb's layout has the length in front of its words.
std::uint64_t model_rows(std::uint64_t bytes, bool in_words) {
  return !in_words || bytes == 0 ? bytes : 1 + (bytes + 3) / 4;
}

bool version_holds(int version, const std::vector<SectionShape>& shapes) {
  const auto count_fits = [](const SectionShape& shape) { return shape.count <= kMaxInt32; };
  if (version < 4 && !std::ranges::all_of(shapes, count_fits)) return false;
  return version >= 3 || written_size(Encoding(version), shapes) <= kMaxInt32;
}

}  // namespace

const KeywordInfo* find_keyword(std::int32_t code) { return find_by(&KeywordInfo::code, code); }
const KeywordInfo* find_keyword(std::string_view name) { return find_by(&KeywordInfo::name, name); }
std::string_view keyword_name(Keyword code) {
  if (code == kParallelVertexCommunicators) return "ParallelVertexCommunicators";
  if (code == kParallelCommunicatorVertices) return "ParallelCommunicatorVertices";
  return find_keyword(code)->name;
}

void check_range(const Section& section, RowRange rows) {
  if (rows.first <= section.count && rows.count <= section.count - rows.first) return;
  throw std::out_of_range("GMF: rows " + std::to_string(rows.first) + " to " +
                          std::to_string(rows.first + rows.count) + " of " +
                          std::string(section.keyword->name));
}

void check_dimension(const std::string& file, std::int64_t dimension) {
  if (dimension == 2) throw InputError(file, "Dimension", "the mesh is two-dimensional; weft adapts volumes");
  if (dimension != 3) throw InputError(file, "Dimension", std::to_string(dimension) + " instead of 3");
}

bool is_text(const std::filesystem::path& path) {
  return path.extension() == ".mesh" || path.extension() == ".sol";
}

bool is_mesh(const std::filesystem::path& path) {
  return path.extension() == ".meshb" || path.extension() == ".mesh";
}

std::uint64_t section_head_size(const Encoding& encoding, const SectionShape& shape) {
  const bool solution = shape.code == kSolAtVertices;
  return 4 + encoding.position_size() + (shape.counted ? encoding.index_size() : 0) +
         (solution ? 4 * (1 + shape.field_types.size()) : 0);
}

std::uint64_t section_size(const Encoding& encoding, const SectionShape& shape) {
  return section_head_size(encoding, shape) +
         shape.count * (shape.bytes + encoding.row_size(shape.reals, shape.indices));
}

std::uint64_t header_size(const Encoding& encoding) { return 8 + 4 + encoding.position_size() + 4; }

MeshCounts counts_of(const MeshData& mesh, bool text) {
  const bool in_words = text || mesh.association.model_in_words;
  return {mesh.points.size(),
          mesh.edges.size(),
          mesh.triangles.size(),
          mesh.tets.size(),
          mesh.corners.size(),
          mesh.ridges.size(),
          mesh.required_points.size(),
          mesh.required_edges.size(),
          mesh.required_triangles.size(),
          mesh.association.nodes.size(),
          mesh.association.edges.size(),
          mesh.association.faces.size(),
          model_rows(mesh.association.model.size(), in_words),
          in_words};
}

std::vector<SectionShape> mesh_shapes(const MeshCounts& counts) {
  const std::pair<Keyword, std::uint64_t> sections[] = {{kVertices, counts.points},
                                                        {kEdges, counts.edges},
                                                        {kTriangles, counts.triangles},
                                                        {kTetrahedra, counts.tets},
                                                        {kCorners, counts.corners},
                                                        {kRidges, counts.ridges},
                                                        {kRequiredVertices, counts.required_points},
                                                        {kRequiredEdges, counts.required_edges},
                                                        {kRequiredTriangles, counts.required_triangles},
                                                        {kVerticesOnNodes, counts.on_nodes},
                                                        {kVerticesOnEdges, counts.on_edges},
                                                        {kVerticesOnFaces, counts.on_faces}};
  std::vector<SectionShape> shapes;
  for (const auto& [code, count] : sections) {
    if (count == 0 && code != kVertices) continue;
    const KeywordInfo* keyword = find_keyword(code);
    shapes.push_back({code, count, keyword->reals, keyword->indices});
  }
  if (counts.model_rows > 0)
    shapes.push_back({kByteFlow,
                      counts.model_rows,
                      0,
                      counts.model_in_words ? 1u : 0u,
                      {},
                      true,
                      counts.model_in_words ? 0u : 1u});
  return shapes;
}

SectionShape solution_shape(std::uint64_t num_points, const std::vector<Field::Kind>& fields) {
  if (fields.empty()) throw std::logic_error("GMF: there is no field to write");
  SectionShape shape{kSolAtVertices, num_points, 0, 0};
  for (const Field::Kind kind : fields) {
    shape.reals += static_cast<std::size_t>(components(kind));
    shape.field_types.push_back(static_cast<std::int32_t>(kind));
  }
  return shape;
}

std::vector<Field::Kind> kinds_of(const SolutionData& solution) {
  std::vector<Field::Kind> kinds;
  for (const Field& field : solution.fields) {
    if (field.values.size() != solution.num_points * static_cast<std::size_t>(components(field.kind))) {
      throw std::logic_error("GMF: a field's values do not match the number of points");
    }
    kinds.push_back(field.kind);
  }
  return kinds;
}

void check_size(const std::string& file, const GmfLayout& layout, std::uint64_t size) {
  if (size != layout.file_size) throw InputError(file, "", "the file was changed while it was read");
}

int choose_version(const std::string& file, int wanted, const std::vector<SectionShape>& shapes) {
  if (wanted == 0) return version_holds(2, shapes) ? 2 : version_holds(3, shapes) ? 3 : 4;
  if (wanted < 1 || wanted > 4) {
    throw InputError(file, "", "cannot write GMF version " + std::to_string(wanted) + " (1 to 4 exist)");
  }
  if (!version_holds(wanted, shapes)) {
    throw InputError(file, "", "too large for GMF version " + std::to_string(wanted));
  }
  return wanted;
}

}  // namespace gmf

const gmf::Section* GmfLayout::find(gmf::Keyword code) const {
  const auto found =
      std::ranges::find(sections_, code, [](const gmf::Section& section) { return section.keyword->code; });
  return found == sections_.end() ? nullptr : &*found;
}

std::uint64_t GmfLayout::count(gmf::Keyword code) const {
  const gmf::Section* section = find(code);
  return section ? section->count : 0;
}

void GmfLayout::add(const std::string& file, const gmf::Section& section) {
  const std::string name(section.keyword->name);
  if (find(static_cast<gmf::Keyword>(section.keyword->code))) throw InputError(file, name, "appears twice");
  if (section.count > gmf::kMaxEntities) {
    throw InputError(
        file, name,
        std::to_string(section.count) + " entities exceed the limit of " + std::to_string(gmf::kMaxEntities));
  }
  sections_.push_back(section);
}

void GmfLayout::refuse_foreign_volumes(const std::string& file) const {
  for (const gmf::Section& section : sections_) {
    if (!section.keyword->foreign_volume || section.count == 0) continue;
    throw InputError(
        file, std::string(section.keyword->name),
        "the mesh has " + std::to_string(section.count) + " of them; weft adapts linear tetrahedra only");
  }
}

std::vector<Dropped> GmfLayout::dropped() const {
  std::vector<Dropped> dropped;
  for (const gmf::Section& section : sections_)
    if (section.keyword->dropped && section.count > 0)
      dropped.push_back({section.keyword->dropped, section.count});
  return dropped;
}

}  // namespace weft::meshing
