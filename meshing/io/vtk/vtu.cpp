// What the arrays of a VTU file mean; vtk_xml.h knows how they are stored.
#include "meshing/io/vtk/vtu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "meshing/base/printable.h"
#include "meshing/io/files/file_part.h"
#include "meshing/io/vtk/vtk_xml.h"
#include "meshing/io/vtk/vtu_codes.h"

namespace weft::meshing {
namespace {

constexpr std::array<std::string_view, 4> kRefNames = {"ref", "CellEntityIds", "gmsh:physical", "medit:ref"};
constexpr std::array<std::string_view, 4> kGlobalIdNames = {"GlobalPointIds", "GlobalPointId",
                                                            "GlobalNodeIds", "GlobalNodeId"};
constexpr std::string_view kGhosts = "vtkGhostType";

struct OtherCell {
  std::int64_t code;
  bool volume;
  const char* name;
};
constexpr OtherCell kOtherCells[] = {{2, false, "polyvertices"},
                                     {4, false, "polylines"},
                                     {6, false, "triangle strips"},
                                     {7, false, "polygons"},
                                     {8, false, "pixels"},
                                     {9, false, "quadrilaterals"},
                                     {11, true, "voxels"},
                                     {12, true, "hexahedra"},
                                     {13, true, "wedges"},
                                     {14, true, "pyramids"},
                                     {21, false, "quadratic edges"},
                                     {22, false, "quadratic triangles"},
                                     {23, false, "quadratic quadrilaterals"},
                                     {24, true, "quadratic tetrahedra"},
                                     {25, true, "quadratic hexahedra"},
                                     {26, true, "quadratic wedges"},
                                     {27, true, "quadratic pyramids"},
                                     {42, true, "polyhedra"},
                                     {68, false, "Lagrange curves"},
                                     {69, false, "Lagrange triangles"},
                                     {71, true, "Lagrange tetrahedra"}};

template <std::size_t N>
bool is_one_of(std::string_view name, const std::array<std::string_view, N>& names) {
  return std::ranges::find(names, name) != names.end();
}

class PieceReader {
 public:
  /// `range`: which points and tets are kept; all without one. With one there are no fields. `not_refs`: what
  /// a range has of that name.
  PieceReader(const VtkDocument& document, pugi::xml_node piece,
              const std::optional<PieceRange>& range = std::nullopt, std::uint8_t not_refs = 0)
      : document_(document),
        piece_(piece),
        range_(range),
        others_(!range || range->others),
        not_refs_(range ? range->not_refs : not_refs),
        num_points_(document.count(piece, "NumberOfPoints")),
        num_cells_(document.count(piece, "NumberOfCells")),
        tets_(range ? KeptRows(range->rows.first_tet, range->rows.num_tets) : KeptRows()) {}

  MeshPiece read(Coordinates wanted = Coordinates::finite) {
    read_points(wanted);
    find_cell_data();
    read_cells();
    read_point_data();
    result_.contents.complete();
    return std::move(result_);
  }

  PieceSize size() {
    find_cell_data();
    PieceSize size{{num_points_, 0}, num_points_ == 0};
    size.not_refs = not_refs();
    for (const pugi::xml_node array : piece_.child("PointData").children("DataArray"))
      size.has_ids = size.has_ids || role_of(array) == Role::ids;
    for (std::uint64_t first = 0; first < num_cells_; first += kCellsAtOnce) {
      const Rows rows{first, kCellsAtOnce};
      const CellCounts counts =
          count_cells(document_.integers(cell_array("types"), num_cells_, rows), ghosts_of(rows));
      size.tets += counts.tets;
      size.triangles += counts.triangles, size.edges += counts.edges, size.corners += counts.corners;
    }
    return size;
  }

  /// Of the triangles, edges and corners of a piece of this size, those of the range's part.
  void keep_part_of(const MeshSize& size) {
    triangles_ = KeptRows(range_->rows, size.triangles);
    edges_ = KeptRows(range_->rows, size.edges);
    corners_ = KeptRows(range_->rows, size.corners);
  }

  // When cell data have been looked at:
  /// Bits of the names (kRefNames) of arrays here that cannot be references.
  std::uint8_t not_refs() const { return static_cast<std::uint8_t>(has_ & ~can_be_); }
  /// The bit of the name of the references; 0: there are none.
  std::uint8_t ref_name() const { return refs_ ? bit_of(refs_.attribute("Name").value()) : std::uint8_t{0}; }

  /// Only the fields, at the points of the range. A field that has no place here, as some of its values show,
  /// has no values.
  MeshContents fields() {
    for (const pugi::xml_node array : piece_.child("PointData").children("DataArray"))
      if (role_of(array) == Role::field) read_field(array);
    result_.contents.fields.num_points = range_->rows.num_points;
    return std::move(result_.contents);
  }

 private:
  using Rows = VtkDocument::Rows;
  static constexpr std::uint64_t kCellsAtOnce = std::uint64_t{1} << 18;  ///< when not all are needed

  MeshData& mesh() { return result_.contents.mesh; }
  Rows point_rows(std::uint64_t length) const {
    return range_ ? Rows{length * range_->rows.first_point, length * range_->rows.num_points} : Rows{};
  }

  void read_points(Coordinates wanted) {
    const pugi::xml_node array = piece_.child("Points").child("DataArray");
    if (!array) {
      if (num_points_ == 0) return;
      document_.fail("Points", "are missing");
    }
    const std::vector<double> coordinates = document_.reals(array, 3 * num_points_, point_rows(3));
    mesh().points.resize(coordinates.size() / 3);
    for (std::size_t i = 0; i < mesh().points.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const double x = coordinates[3 * i + static_cast<std::size_t>(c)];
        if (!passes(x, wanted))
          document_.fail("point " + std::to_string(i + (range_ ? range_->rows.first_point : 0)),
                         "a coordinate is not finite");
        mesh().points[i][c] = x;
      }
    }
  }

  void find_cell_data() {
    for (const pugi::xml_node array : piece_.child("CellData").children("DataArray")) {
      const std::string name = array.attribute("Name").value();
      if (name == kGhosts) {
        ghosts_ = array;
        continue;
      }
      const std::uint8_t bit = bit_of(name);
      const bool good = (bit & ~not_refs_) != 0 && can_be_refs(array);
      has_ |= bit;
      if (good) can_be_ |= bit;
      if (good && !refs_)
        refs_ = array;
      else if (others_)
        result_.contents.drop("values of cell data " + name, num_cells_);
    }
  }

  /// Of a name of references; 0: of another.
  static std::uint8_t bit_of(std::string_view name) {
    const auto found = std::ranges::find(kRefNames, name);
    return static_cast<std::uint8_t>(found == kRefNames.end() ? 0 : 1 << (found - kRefNames.begin()));
  }

  /// Reals too, NumPy's usual type, where all of the piece are whole numbers.
  bool can_be_refs(pugi::xml_node array) const {
    if (!is_scalar(array)) return false;
    if (is_integer(array)) return true;
    const auto is_ref = [](double x) {
      return std::trunc(x) == x && std::abs(x) <= std::numeric_limits<std::int32_t>::max();
    };
    for (std::uint64_t first = 0; first < num_cells_; first += kCellsAtOnce)
      if (!std::ranges::all_of(document_.reals(array, num_cells_, {first, kCellsAtOnce}), is_ref))
        return false;
    return true;
  }

  std::vector<std::int64_t> refs_of(Rows rows) const {
    if (!refs_) return {};
    if (is_integer(refs_)) return document_.integers(refs_, num_cells_, rows);
    const std::vector<double> reals = document_.reals(refs_, num_cells_, rows);
    return {reals.begin(), reals.end()};
  }

  static bool is_scalar(pugi::xml_node array) { return array.attribute("NumberOfComponents").as_int(1) == 1; }

  pugi::xml_node cell_array(const char* name) const {
    const pugi::xml_node array = piece_.child("Cells").find_child_by_attribute("DataArray", "Name", name);
    if (!array) document_.fail("Cells", std::string("array ") + name + " is missing");
    return array;
  }

  /// Cells in blocks: all at once, or so many that a range's memory stays small.
  void read_cells() {
    if (num_cells_ == 0 || (!others_ && range_->rows.num_tets == 0)) return;
    const std::uint64_t at_once = range_ ? kCellsAtOnce : num_cells_;
    for (std::uint64_t first = 0; first < num_cells_; first += at_once)
      read_block(first, range_ ? Rows{first, at_once} : Rows{});
    const std::uint64_t nodes = range_ ? document_.size(cell_array("connectivity")) : num_nodes_read_;
    if (end_ != static_cast<std::int64_t>(nodes))
      document_.fail("Cells", "connectivity has more values than the offsets say");
  }

  void read_block(std::uint64_t first, Rows rows) {
    const std::vector<std::int64_t> types = document_.integers(cell_array("types"), num_cells_, rows);
    const std::vector<std::int64_t> ghosts = ghosts_of(rows);
    if (range_ && !has_wanted(count_cells(types, ghosts))) {
      for (std::size_t i = 0; i < types.size(); ++i)
        if (!is_ghost(ghosts, i) && is_kept(types[i])) drop_cell(types[i]);
      end_ = document_.integers(cell_array("offsets"), num_cells_, {first + types.size() - 1, 1})[0];
      return;
    }
    const std::vector<std::int64_t> offsets = document_.integers(cell_array("offsets"), num_cells_, rows);
    const std::vector<std::int64_t> refs = refs_of(rows);
    const std::int64_t begin = std::exchange(end_, offsets.back());
    cell_ = first;
    if (range_ && (begin < 0 || end_ < begin)) fail_cell("its offset is out of range");
    const std::vector<std::int64_t> nodes = document_.integers(
        cell_array("connectivity"), VtkDocument::kAny,
        range_ ? Rows{static_cast<std::uint64_t>(begin), static_cast<std::uint64_t>(end_ - begin)} : Rows{});
    num_nodes_read_ = nodes.size();
    std::int64_t at = begin;
    for (std::size_t i = 0; i < types.size(); ++i) {
      cell_ = first + i;
      const std::int64_t end = offsets[i];
      if (end < at || static_cast<std::uint64_t>(end - begin) > nodes.size()) {
        fail_cell("its offset " + std::to_string(end) + " is out of range");
      }
      nodes_ = nodes.data() + (at - begin);
      num_nodes_ = static_cast<std::size_t>(end - at);
      if (!is_ghost(ghosts, i) && is_kept(types[i]))
        read_cell(types[i], refs.empty() ? 0 : checked_ref(refs[i]));
      at = end;
    }
  }

  std::vector<std::int64_t> ghosts_of(Rows rows) const {
    return ghosts_ ? document_.integers(ghosts_, num_cells_, rows) : std::vector<std::int64_t>();
  }
  /// Whether another piece has the cell.
  static bool is_ghost(const std::vector<std::int64_t>& ghosts, std::size_t i) {
    return !ghosts.empty() && (ghosts[i] & 1);
  }
  struct CellCounts {
    std::uint64_t tets = 0, triangles = 0, edges = 0, corners = 0;
  };
  static CellCounts count_cells(const std::vector<std::int64_t>& types,
                                const std::vector<std::int64_t>& ghosts) {
    CellCounts counts;
    for (std::size_t i = 0; i < types.size(); ++i) {
      if (is_ghost(ghosts, i)) continue;
      counts.tets += types[i] == vtk::kTetra;
      counts.triangles += types[i] == vtk::kTriangle;
      counts.edges += types[i] == vtk::kLine;
      counts.corners += types[i] == vtk::kVertex;
    }
    return counts;
  }

  /// Whether any of a block's cells that have a place here is kept.
  bool has_wanted(const CellCounts& block) const {
    if (tets_.among(block.tets).count > 0) return true;
    return others_ && triangles_.among(block.triangles).count + edges_.among(block.edges).count +
                              corners_.among(block.corners).count >
                          0;
  }
  /// Passes the next cell, of this type.
  bool is_kept(std::int64_t type) {
    if (type == vtk::kTetra) return tets_.take();
    if (!others_) return false;
    if (type == vtk::kTriangle) return triangles_.take();
    if (type == vtk::kLine) return edges_.take();
    if (type == vtk::kVertex) return corners_.take();
    return true;  // to be counted among what is dropped
  }

  std::int32_t checked_ref(std::int64_t ref) const {
    if (!std::in_range<std::int32_t>(ref)) {
      fail_cell("reference " + std::to_string(ref) + " does not fit 32 bits");
    }
    return static_cast<std::int32_t>(ref);
  }

  [[noreturn]] void fail_cell(const std::string& reason) const {
    document_.fail("cell " + std::to_string(cell_), reason);
  }

  template <std::size_t N>
  std::array<std::uint32_t, N> cell_nodes() const {
    if (num_nodes_ != N) {
      fail_cell("has " + std::to_string(num_nodes_) + " points instead of " + std::to_string(N));
    }
    std::array<std::uint32_t, N> cell;
    for (std::size_t n = 0; n < N; ++n) {
      if (nodes_[n] < 0 || static_cast<std::uint64_t>(nodes_[n]) >= num_points_) {
        fail_cell("point index " + std::to_string(nodes_[n]) + " is out of range 0.." +
                  std::to_string(static_cast<std::int64_t>(num_points_) - 1));
      }
      cell[n] = static_cast<std::uint32_t>(nodes_[n]);
    }
    return cell;
  }

  void read_cell(std::int64_t type, std::int32_t ref) {
    switch (type) {
      case vtk::kTetra:
        mesh().tets.push_back(cell_nodes<4>());
        mesh().tet_refs.push_back(ref);
        break;
      case vtk::kTriangle:
        mesh().triangles.push_back(cell_nodes<3>());
        mesh().triangle_refs.push_back(ref);
        break;
      case vtk::kLine:
        mesh().edges.push_back(cell_nodes<2>());
        mesh().edge_refs.push_back(ref);
        break;
      case vtk::kVertex:
        mesh().corners.push_back(cell_nodes<1>()[0]);
        break;
      default:
        drop_cell(type);
    }
  }

  void drop_cell(std::int64_t type) {
    const auto known = std::ranges::find(kOtherCells, type, &OtherCell::code);
    if (known == std::end(kOtherCells)) {
      result_.contents.drop_volumes("cells of VTK type " + std::to_string(type), 1);
    } else if (known->volume) {
      result_.contents.drop_volumes(known->name, 1);
    } else {
      result_.contents.drop(known->name);
    }
  }

  /// What an array of point data is.
  enum class Role { ids, refs, field, none };
  Role role_of(pugi::xml_node array) const {
    const std::string_view name = array.attribute("Name").value();
    const std::string_view ids = piece_.child("PointData").attribute("GlobalIds").value();
    if ((name == ids || is_one_of(name, kGlobalIdNames)) && is_integer(array)) return Role::ids;
    if (array == point_refs()) return Role::refs;
    return name == kGhosts ? Role::none : Role::field;
  }
  static bool is_integer(pugi::xml_node array) {
    return !std::string_view(array.attribute("type").value()).starts_with("Float") && is_scalar(array);
  }
  /// The last one: of several it is kept.
  pugi::xml_node point_refs() const {
    pugi::xml_node found;
    for (const pugi::xml_node array : piece_.child("PointData").children("DataArray"))
      if (std::string_view(array.attribute("Name").value()) == "ref" && is_integer(array)) found = array;
    return found;
  }

  void read_point_data() {
    for (const pugi::xml_node array : piece_.child("PointData").children("DataArray")) {
      const Role role = role_of(array);
      if (role == Role::ids) {
        result_.global_ids = document_.integers(array, num_points_, point_rows(1));
      } else if (role == Role::refs) {
        read_point_refs(array);
      } else if (role == Role::field && !range_) {
        read_field(array);
      }
    }
  }

  void read_point_refs(pugi::xml_node array) {
    for (const std::int64_t ref : document_.integers(array, num_points_, point_rows(1))) {
      if (!std::in_range<std::int32_t>(ref)) document_.fail("array ref", "a reference does not fit 32 bits");
      mesh().point_refs.push_back(static_cast<std::int32_t>(ref));
    }
  }

  void read_field(pugi::xml_node array) {
    MeshContents& contents = result_.contents;
    const std::string name = array.attribute("Name").value();
    const int length = array.attribute("NumberOfComponents").as_int(1);
    if (length != 1 && length != 3 && length != 6 && length != 9) {
      if (others_) contents.drop("fields of " + std::to_string(length) + " components");
      return;
    }
    const auto n = static_cast<std::uint64_t>(length);
    std::vector<double> values = document_.reals(array, n * num_points_, point_rows(n));
    Field field{length == 1   ? Field::Kind::scalar
                : length == 3 ? Field::Kind::vector
                              : Field::Kind::tensor,
                {},
                name};
    if (length == 9) {
      if (!fold_full_tensors(values, field.values)) {
        if (!range_) return contents.drop(kSkewTensors);
        field.values.clear();
      }
    } else if (length == 6) {
      field.values.resize(values.size());
      for (std::size_t i = 0; i < values.size(); ++i)
        field.values[i / 6 * 6 + vtk::kTensorOrder[i % 6]] = values[i];
    } else {
      field.values = std::move(values);
    }
    contents.fields.fields.push_back(std::move(field));
  }

  const VtkDocument& document_;
  pugi::xml_node piece_, refs_, ghosts_;
  std::optional<PieceRange> range_;
  bool others_;                                   ///< cells that are no tets are wanted
  std::uint8_t not_refs_, has_ = 0, can_be_ = 0;  ///< bits of names of references
  std::uint64_t num_points_, num_cells_;
  MeshPiece result_;
  // Of the cells so far:
  KeptRows tets_, triangles_, edges_, corners_;
  std::uint64_t num_nodes_read_ = 0;
  std::int64_t end_ = 0;
  // The cell being read:
  std::size_t cell_ = 0, num_nodes_ = 0;
  const std::int64_t* nodes_ = nullptr;
};

std::vector<pugi::xml_node> pieces_of(const VtkDocument& document) {
  const auto pieces = document.grid().children("Piece");
  if (pieces.begin() == pieces.end()) document.fail("Piece", "is missing");
  return {pieces.begin(), pieces.end()};
}

/// Bits of the names of cell data that were the references of a piece, and of those that could not be.
struct VtuRefs {
  std::uint8_t used = 0, refused = 0;
};

std::vector<std::vector<MeshPiece>> read_sources(std::span<const std::filesystem::path> sources,
                                                 Coordinates wanted, std::uint8_t not_refs, VtuRefs& refs) {
  std::vector<std::vector<MeshPiece>> all;
  for (const std::filesystem::path& source : sources) {
    const VtkDocument document(source, "UnstructuredGrid");
    std::vector<MeshPiece>& pieces = all.emplace_back();
    for (const pugi::xml_node piece : pieces_of(document)) {
      PieceReader reader(document, piece, std::nullopt, not_refs);
      pieces.push_back(reader.read(wanted));
      refs.used |= reader.ref_name();
      refs.refused |= reader.not_refs();
    }
  }
  return all;
}

}  // namespace

std::vector<std::vector<MeshPiece>> read_vtu_pieces(std::span<const std::filesystem::path> sources,
                                                    Coordinates wanted) {
  VtuRefs refs;
  std::vector<std::vector<MeshPiece>> pieces = read_sources(sources, wanted, 0, refs);
  if (!(refs.used & refs.refused)) return pieces;
  pieces.clear();
  return read_sources(sources, wanted, refs.refused, refs);
}

MeshContents read_vtu(const std::filesystem::path& path, Coordinates wanted) {
  return merge_pieces(std::move(read_vtu_pieces({&path, 1}, wanted)[0]));
}

std::optional<MeshSize> vtu_size(const std::filesystem::path& path) {
  const VtkDocument document(path, "UnstructuredGrid");
  const std::vector<pugi::xml_node> pieces = pieces_of(document);
  if (pieces.size() > 1) return std::nullopt;
  return PieceReader(document, pieces[0]).size();
}

MeshContents read_vtu_range(const std::filesystem::path& path, const MeshRange& range) {
  const VtkDocument document(path, "UnstructuredGrid");
  const pugi::xml_node piece = pieces_of(document)[0];
  PieceReader reader(document, piece, PieceRange{range, true});
  if (range.parts > 1) reader.keep_part_of(range.whole ? *range.whole : PieceReader(document, piece).size());
  MeshContents contents = reader.read().contents;
  contents.fields.num_points = range.num_points;
  return contents;
}

std::vector<PieceSize> vtu_piece_sizes(const std::filesystem::path& path) {
  const VtkDocument document(path, "UnstructuredGrid");
  std::vector<PieceSize> sizes;
  for (const pugi::xml_node piece : pieces_of(document)) sizes.push_back(PieceReader(document, piece).size());
  return sizes;
}

PieceRanges read_vtu_piece_ranges(const std::filesystem::path& path, std::span<const PieceRange> ranges) {
  const VtkDocument document(path, "UnstructuredGrid");
  const std::vector<pugi::xml_node> pieces = pieces_of(document);
  PieceRanges result;
  for (std::size_t p = 0; p < ranges.size(); ++p)
    result.pieces.push_back(is_empty(ranges[p]) ? MeshPiece{}
                                                : PieceReader(document, pieces.at(p), ranges[p]).read());
  return result;
}

std::vector<MeshContents> read_vtu_piece_fields(const std::filesystem::path& path,
                                                std::span<const PieceRange> ranges) {
  const VtkDocument document(path, "UnstructuredGrid");
  const std::vector<pugi::xml_node> pieces = pieces_of(document);
  std::vector<MeshContents> result;
  for (std::size_t p = 0; p < ranges.size(); ++p)
    result.push_back(PieceReader(document, pieces.at(p), ranges[p]).fields());
  return result;
}

}  // namespace weft::meshing
