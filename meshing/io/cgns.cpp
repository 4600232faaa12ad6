// CGNS as a tree of nodes: the library knows how they lie in HDF5, here is what they mean for a mesh.
#include "meshing/io/cgns.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "meshing/io/cgns_library.h"
#include "meshing/io/cgns_section_data.h"
#include "meshing/io/cgns_triangle_names.h"
#include "meshing/io/files/child_process.h"
#include "meshing/io/files/input_file.h"
#include "meshing/io/files/merge_pieces.h"

namespace weft::meshing {
namespace {

using namespace cgns;

using CgnsType = CGNS_ENUMT(ElementType_t);

/// One section of elements: its type and range.
struct SectionHead {
  CgnsType type{};
  std::int64_t start = 0;
  std::uint64_t count = 0;
};

/// The type that a number among mixed elements stands for in files of this version. (Of whole sections the
/// library does this itself.) Version 3 has put PYRA_13 in front of PYRA_14, 3.1 behind MIXED; before 3.2 a
/// number above that of NGON_n is a polygon, which counts its nodes.
CgnsType mixed_type(std::int64_t number, int version) {
  const int ngon = CGNS_ENUMV(NGON_n) - (version < 3000 ? 1 : 0);
  if (version < 3200 && number >= ngon) return CGNS_ENUMV(NGON_n);
  const bool is_moved = version >= 3000 && version < 3100 && number >= CGNS_ENUMV(PYRA_14);
  if (is_moved && number == CGNS_ENUMV(PYRA_14)) return CGNS_ENUMV(PYRA_13);
  return static_cast<CgnsType>(is_moved ? number - 1 : number);
}

/// References for names, the same in all zones.
struct ZoneRefs {
  explicit ZoneRefs(RefNames& names) : triangles(2, names), tets(3, names), edges(1, names) {}
  RefNumbering triangles, tets, edges;
};

class ZoneReader {
 public:
  /// `most` bounds every count: each thing counted takes a byte of the file at least.
  ZoneReader(const Library& library, int zone, std::uint64_t most, ZoneRefs& refs)
      : library_(library), zone_(zone), most_(most), refs_(refs) {}

  MeshPiece read(Coordinates wanted) {
    read_size();
    range_.num_points = num_points_;
    coordinates_ = wanted;
    read_mesh();
    read_solutions();
    contents().complete();
    return std::move(piece_);
  }

  /// Points, tets and the part of the range only, and no fields.
  /// Without `others` no triangles and edges, of which the names are known none the less.
  MeshContents read(const MeshRange& range, bool others = true) {
    read_size();
    if (!others) {
      kept_triangles_ = kept_edges_ = KeptRows(0, 0);
    } else if (range.parts > 1) {
      const MeshSize all = range.whole ? *range.whole : size();
      kept_triangles_ = KeptRows(range, all.triangles);
      kept_edges_ = KeptRows(range, all.edges);
    }
    range_ = range;
    kept_tets_ = KeptRows(range.first_tet, range.num_tets);
    read_mesh();
    contents().complete();
    return std::move(contents());
  }

  /// The fields at the points of the range.
  MeshContents fields(const MeshRange& range) {
    read_size();
    range_ = range;
    read_solutions();
    contents().fields.num_points = range.num_points;
    return std::move(contents());
  }

  /// Passes over the sections of mixed elements, which do not say what is among them.
  PieceSize size() {
    read_size();
    PieceSize size{{num_points_, 0}};
    for (int s = 1; s <= num_sections(); ++s) {
      const SectionHead head = section_head(s);
      const auto count = [&](CgnsType type, std::uint64_t elements) {
        if (type == CGNS_ENUMV(TETRA_4)) size.tets += elements;
        if (type == CGNS_ENUMV(TRI_3)) size.triangles += elements;
        if (type == CGNS_ENUMV(BAR_2)) size.edges += elements;
      };
      if (head.type == CGNS_ENUMV(MIXED))
        for_each_mixed(head, [&](CgnsType type, const std::int64_t*) { count(type, 1); });
      else
        count(head.type, head.count);
    }
    return size;
  }

 private:
  MeshContents& contents() { return piece_.contents; }
  MeshData& mesh() { return piece_.contents.mesh; }

  std::uint64_t checked(std::int64_t count, const std::string& entity) const {
    if (count < 0 || static_cast<std::uint64_t>(count) > most_) {
      library_.fail(entity, "its count of " + std::to_string(count) + " is damaged: the file is too small");
    }
    return static_cast<std::uint64_t>(count);
  }

  void read_size() {
    Name name{};
    std::array<cgsize_t, 9> size{};
    CGNS_ENUMT(ZoneType_t) type{};
    library_.check(cg_zone_type(library_.file(), kBase, zone_, &type), "zone " + std::to_string(zone_));
    if (type != CGNS_ENUMV(Unstructured))
      library_.fail("zone " + std::to_string(zone_), "is not unstructured");
    library_.check(cg_zone_read(library_.file(), kBase, zone_, name.data(), size.data()), "zone");
    zone_name_ = std::string("zone ") + name.data();
    num_points_ = checked(size[0], zone_name_);
  }

  void read_mesh() {
    read_points();
    const int sections = num_sections();
    for (int s = 1; s <= sections; ++s) read_section(s);
    read_boundaries();
  }

  int num_sections() const {
    int sections = 0;
    library_.check(cg_nsections(library_.file(), kBase, zone_, &sections), zone_name_);
    return sections;
  }

  void read_points() {
    const std::uint64_t count = range_.num_points;
    mesh().points.resize(count);
    if (count == 0) return;
    std::vector<double> values(count);
    for (int c = 0; c < 3; ++c) {
      const char* name = kCoordinates[static_cast<std::size_t>(c)];
      const auto first = static_cast<cgsize_t>(range_.first_point + 1),
                 last = static_cast<cgsize_t>(range_.first_point + count);
      library_.check(cg_coord_read(library_.file(), kBase, zone_, name, CGNS_ENUMV(RealDouble), &first, &last,
                                   values.data()),
                     zone_name_ + ", " + name);
      for (std::size_t i = 0; i < count; ++i) {
        if (!passes(values[i], coordinates_)) {
          library_.fail(zone_name_ + ", point " + std::to_string(range_.first_point + i + 1),
                        "a coordinate is not finite");
        }
        mesh().points[i][c] = values[i];
      }
    }
  }

  SectionHead section_head(int s) {
    Name name{};
    SectionHead head;
    cgsize_t start = 0, end = 0;
    int boundary = 0, parent = 0;
    library_.check(cg_section_read(library_.file(), kBase, zone_, s, name.data(), &head.type, &start, &end,
                                   &boundary, &parent),
                   zone_name_ + ", section " + std::to_string(s));
    section_ = std::string("section ") + name.data();
    section_name_ = name.data();
    if (start < 1 || end < start) library_.fail(section_, "its range of elements is damaged");
    head.start = start;
    head.count = checked(std::int64_t{end} - head.start + 1, section_);
    return head;
  }

  void read_section(int s) {
    const SectionHead head = section_head(s);
    switch (head.type) {
      case CGNS_ENUMV(NGON_n):
        return contents().drop("polygons", head.count);
      case CGNS_ENUMV(NFACE_n):
        return contents().drop_volumes("polyhedra", head.count);
      case CGNS_ENUMV(MIXED):
        return read_mixed(head);
      default:
        read_alike(head);
    }
  }

  /// Elements of one type.
  void read_alike(const SectionHead& head) {
    const std::size_t nodes = num_nodes(head.type);
    if (nodes == 0) library_.fail(section_, "has the unknown type " + std::to_string(head.type));
    SectionData data(library_, zone_, section_name_);
    if (data.size() != nodes * head.count)
      library_.fail(section_, "its data are not those of its range of elements");
    switch (head.type) {
      case CGNS_ENUMV(TETRA_4):
        return read_tets(head, data);
      case CGNS_ENUMV(TRI_3):
        return read_triangles(head, data);
      case CGNS_ENUMV(BAR_2):
        return read_edges(head, data);
      default:
        return drop_elements(head.type, head.count);
    }
  }

  // Of these three the section's name gets its reference whether any of its elements is kept or none.

  void read_tets(const SectionHead& head, SectionData& data) {
    const std::int32_t ref = tet_ref();
    read_kept<4>(head, data, kept_tets_, [&](const std::int64_t* nodes) { add_tet(nodes, ref); });
  }

  void read_triangles(const SectionHead& head, SectionData& data) {
    triangle_names_.add(head.start, head.count, name_index(section_name_));
    read_kept<3>(head, data, kept_triangles_,
                 [&](const std::int64_t* nodes) { mesh().triangles.push_back(nodes_of<3>(nodes)); });
  }

  void read_edges(const SectionHead& head, SectionData& data) {
    const std::int32_t ref = edge_ref();
    read_kept<2>(head, data, kept_edges_, [&](const std::int64_t* nodes) { add_edge(nodes, ref); });
  }

  /// Passes a section of elements of N nodes; nothing of others than those that are kept is read.
  template <std::size_t N, class Add>
  void read_kept(const SectionHead& head, SectionData& data, KeptRows& kept, const Add& add) {
    const KeptRows::Rows rows = kept.among(head.count);
    kept.pass(head.count);
    data.seek(N * rows.first);
    for (std::uint64_t i = rows.first; i < rows.first + rows.count; ++i) {
      element_ = head.start + static_cast<std::int64_t>(i);
      add(data.take(N));
    }
  }

  /// What the tets' reference is they say together, on every reader; so do edges.
  void read_mixed(const SectionHead& head) {
    std::optional<std::int32_t> of_tets, of_edges;
    for_each_mixed(head, [&](CgnsType type, const std::int64_t* nodes) {
      switch (type) {
        case CGNS_ENUMV(TETRA_4):
          if (!of_tets) of_tets = tet_ref();
          if (kept_tets_.take()) add_tet(nodes, *of_tets);
          return;
        case CGNS_ENUMV(TRI_3):
          triangle_names_.add(element_, 1, name_index(section_name_));
          if (kept_triangles_.take()) mesh().triangles.push_back(nodes_of<3>(nodes));
          return;
        case CGNS_ENUMV(BAR_2):
          if (!of_edges) of_edges = edge_ref();
          if (kept_edges_.take()) add_edge(nodes, *of_edges);
          return;
        default:
          drop_elements(type, 1);
      }
    });
  }

  /// use(type, nodes) for each element, before whose nodes stands the number of its type. (That says all that
  /// ElementStartOffset does, which files before version 3.4 do not have.)
  template <class Use>
  void for_each_mixed(const SectionHead& head, const Use& use) {
    const int version = library_.version();
    SectionData data(library_, zone_, section_name_);
    for (std::uint64_t i = 0; i < head.count; ++i) {
      element_ = head.start + static_cast<std::int64_t>(i);
      const std::int64_t* number = data.take(1);
      if (!number) fail_element("is missing");
      if (*number < 0 || *number >= NofValidElementTypes) fail_element("has an unknown type");
      const CgnsType type = mixed_type(*number, version);
      const std::size_t count = type == CGNS_ENUMV(MIXED) ? 0 : num_nodes(type);
      if (count == 0) fail_element("has the unknown type " + std::to_string(*number));
      const std::int64_t* nodes = data.take(count);
      if (!nodes) fail_element("is missing");
      use(type, nodes);
    }
    if (data.left() > 0) library_.fail(section_, "has more data than its range of elements says");
  }

  /// None for a type that is unknown, or has no number of nodes.
  static std::size_t num_nodes(CgnsType type) {
    int nodes = 0;
    return cg_npe(type, &nodes) == CG_OK && nodes > 0 ? static_cast<std::size_t>(nodes) : 0;
  }

  [[noreturn]] void fail_element(const std::string& reason) const {
    library_.fail(section_ + ", element " + std::to_string(element_), reason);
  }

  template <std::size_t N>
  std::array<std::uint32_t, N> nodes_of(const std::int64_t* data) const {
    std::array<std::uint32_t, N> nodes;
    for (std::size_t i = 0; i < N; ++i) {
      if (data[i] < 1 || static_cast<std::uint64_t>(data[i]) > num_points_) {
        fail_element("vertex index " + std::to_string(data[i]) + " is out of range 1.." +
                     std::to_string(num_points_));
      }
      nodes[i] = static_cast<std::uint32_t>(data[i] - 1);
    }
    return nodes;
  }

  static std::string_view without(std::string_view prefix, std::string_view name) {
    return name.starts_with(prefix) ? name.substr(prefix.size()) : name;
  }

  std::int32_t tet_ref() { return refs_.tets.ref(without(kTetPrefix, section_name_)); }

  void add_tet(const std::int64_t* nodes, std::int32_t ref) {
    mesh().tets.push_back(nodes_of<4>(nodes));
    mesh().tet_refs.push_back(ref);
  }

  std::int32_t edge_ref() { return refs_.edges.ref(without(kEdgePrefix, section_name_)); }

  void add_edge(const std::int64_t* nodes, std::int32_t ref) {
    mesh().edges.push_back(nodes_of<2>(nodes));
    mesh().edge_refs.push_back(ref);
  }

  void drop_elements(CgnsType type, std::uint64_t count) {
    const std::string_view kind = cg_ElementTypeName(type);
    const std::string name = "elements " + std::string(kind);
    const bool volume = kind.starts_with("TETRA") || kind.starts_with("PYRA") || kind.starts_with("PENTA") ||
                        kind.starts_with("HEXA");
    volume ? contents().drop_volumes(name, count) : contents().drop(name, count);
  }

  std::uint32_t name_index(const std::string& name) {
    if (names_.empty() || names_.back() != name) names_.push_back(name);
    return static_cast<std::uint32_t>(names_.size() - 1);
  }

  /// Boundary conditions name triangles by the numbers of the elements. Names get their references in the
  /// order of all triangles.
  void read_boundaries() {
    int count = 0;
    library_.check(cg_nbocos(library_.file(), kBase, zone_, &count), zone_name_);
    for (int b = 1; b <= count; ++b) read_boundary(b);
    KeptRows kept = kept_triangles_.again();
    triangle_names_.for_each_run([&](std::uint64_t begin, std::uint64_t end, std::uint32_t name) {
      const std::int32_t ref = refs_.triangles.ref(names_[name]);
      mesh().triangle_refs.insert(mesh().triangle_refs.end(), kept.among(end - begin).count, ref);
      kept.pass(end - begin);
    });
  }

  /// By the next number; damaged files have any.
  static bool follows(cgsize_t element, cgsize_t other) { return element > 0 && element - 1 == other; }

  void read_boundary(int b) {
    Name name{};
    CGNS_ENUMT(BCType_t) type{};
    CGNS_ENUMT(PointSetType_t) set{};
    CGNS_ENUMT(DataType_t) normal_type{};
    CGNS_ENUMT(GridLocation_t) location{};
    cgsize_t count = 0, normals = 0;
    int normal_index[3] = {}, datasets = 0;
    const std::string entity = zone_name_ + ", boundary condition " + std::to_string(b);
    library_.check(cg_boco_info(library_.file(), kBase, zone_, b, name.data(), &type, &set, &count,
                                normal_index, &normals, &normal_type, &datasets),
                   entity);
    library_.check(cg_boco_gridlocation_read(library_.file(), kBase, zone_, b, &location), entity);
    const bool elements = set == CGNS_ENUMV(ElementRange) || set == CGNS_ENUMV(ElementList);
    const bool faces =
        (set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(PointList)) && location != CGNS_ENUMV(Vertex);
    if (!elements && !faces) return contents().drop("boundary conditions at vertices");
    std::vector<cgsize_t> points(checked(count, entity));
    if (points.empty()) return;
    library_.check(cg_boco_read(library_.file(), kBase, zone_, b, points.data(), nullptr), entity);
    const std::uint32_t index = name_index(name.data());
    if (set == CGNS_ENUMV(ElementRange) || set == CGNS_ENUMV(PointRange)) {
      if (points.size() != 2) library_.fail(entity, "its range is damaged");
      return triangle_names_.rename(points[0], points[1], index);
    }
    for (std::size_t i = 0; i < points.size();) {  // lists are mostly of consecutive elements
      std::size_t end = i + 1;
      while (end < points.size() && follows(points[end], points[end - 1])) ++end;
      triangle_names_.rename(points[i], points[end - 1], index);
      i = end;
    }
  }

  void read_solutions() {
    int count = 0;
    library_.check(cg_nsols(library_.file(), kBase, zone_, &count), zone_name_);
    for (int s = 1; s <= count; ++s) read_solution(s);
  }

  void read_solution(int s) {
    Name name{};
    CGNS_ENUMT(GridLocation_t) location{};
    int count = 0;
    const std::string entity = zone_name_ + ", solution " + std::to_string(s);
    library_.check(cg_sol_info(library_.file(), kBase, zone_, s, name.data(), &location), entity);
    library_.check(cg_nfields(library_.file(), kBase, zone_, s, &count), entity);
    if (location != CGNS_ENUMV(Vertex)) {
      return contents().drop("fields that are not at vertices",
                             static_cast<std::uint64_t>(std::max(0, count)));
    }
    std::vector<Field> scalars;
    for (int f = 1; f <= count && num_points_ > 0; ++f) {
      CGNS_ENUMT(DataType_t) type{};
      library_.check(cg_field_info(library_.file(), kBase, zone_, s, f, &type, name.data()), entity);
      std::vector<double> values(range_.num_points);
      const auto first = static_cast<cgsize_t>(range_.first_point + 1),
                 last = static_cast<cgsize_t>(range_.first_point + range_.num_points);
      if (!values.empty())
        library_.check(cg_field_read(library_.file(), kBase, zone_, s, name.data(), CGNS_ENUMV(RealDouble),
                                     &first, &last, values.data()),
                       entity + ", field " + name.data());
      scalars.push_back({Field::Kind::scalar, std::move(values), name.data()});
    }
    join_components(scalars);
  }

  /// Fields that are called NAMEX, NAMEY, NAMEZ one after another are a vector, likewise a tensor.
  void join_components(std::vector<Field>& scalars) {
    for (std::size_t i = 0; i < scalars.size();) {
      if (joins(scalars, i, kTensorEnds)) {
        join(scalars, i, kTensorEnds, Field::Kind::tensor);
        i += kTensorEnds.size();
      } else if (joins(scalars, i, kVectorEnds)) {
        join(scalars, i, kVectorEnds, Field::Kind::vector);
        i += kVectorEnds.size();
      } else {
        contents().fields.fields.push_back(std::move(scalars[i++]));
      }
    }
  }

  template <std::size_t N>
  static bool joins(const std::vector<Field>& scalars, std::size_t begin,
                    const std::array<const char*, N>& ends) {
    if (begin + N > scalars.size() || !scalars[begin].name.ends_with(ends[0])) return false;
    const std::string prefix =
        scalars[begin].name.substr(0, scalars[begin].name.size() - std::string_view(ends[0]).size());
    for (std::size_t c = 0; c < N; ++c) {
      if (scalars[begin + c].name != prefix + ends[c]) return false;
    }
    return true;
  }

  template <std::size_t N>
  void join(const std::vector<Field>& scalars, std::size_t begin, const std::array<const char*, N>& ends,
            Field::Kind kind) {
    const std::string& first = scalars[begin].name;
    Field field{kind, std::vector<double>(range_.num_points * N),
                first.substr(0, first.size() - std::string_view(ends[0]).size())};
    for (std::size_t c = 0; c < N; ++c) {
      for (std::size_t i = 0; i < range_.num_points; ++i)
        field.values[i * N + c] = scalars[begin + c].values[i];
    }
    contents().fields.fields.push_back(std::move(field));
  }

  const Library& library_;
  int zone_;
  std::uint64_t most_, num_points_ = 0;
  MeshRange range_;
  Coordinates coordinates_ = Coordinates::finite;
  KeptRows kept_tets_, kept_triangles_, kept_edges_;  ///< of the sections so far
  MeshPiece piece_;
  ZoneRefs& refs_;
  std::string zone_name_, section_, section_name_;
  std::int64_t element_ = 0;
  std::vector<std::string> names_;
  TriangleNames triangle_names_;  ///< indices of names_
};

/// Opens the file in another process first: HDF5 1.10 itself can crash on damaged structure (it frees link
/// tables that it has not filled), and keeps open what it could not read. The other process begins with the
/// same memory as this one, so what it survives this one survives.
void check_that_it_opens(const std::filesystem::path& path) {
  constexpr unsigned kPatienceSeconds = 60;
  const auto issue = issue_of_child(
      [&]() -> std::string {
        int file = 0, type = CG_FILE_NONE;
        if (cg_is_cgns(path.c_str(), &type) != CG_OK || type != CG_FILE_HDF5)
          return "not a CGNS file in HDF5";
        if (cg_open(path.c_str(), CG_MODE_READ, &file) != CG_OK) return cg_get_error();
        cg_close(file);
        return "";
      },
      kPatienceSeconds);
  if (!issue) throw InputError(path.string(), "", "the file is damaged: the CGNS library crashes on it");
  if (!issue->empty()) throw InputError(path.string(), "", *issue);
}

std::uint64_t checked_size(const std::filesystem::path& path) {
  const std::uint64_t size = InputFile(path).size();  // for its messages: the library's are poor
  check_that_it_opens(path);
  return size;
}

/// A file that has a base of three dimensions with at least one zone.
struct OpenFile {
  explicit OpenFile(const std::filesystem::path& path)
      : size(checked_size(path)), library(path, CG_MODE_READ, path.string()) {
    int cell_dimension = 0, space_dimension = 0;
    library.check(cg_nbases(library.file(), &bases), "");
    if (bases < 1) library.fail("", "has no base");
    Name name{};
    library.check(cg_base_read(library.file(), kBase, name.data(), &cell_dimension, &space_dimension),
                  "base 1");
    if (space_dimension != 3) library.fail("base 1", "is not three-dimensional");
    library.check(cg_nzones(library.file(), kBase, &zones), "base 1");
    if (zones < 1) library.fail("base 1", "has no zone");
  }

  std::lock_guard<std::mutex> lock{library_mutex()};
  std::uint64_t size;
  Library library;
  int bases = 0, zones = 0;
};

}  // namespace

MeshContents read_cgns(const std::filesystem::path& path, Coordinates wanted) {
  const OpenFile open(path);
  RefNames names;
  ZoneRefs refs(names);
  std::vector<MeshPiece> pieces;
  for (int zone = 1; zone <= open.zones; ++zone)
    pieces.push_back(ZoneReader(open.library, zone, open.size, refs).read(wanted));
  MeshContents contents = merge_pieces(std::move(pieces));
  contents.names = std::move(names);
  contents.drop("bases after the first", static_cast<std::uint64_t>(open.bases - 1));
  return contents;
}

std::optional<MeshSize> cgns_size(const std::filesystem::path& path) {
  const OpenFile open(path);
  RefNames names;
  ZoneRefs refs(names);
  if (open.zones > 1) return std::nullopt;
  return ZoneReader(open.library, 1, open.size, refs).size();
}

MeshContents read_cgns_range(const std::filesystem::path& path, const MeshRange& range) {
  const OpenFile open(path);
  RefNames names;
  ZoneRefs refs(names);
  MeshContents contents = ZoneReader(open.library, 1, open.size, refs).read(range);
  contents.names = std::move(names);
  contents.drop("bases after the first", static_cast<std::uint64_t>(open.bases - 1));
  return contents;
}

std::vector<PieceSize> cgns_piece_sizes(const std::filesystem::path& path) {
  const OpenFile open(path);
  RefNames names;
  ZoneRefs refs(names);
  std::vector<PieceSize> sizes;
  for (int zone = 1; zone <= open.zones; ++zone) {
    sizes.push_back(ZoneReader(open.library, zone, open.size, refs).size());
  }
  return sizes;
}

PieceRanges read_cgns_piece_ranges(const std::filesystem::path& path, std::span<const PieceRange> ranges) {
  const OpenFile open(path);
  PieceRanges result;
  ZoneRefs refs(result.names);
  for (int zone = 1; zone <= open.zones; ++zone) {
    const PieceRange& range = ranges[static_cast<std::size_t>(zone - 1)];
    MeshContents read = ZoneReader(open.library, zone, open.size, refs).read(range.rows, range.others);
    if (zone == 1) read.drop("bases after the first", static_cast<std::uint64_t>(open.bases - 1));
    MeshPiece& piece = result.pieces.emplace_back();
    if (range.others) {
      piece.contents = std::move(read);
    } else {
      piece.contents.mesh.points = std::move(read.mesh.points);
      piece.contents.mesh.tets = std::move(read.mesh.tets);
      piece.contents.mesh.tet_refs = std::move(read.mesh.tet_refs);
      piece.contents.complete();
    }
  }
  return result;
}

std::vector<MeshContents> read_cgns_piece_fields(const std::filesystem::path& path,
                                                 std::span<const PieceRange> ranges) {
  const OpenFile open(path);
  RefNames names;
  ZoneRefs refs(names);
  std::vector<MeshContents> result;
  const int zones = std::min(open.zones, static_cast<int>(ranges.size()));
  for (int zone = 1; zone <= zones; ++zone) {
    const PieceRange& range = ranges[static_cast<std::size_t>(zone - 1)];
    result.push_back(ZoneReader(open.library, zone, open.size, refs).fields(range.rows));
    if (!range.others) result.back().dropped.clear();
  }
  return result;
}

}  // namespace weft::meshing
