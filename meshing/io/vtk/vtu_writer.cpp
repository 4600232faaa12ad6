// The arrays of a VTU file, by one writer or by many.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "meshing/base/printable.h"
#include "meshing/io/files/file_part.h"
#include "meshing/io/vtk/vtk_xml.h"
#include "meshing/io/vtk/vtu.h"
#include "meshing/io/vtk/vtu_blocks.h"
#include "meshing/io/vtk/vtu_codes.h"

namespace weft::meshing {
namespace {

template <class T>
std::vector<char> bytes_of(const std::vector<T>& values) {
  std::vector<char> bytes(values.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

/// The cells of a mesh in the order in which they are written.
class Cells {
 public:
  explicit Cells(const MeshData& mesh) : mesh_(mesh) {}

  std::uint64_t count() const {
    return mesh_.tets.size() + mesh_.triangles.size() + mesh_.edges.size() + mesh_.corners.size();
  }
  std::uint64_t num_nodes() const {
    return 4 * mesh_.tets.size() + 3 * mesh_.triangles.size() + 2 * mesh_.edges.size() + mesh_.corners.size();
  }

  std::vector<char> connectivity() const {
    std::vector<std::int64_t> nodes;
    nodes.reserve(num_nodes());
    for (const auto& e : mesh_.tets) nodes.insert(nodes.end(), e.begin(), e.end());
    for (const auto& e : mesh_.triangles) nodes.insert(nodes.end(), e.begin(), e.end());
    for (const auto& e : mesh_.edges) nodes.insert(nodes.end(), e.begin(), e.end());
    nodes.insert(nodes.end(), mesh_.corners.begin(), mesh_.corners.end());
    return bytes_of(nodes);
  }
  std::vector<char> offsets() const {
    std::vector<std::int64_t> ends;
    ends.reserve(count());
    std::int64_t end = 0;
    const auto add = [&](std::size_t n, std::int64_t nodes) {
      for (std::size_t i = 0; i < n; ++i) ends.push_back(end += nodes);
    };
    add(mesh_.tets.size(), 4);
    add(mesh_.triangles.size(), 3);
    add(mesh_.edges.size(), 2);
    add(mesh_.corners.size(), 1);
    return bytes_of(ends);
  }
  std::vector<char> types() const {
    std::vector<std::uint8_t> types;
    types.reserve(count());
    types.insert(types.end(), mesh_.tets.size(), vtk::kTetra);
    types.insert(types.end(), mesh_.triangles.size(), vtk::kTriangle);
    types.insert(types.end(), mesh_.edges.size(), vtk::kLine);
    types.insert(types.end(), mesh_.corners.size(), vtk::kVertex);
    return bytes_of(types);
  }
  std::vector<char> refs() const {
    std::vector<std::int32_t> refs;
    refs.reserve(count());
    for (const auto* of : {&mesh_.tet_refs, &mesh_.triangle_refs, &mesh_.edge_refs}) {
      refs.insert(refs.end(), of->begin(), of->end());
    }
    for (const std::uint32_t corner : mesh_.corners) refs.push_back(mesh_.point_refs[corner]);
    return bytes_of(refs);
  }

 private:
  const MeshData& mesh_;
};

std::vector<char> field_bytes(const Field& field) {
  if (field.kind != Field::Kind::tensor) return bytes_of(field.values);
  std::vector<double> values(field.values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = field.values[i / 6 * 6 + vtk::kTensorOrder[i % 6]];
  return bytes_of(values);
}

/// What the arrays of a piece follow from.
struct PieceShape {
  std::uint64_t points, tets, triangles, edges, corners;
  bool global_ids, point_refs;
  std::vector<std::string> cell_data;
  const SolutionData& fields;  ///< their kinds and names

  std::uint64_t cells() const { return tets + triangles + edges + corners; }
  std::uint64_t nodes() const { return 4 * tets + 3 * triangles + 2 * edges + corners; }
};

enum class PieceArray {
  points,
  connectivity,
  offsets,
  types,
  refs,
  cell_data,
  global_ids,
  point_refs,
  field
};

/// The text of a piece; add(array, index, type, name, components, bytes) for every array, in their order.
template <class Out, class Add>
void describe_piece(const PieceShape& shape, Out& out, const Add& add) {
  constexpr std::uint64_t kInt64 = sizeof(std::int64_t), kInt32 = sizeof(std::int32_t);
  out.text("<UnstructuredGrid>\n<Piece NumberOfPoints=\"" + std::to_string(shape.points) +
           "\" NumberOfCells=\"" + std::to_string(shape.cells()) + "\">\n<Points>");
  add(PieceArray::points, 0, "Float64", "Points", 3, shape.points * sizeof(Point));
  out.text("</Points>\n<Cells>");
  add(PieceArray::connectivity, 0, "Int64", "connectivity", 1, shape.nodes() * kInt64);
  add(PieceArray::offsets, 0, "Int64", "offsets", 1, shape.cells() * kInt64);
  add(PieceArray::types, 0, "UInt8", "types", 1, shape.cells());
  out.text("</Cells>\n<CellData Scalars=\"ref\">");
  add(PieceArray::refs, 0, "Int32", "ref", 1, shape.cells() * kInt32);
  for (std::size_t i = 0; i < shape.cell_data.size(); ++i)
    add(PieceArray::cell_data, i, "Float64", shape.cell_data[i], 1, shape.cells() * sizeof(double));
  out.text("</CellData>");
  out.text(shape.global_ids ? "<PointData GlobalIds=\"GlobalPointIds\">" : "<PointData>");
  if (shape.global_ids) add(PieceArray::global_ids, 0, "Int64", "GlobalPointIds", 1, shape.points * kInt64);
  if (shape.point_refs) add(PieceArray::point_refs, 0, "Int32", "ref", 1, shape.points * kInt32);
  const std::vector<std::string> names = field_array_names(shape.fields, shape.global_ids, shape.point_refs);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int length = components(shape.fields.fields[i].kind);
    add(PieceArray::field, i, "Float64", names[i], length,
        static_cast<std::uint64_t>(length) * shape.points * sizeof(double));
  }
  out.text("</PointData>");
  out.text("</Piece>\n</UnstructuredGrid>");
}

PieceShape shape_of(const WholeMesh& whole) {
  return {.points = whole.points,
          .tets = whole.num_tets(),
          .triangles = whole.num_triangles(),
          .edges = whole.num_edges(),
          .corners = whole.corners.size(),
          .global_ids = false,
          .point_refs = whole.point_refs,
          .cell_data = {},
          .fields = whole.fields};
}

/// A file of one piece: its text, and where the values of every array begin.
class PiecePlan {
 public:
  explicit PiecePlan(const PieceShape& shape) : plan_("UnstructuredGrid") {
    describe_piece(shape, plan_,
                   [&](PieceArray array, std::size_t index, const char* type, const std::string& name,
                       int length, std::uint64_t bytes) {
                     arrays_.push_back({array, index});
                     plan_.array(type, name, length, bytes);
                   });
  }

  const VtkPlan& plan() const { return plan_; }
  /// Of all arrays.
  std::size_t number(PieceArray array, std::size_t index = 0) const {
    const auto found = std::ranges::find(arrays_, std::pair(array, index));
    return static_cast<std::size_t>(found - arrays_.begin());
  }
  std::uint64_t position(PieceArray array, std::size_t index = 0) const {
    return plan_.position(number(array, index));
  }

 private:
  VtkPlan plan_;
  std::vector<std::pair<PieceArray, std::size_t>> arrays_;
};

/// action(rows of one kind of cells, the number of cells of other kinds before these, that of their vertices,
/// VTK's type).
template <class Action>
void for_cells(const PieceShape& shape, const MeshPart& part, const Action& action) {
  action(part.tets, std::uint64_t{0}, std::uint64_t{0}, vtk::kTetra);
  action(part.triangles, shape.tets, 4 * shape.tets, vtk::kTriangle);
  action(part.edges, shape.tets + shape.triangles, 4 * shape.tets + 3 * shape.triangles, vtk::kLine);
}
constexpr int kCellSections = 3;

/// The rows of one part in the order of the file: emit(array, its number among those of the kind, the byte of
/// the array where they begin, what makes them).
template <class Emit>
void for_rows(const PieceShape& shape, const MeshPart& part, const Emit& emit) {
  emit(PieceArray::points, 0, part.first_point * sizeof(Point), [&] { return part.points; });
  for_cells(shape, part, [&]<std::size_t N>(const ElementRows<N>& rows, auto, auto nodes, auto) {
    emit(PieceArray::connectivity, 0, (nodes + N * rows.first) * sizeof(std::uint64_t),
         [&] { return rows.elements; });
  });
  for_cells(shape, part, [&]<std::size_t N>(const ElementRows<N>& rows, auto before, auto nodes, auto) {
    emit(PieceArray::offsets, 0, (before + rows.first) * sizeof(std::uint64_t), [&] {
      std::vector<std::uint64_t> ends(rows.elements.size());
      for (std::uint64_t i = 0; i < ends.size(); ++i) ends[i] = nodes + N * (rows.first + i + 1);
      return ends;
    });
  });
  for_cells(shape, part, [&](const auto& rows, auto before, auto, std::uint8_t type) {
    emit(PieceArray::types, 0, before + rows.first,
         [&] { return std::vector<std::uint8_t>(rows.elements.size(), type); });
  });
  for_cells(shape, part, [&](const auto& rows, auto before, auto, auto) {
    emit(PieceArray::refs, 0, (before + rows.first) * sizeof(std::int32_t), [&] { return rows.refs; });
  });
  if (shape.point_refs)
    emit(PieceArray::point_refs, 0, part.first_point * sizeof(std::int32_t), [&] { return part.point_refs; });
  for (std::size_t i = 0; i < part.fields.fields.size(); ++i) {
    const Field& field = part.fields.fields[i];
    emit(PieceArray::field, i,
         part.first_point * static_cast<std::uint64_t>(components(field.kind)) * sizeof(double),
         [&] { return field_bytes(field); });
  }
}

/// The rows of corners, behind all others of the arrays of cells: emit(array, first byte, rows).
template <class Emit>
void for_corners(const PieceShape& shape, const std::vector<WholeMesh::Corner>& corners, const Emit& emit) {
  const std::uint64_t first = shape.cells() - corners.size(), first_node = shape.nodes() - corners.size();
  std::vector<std::uint64_t> points, ends;
  std::vector<std::int32_t> refs;
  for (const WholeMesh::Corner& corner : corners) {
    points.push_back(corner.point);
    ends.push_back(first_node + ends.size() + 1);
    refs.push_back(corner.ref);
  }
  emit(PieceArray::connectivity, first_node * sizeof(std::uint64_t), points);
  emit(PieceArray::offsets, first * sizeof(std::uint64_t), ends);
  emit(PieceArray::types, first, std::vector<std::uint8_t>(corners.size(), vtk::kVertex));
  emit(PieceArray::refs, first * sizeof(std::int32_t), refs);
}

/// Rows of one part, at their places.
class VtuPartWriter final : public PartWriter {
 public:
  VtuPartWriter(PartTarget target, const WholeMesh& whole)
      : file_(std::move(target)), shape_(shape_of(whole)), plan_(shape_) {}

  void write(const MeshPart& part) override {
    for_rows(shape_, part, [&](PieceArray array, std::size_t index, std::uint64_t offset, const auto& make) {
      write_at(array, index, offset, make());
    });
  }
  void finish() override { file_.finish(); }

  /// All but the rows of parts: text, lengths of arrays, and corners.
  void write_frame(const std::vector<WholeMesh::Corner>& corners) {
    const VtkPlan& plan = plan_.plan();
    file_.seek(0);
    file_.write(plan.head());
    for (std::size_t i = 0; i < plan.num_arrays(); ++i) {
      file_.seek(plan.position(i) - sizeof(std::uint64_t));
      file_.write_value(plan.bytes(i));
    }
    file_.seek(plan.position(plan.num_arrays() - 1) + plan.bytes(plan.num_arrays() - 1));
    file_.write(VtkPlan::tail());
    for_corners(shape_, corners, [&](PieceArray array, std::uint64_t offset, const auto& rows) {
      write_at(array, 0, offset, rows);
    });
  }

 private:
  template <class Rows>
  void write_at(PieceArray array, std::size_t index, std::uint64_t offset, const Rows& rows) {
    const std::span values(rows);
    if (values.empty()) return;
    file_.seek(plan_.position(array, index) + offset);
    file_.write(values.data(), values.size_bytes());
  }

  FilePart file_;
  PieceShape shape_;
  PiecePlan plan_;
};

/// A file of one piece as text: what is not of a part, and the types of arrays.
struct PieceText {
  explicit PieceText(const WholeMesh& whole) : shape(shape_of(whole)) {
    describe_piece(shape, heads,
                   [&](PieceArray array, std::size_t, const char* type, const std::string& name, int length,
                       std::uint64_t) {
                     types[array] = type;
                     std::string corners;
                     int sections = 1;
                     for_corners(shape, whole.corners,
                                 [&](PieceArray of, std::uint64_t offset, const auto& rows) {
                                   if (of != array) return;
                                   sections = kCellSections;
                                   corners = vtk_text(type, std::as_bytes(std::span(rows)), offset);
                                 });
                     heads.array(type, name, length, sections, corners);
                   });
  }

  PieceShape shape;
  VtkTextHeads heads{"UnstructuredGrid"};
  std::map<PieceArray, std::string> types;
};

class VtuTextPart final : public TextPart {
 public:
  VtuTextPart(const WholeMesh& whole, const MeshPart& part) : piece_(whole), part_(part) {}

  std::string rows(std::size_t section) const override {
    std::string text;
    std::size_t next = 0;
    for_rows(piece_.shape, part_, [&](PieceArray array, std::size_t, std::uint64_t offset, const auto& make) {
      if (next++ != section) return;
      const auto rows = make();
      text = vtk_text(piece_.types.at(array), std::as_bytes(std::span(rows)), offset);
    });
    return text;
  }

 private:
  PieceText piece_;
  const MeshPart& part_;
};

}  // namespace

std::vector<std::string> field_array_names(const SolutionData& fields, bool global_ids, bool point_refs) {
  UniqueNames unique_names;
  if (global_ids) unique_names.unique("GlobalPointIds");
  if (point_refs) unique_names.unique("ref");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < fields.fields.size(); ++i)
    names.push_back(unique_names.unique(printable(field_name(fields, i))));
  return names;
}

void write_vtu_piece(const std::filesystem::path& path, const MeshView& contents,
                     const std::vector<std::int64_t>& global_ids, bool point_refs,
                     const WriteOptions& options, const std::vector<CellData>& cell_data) {
  static_assert(sizeof(Point) == 3 * sizeof(double), "points are written as they lie in memory");
  check_lengths(contents.mesh, contents.fields);
  const MeshData& mesh = contents.mesh;
  const Cells cells(mesh);
  PieceShape shape{.points = mesh.points.size(),
                   .tets = mesh.tets.size(),
                   .triangles = mesh.triangles.size(),
                   .edges = mesh.edges.size(),
                   .corners = mesh.corners.size(),
                   .global_ids = !global_ids.empty(),
                   .point_refs = point_refs,
                   .cell_data = {},
                   .fields = contents.fields};
  for (const CellData& data : cell_data) shape.cell_data.push_back(data.name);
  const auto make = [&](PieceArray array, std::size_t i) {
    switch (array) {
      case PieceArray::points:
        return bytes_of(mesh.points);
      case PieceArray::connectivity:
        return cells.connectivity();
      case PieceArray::offsets:
        return cells.offsets();
      case PieceArray::types:
        return cells.types();
      case PieceArray::refs:
        return cells.refs();
      case PieceArray::cell_data:
        return bytes_of(cell_data[i].values);
      case PieceArray::global_ids:
        return bytes_of(global_ids);
      case PieceArray::point_refs:
        return bytes_of(mesh.point_refs);
      case PieceArray::field:
        return field_bytes(contents.fields.fields[i]);
    }
    return std::vector<char>();
  };
  VtkWriter out(path, "UnstructuredGrid", options);
  describe_piece(shape, out,
                 [&](PieceArray array, std::size_t i, const char* type, const std::string& name, int length,
                     std::uint64_t bytes) {
                   out.array(type, name, length, bytes, [&make, array, i] { return make(array, i); });
                 });
  out.finish();
}

PartPlaces begin_vtu_parts(const std::filesystem::path& file, const std::filesystem::path& name,
                           const WholeMesh& whole) {
  VtuPartWriter out({file, name.string()}, whole);
  out.write_frame(whole.corners);
  out.finish();
  return {};
}

std::unique_ptr<PartWriter> open_vtu_part(PartTarget target, const WholeMesh& whole, const PartPlaces&) {
  return std::make_unique<VtuPartWriter>(std::move(target), whole);
}

std::vector<std::string> vtu_heads(const WholeMesh& whole) { return PieceText(whole).heads.finish(); }

std::unique_ptr<TextPart> open_vtu_text_part(const WholeMesh& whole, const MeshPart& part) {
  return std::make_unique<VtuTextPart>(whole, part);
}

// ---------------------------------------------------------------------------------------------------------
// Compressed, by many writers

struct VtuBlocks::Plan {
  explicit Plan(const WholeMesh& whole) : shape(shape_of(whole)), arrays(shape) {}

  std::uint64_t bytes(std::size_t array) const { return arrays.plan().bytes(array); }

  PieceShape shape;
  PiecePlan arrays;
};

VtuBlocks::VtuBlocks(const WholeMesh& whole)
    : whole_(whole), plan_(std::make_unique<const Plan>(whole)), first_{0} {
  for (std::size_t i = 0; i < plan_->arrays.plan().num_arrays(); ++i)
    first_.push_back(first_.back() + num_vtk_blocks(plan_->bytes(i)));
}

VtuBlocks::~VtuBlocks() = default;

std::size_t VtuBlocks::array_of(std::uint64_t block) const {
  return static_cast<std::size_t>(std::ranges::upper_bound(first_, block) - first_.begin()) - 1;
}

std::uint64_t VtuBlocks::size(std::uint64_t block) const {
  const std::size_t array = array_of(block);
  return std::min(kVtkBlockSize, plan_->bytes(array) - (block - first_[array]) * kVtkBlockSize);
}

template <class Rows>
void VtuBlocks::cut(std::size_t array, std::uint64_t offset, const Rows& rows, const Use& use) const {
  std::span<const std::byte> bytes = std::as_bytes(std::span(rows));
  while (!bytes.empty()) {
    const std::uint64_t first = offset % kVtkBlockSize, n = std::min(kVtkBlockSize - first, bytes.size());
    use(first_[array] + offset / kVtkBlockSize, first, bytes.first(n));
    bytes = bytes.subspan(n);
    offset += n;
  }
}

void VtuBlocks::for_rows(const MeshPart& part, const Use& use) const {
  meshing::for_rows(plan_->shape, part,
                    [&](PieceArray array, std::size_t index, std::uint64_t offset, const auto& make) {
                      cut(plan_->arrays.number(array, index), offset, make(), use);
                    });
}

void VtuBlocks::for_corners(const Use& use) const {
  meshing::for_corners(plan_->shape, whole_.corners,
                       [&](PieceArray array, std::uint64_t offset, const auto& rows) {
                         cut(plan_->arrays.number(array), offset, rows, use);
                       });
}

std::vector<char> VtuBlocks::compressed(std::span<const std::byte> block) {
  return vtk_block({reinterpret_cast<const char*>(block.data()), block.size()});
}

std::uint64_t VtuBlocks::header_size(std::size_t array) const {
  return (vtk_block_header(0).size() + first_[array + 1] - first_[array]) * sizeof(std::uint64_t);
}

void VtuBlocks::place(std::span<const std::uint64_t> of_arrays) {
  std::vector<std::uint64_t> lengths(of_arrays.begin(), of_arrays.end());
  for (std::size_t i = 0; i < lengths.size(); ++i) lengths[i] += header_size(i);
  head_ = plan_->arrays.plan().compressed_head(lengths);
  places_ = {head_.size()};
  for (const std::uint64_t length : lengths) places_.push_back(places_.back() + length);
}

void VtuBlocks::write_frame(FilePart& out) const {
  out.seek(0);
  out.write(head_);
  for (std::size_t i = 0; i < num_arrays(); ++i) {
    out.seek(places_[i]);
    for (const std::uint64_t value : vtk_block_header(plan_->bytes(i))) out.write_value(value);
  }
  out.seek(places_.back());
  out.write(VtkPlan::tail());
}

void VtuBlocks::write_block(FilePart& out, std::uint64_t block, std::uint64_t before,
                            std::span<const char> bytes) const {
  const std::size_t array = array_of(block);
  out.seek(places_[array] + (vtk_block_header(0).size() + block - first_[array]) * sizeof(std::uint64_t));
  out.write_value(std::uint64_t{bytes.size()});
  out.seek(places_[array] + header_size(array) + before);
  out.write(bytes.data(), bytes.size());
}

void write_vtu(const std::filesystem::path& path, const MeshView& contents, const WriteOptions& options) {
  write_vtu_piece(path, contents, {}, has_refs(contents.mesh.point_refs), options);
}

}  // namespace weft::meshing
