// VTU as XML that describes arrays, and behind it the arrays as raw bytes ("appended" data).
#include "meshing/io/vtu.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

#include "meshing/io/atomic_file.h"

namespace weft::meshing {
namespace {

constexpr std::uint8_t kVtkTetra = 10;
/// Position in a GMF tensor (xx xy yy xz yz zz) of each component of a VTK tensor (xx yy zz xy yz xz).
constexpr std::array<std::size_t, 6> kVtkTensorOrder = {0, 2, 5, 1, 4, 3};

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// Describes arrays one after another, counting where in the appended data each begins.
class Header {
 public:
  void text(const std::string& line) { xml_ += line + "\n"; }
  void array(const std::string& type, const std::string& name, int num_components, std::uint64_t bytes) {
    xml_ += "<DataArray type=\"" + type + "\" Name=\"" + escaped(name) + "\" NumberOfComponents=\"" +
            std::to_string(num_components) + "\" format=\"appended\" offset=\"" + std::to_string(offset_) +
            "\"/>\n";
    offset_ += sizeof(std::uint64_t) + bytes;
  }
  const std::string& xml() const { return xml_; }

 private:
  std::string xml_;
  std::uint64_t offset_ = 0;
};

std::string describe(const MeshData& mesh, const SolutionData* fields) {
  const std::uint64_t num_points = mesh.points.size(), num_tets = mesh.tets.size();
  Header h;
  h.text("<?xml version=\"1.0\"?>");
  h.text(
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">");
  h.text("<UnstructuredGrid>");
  h.text("<Piece NumberOfPoints=\"" + std::to_string(num_points) + "\" NumberOfCells=\"" +
         std::to_string(num_tets) + "\">");
  h.text("<Points>");
  h.array("Float64", "Points", 3, num_points * sizeof(Point));
  h.text("</Points>\n<Cells>");
  h.array("Int64", "connectivity", 1, num_tets * 4 * sizeof(std::int64_t));
  h.array("Int64", "offsets", 1, num_tets * sizeof(std::int64_t));
  h.array("UInt8", "types", 1, num_tets);
  h.text("</Cells>\n<CellData Scalars=\"ref\">");
  h.array("Int32", "ref", 1, num_tets * sizeof(std::int32_t));
  h.text("</CellData>\n<PointData>");
  for (std::size_t i = 0; fields && i < fields->fields.size(); ++i) {
    const Field& field = fields->fields[i];
    h.array("Float64", field.name.empty() ? "field_" + std::to_string(i + 1) : field.name,
            components(field.kind), field.values.size() * sizeof(double));
  }
  h.text("</PointData>\n</Piece>\n</UnstructuredGrid>");
  return h.xml();
}

void append_cells(AtomicFile& out, const MeshData& mesh) {
  const std::uint64_t num_tets = mesh.tets.size();
  out.write_value<std::uint64_t>(num_tets * 4 * sizeof(std::int64_t));
  for (const auto& tet : mesh.tets) {
    for (const std::uint32_t vertex : tet) out.write_value<std::int64_t>(vertex);
  }
  out.write_value<std::uint64_t>(num_tets * sizeof(std::int64_t));
  for (std::uint64_t i = 1; i <= num_tets; ++i)
    out.write_value<std::int64_t>(static_cast<std::int64_t>(4 * i));
  out.write_value<std::uint64_t>(num_tets);
  for (std::uint64_t i = 0; i < num_tets; ++i) out.write_value(kVtkTetra);
  out.write_value<std::uint64_t>(num_tets * sizeof(std::int32_t));
  out.write(mesh.tet_refs.data(), num_tets * sizeof(std::int32_t));
}

void append_field(AtomicFile& out, const Field& field) {
  out.write_value<std::uint64_t>(field.values.size() * sizeof(double));
  if (field.kind != Field::Kind::tensor) {
    out.write(field.values.data(), field.values.size() * sizeof(double));
    return;
  }
  for (std::size_t i = 0; i < field.values.size(); i += kVtkTensorOrder.size()) {
    for (const std::size_t component : kVtkTensorOrder) out.write_value(field.values[i + component]);
  }
}

void check_lengths(const MeshData& mesh, const SolutionData* fields) {
  if (mesh.tet_refs.size() != mesh.tets.size()) {
    throw std::logic_error("write_vtu: the tets and their references differ in length");
  }
  if (!fields) return;
  for (const Field& field : fields->fields) {
    if (field.values.size() != mesh.points.size() * static_cast<std::size_t>(components(field.kind))) {
      throw std::logic_error("write_vtu: a field's values do not match the number of points");
    }
  }
}

}  // namespace

void write_vtu(const std::filesystem::path& path, const MeshData& mesh, const SolutionData* fields) {
  static_assert(sizeof(Point) == 3 * sizeof(double), "points are written as they lie in memory");
  check_lengths(mesh, fields);
  AtomicFile out(path);
  out.write(describe(mesh, fields));
  // The underscore marks where the counting of offsets begins.
  out.write("<AppendedData encoding=\"raw\">\n_");
  out.write_value<std::uint64_t>(mesh.points.size() * sizeof(Point));
  out.write(mesh.points.data(), mesh.points.size() * sizeof(Point));
  append_cells(out, mesh);
  if (fields) {
    for (const Field& field : fields->fields) append_field(out, field);
  }
  out.write("\n</AppendedData>\n</VTKFile>\n");
  out.commit();
}

}  // namespace weft::meshing
