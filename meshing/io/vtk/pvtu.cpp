// The index, and the cutting of a mesh into pieces.
#include "meshing/io/vtk/pvtu.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <list>
#include <string>
#include <utility>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/vtk/vtk_xml.h"
#include "meshing/io/vtk/vtu.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

/// The part of a mesh that one piece gets, with the points that it uses.
class Share {
 public:
  Share(const MeshView& whole, std::size_t piece, std::size_t num_pieces,
        const std::vector<std::uint32_t>& first_points)
      : whole_(whole), piece_(piece), num_pieces_(num_pieces), numbers_(whole.mesh.points.size(), kUnused) {
    const MeshData& from = whole.mesh;
    MeshData& to = part_.mesh;
    for (const std::uint32_t v : first_points) number(v);
    take(from.tets, from.tet_refs, to.tets, to.tet_refs);
    take(from.triangles, from.triangle_refs, to.triangles, to.triangle_refs);
    take(from.edges, from.edge_refs, to.edges, to.edge_refs);
    for (std::size_t i = begin(from.corners.size()); i < end(from.corners.size()); ++i) {
      to.corners.push_back(number(from.corners[i]));
    }
    take_fields();
  }

  const MeshContents& contents() const { return part_; }
  const std::vector<std::int64_t>& global_ids() const { return ids_; }

 private:
  static constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

  std::size_t begin(std::size_t n) const { return n * piece_ / num_pieces_; }
  std::size_t end(std::size_t n) const { return n * (piece_ + 1) / num_pieces_; }

  std::uint32_t number(std::uint32_t v) {
    if (numbers_[v] == kUnused) {
      numbers_[v] = static_cast<std::uint32_t>(ids_.size());
      ids_.push_back(v);
      part_.mesh.points.push_back(whole_.mesh.points[v]);
      part_.mesh.point_refs.push_back(whole_.mesh.point_refs[v]);
    }
    return numbers_[v];
  }

  template <class Elements>
  void take(const Elements& from, const std::vector<std::int32_t>& from_refs, Elements& to,
            std::vector<std::int32_t>& to_refs) {
    for (std::size_t i = begin(from.size()); i < end(from.size()); ++i) {
      auto element = from[i];
      for (std::uint32_t& v : element) v = number(v);
      to.push_back(element);
      to_refs.push_back(from_refs[i]);
    }
  }

  void take_fields() {
    part_.fields = {ids_.size(), {}};
    for (const Field& field : whole_.fields.fields) {
      Field& part = part_.fields.fields.emplace_back(Field{field.kind, {}, field.name});
      const auto length = static_cast<std::size_t>(components(field.kind));
      for (const std::int64_t id : ids_) {
        const auto first =
            field.values.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(id) * length);
        part.values.insert(part.values.end(), first, first + static_cast<std::ptrdiff_t>(length));
      }
    }
  }

  const MeshView& whole_;
  std::size_t piece_, num_pieces_;
  MeshContents part_;
  std::vector<std::uint32_t> numbers_;  ///< in the piece, of the points of the whole
  std::vector<std::int64_t> ids_;       ///< the other way round
};

template <class Elements>
void mark_used(const Elements& elements, std::vector<bool>& used) {
  for (const auto& element : elements) {
    for (const std::uint32_t v : element) used[v] = true;
  }
}

/// The points with which the first piece begins: those of no element, but all where it is the only one.
std::vector<std::uint32_t> first_points(const MeshData& mesh, std::size_t num_pieces) {
  std::vector<bool> used(mesh.points.size());
  if (num_pieces > 1) {
    mark_used(mesh.tets, used);
    mark_used(mesh.triangles, used);
    mark_used(mesh.edges, used);
  }
  std::vector<std::uint32_t> points;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (!used[v]) points.push_back(v);
  }
  return points;
}

std::string index_text(const SolutionData& fields, bool point_refs, const std::vector<std::string>& cell_data,
                       const std::vector<std::string>& pieces) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">\n"
      "<PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints>\n"
      "<PCellData Scalars=\"ref\"><PDataArray type=\"Int32\" Name=\"ref\"/>";
  for (const std::string& name : cell_data)
    xml += "<PDataArray type=\"Float64\" Name=\"" + VtkWriter::escaped(name) + "\"/>";
  xml +=
      "</PCellData>\n"
      "<PPointData GlobalIds=\"GlobalPointIds\">\n<PDataArray type=\"Int64\" Name=\"GlobalPointIds\"/>\n";
  if (point_refs) xml += "<PDataArray type=\"Int32\" Name=\"ref\"/>\n";
  const std::vector<std::string> names = field_array_names(fields, true, point_refs);
  for (std::size_t i = 0; i < names.size(); ++i) {
    xml += "<PDataArray type=\"Float64\" Name=\"" + VtkWriter::escaped(names[i]) +
           "\" NumberOfComponents=\"" + std::to_string(components(fields.fields[i].kind)) + "\"/>\n";
  }
  xml += "</PPointData>\n";
  for (const std::string& piece : pieces) xml += "<Piece Source=\"" + VtkWriter::escaped(piece) + "\"/>\n";
  return xml + "</PUnstructuredGrid>\n</VTKFile>\n";
}

MeshContents merged(std::vector<std::vector<MeshPiece>> sources) {
  std::vector<MeshPiece> pieces;
  for (auto& of_source : sources) std::ranges::move(of_source, std::back_inserter(pieces));
  return merge_pieces(std::move(pieces));
}

}  // namespace

std::vector<fs::path> pvtu_sources(const fs::path& path) {
  const VtkDocument index(path, "PUnstructuredGrid");
  std::vector<fs::path> sources;
  for (const pugi::xml_node piece : index.grid().children("Piece")) {
    const std::string source = piece.attribute("Source").value();
    if (source.empty()) index.fail("Piece", "has no Source");
    sources.push_back(path.parent_path() / source);
  }
  if (sources.empty()) index.fail("Piece", "is missing");
  return sources;
}

MeshContents read_pvtu(const fs::path& path, Coordinates wanted) {
  return merged(read_vtu_pieces(pvtu_sources(path), wanted));
}

MeshContents read_pvtu_by_piece(const fs::path& path) {
  std::vector<std::vector<MeshPiece>> sources = read_vtu_pieces(pvtu_sources(path));
  for (std::size_t i = 0; i < sources.size(); ++i)
    for (MeshPiece& piece : sources[i])
      std::ranges::fill(piece.contents.mesh.tet_refs, static_cast<std::int32_t>(i));
  return merged(std::move(sources));
}

void write_pvtu(const fs::path& path, const MeshView& contents, const WriteOptions& options) {
  check_lengths(contents.mesh, contents.fields);
  AtomicFile index(path);
  const auto num_pieces = static_cast<std::size_t>(std::max(1, options.pieces));
  const std::vector<std::uint32_t> first = first_points(contents.mesh, num_pieces);
  const bool point_refs = has_refs(contents.mesh.point_refs);
  std::vector<std::string> names;
  std::list<FormerFile> former;
  for (std::size_t i = 0; i < num_pieces; ++i) {
    names.push_back(path.stem().string() + "_" + std::to_string(i) + ".vtu");
    former.emplace_back(path.parent_path() / names.back());
    const Share share(contents, i, num_pieces, i == 0 ? first : std::vector<std::uint32_t>{});
    write_vtu_piece(path.parent_path() / names.back(), share.contents(), share.global_ids(), point_refs,
                    options);
  }
  index.write(index_text(contents.fields, point_refs, {}, names));
  index.commit();
}

void write_pvtu_index(const fs::path& path, const SolutionData& fields, bool point_refs,
                      const std::vector<std::string>& cell_data, const std::vector<std::string>& pieces) {
  AtomicFile index(path);
  index.write(index_text(fields, point_refs, cell_data, pieces));
  index.commit();
}

}  // namespace weft::meshing
