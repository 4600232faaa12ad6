// Arrays are written past the CGNS library: it makes them, HDF5 says where their values are in the file, and
// any number of writers put these there.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "meshing/io/cgns.h"
#include "meshing/io/cgns_library.h"
#include "meshing/io/files/atomic_file.h"
#include "meshing/io/files/child_process.h"
#include "meshing/io/files/file_part.h"

namespace weft::meshing {
namespace {

using namespace cgns;

constexpr const char *kBaseName = "Base", *kZoneName = "Zone", *kSolutionName = "Solution";

/// Names of siblings, which CGNS wants different, without slashes, and of 32 characters at most.
class NodeNames {
 public:
  std::string unique(const std::string& name) { return names_.unique(without_slashes(name)); }
  /// Of the components of a field: they belong together by what they begin with.
  template <std::size_t N>
  std::array<std::string, N> unique(const std::string& field, const std::array<const char*, N>& ends) {
    const std::string begin = names_.unique_begin(without_slashes(field), ends);
    std::array<std::string, N> names;
    for (std::size_t i = 0; i < N; ++i) names[i] = begin + ends[i];
    return names;
  }

 private:
  static std::string without_slashes(std::string name) {
    std::ranges::replace(name, '/', '_');
    return name;
  }

  UniqueNames names_{kNameLength};
};

/// What the components of fields are called, all in order.
std::vector<std::string> component_names(const SolutionData& fields) {
  NodeNames unique_names;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < fields.fields.size(); ++i) {
    const std::string name = field_name(fields, i);
    switch (fields.fields[i].kind) {
      case Field::Kind::scalar:
        names.push_back(unique_names.unique(name));
        break;
      case Field::Kind::vector:
        std::ranges::move(unique_names.unique(name, kVectorEnds), std::back_inserter(names));
        break;
      case Field::Kind::tensor:
        std::ranges::move(unique_names.unique(name, kTensorEnds), std::back_inserter(names));
        break;
    }
  }
  return names;
}

/// One zone of a mesh without its rows: of every array one value is written, which gives all of it a place.
class ZoneLayout {
 public:
  ZoneLayout(const Library& library, const WholeMesh& whole) : library_(library), whole_(whole) {}

  void write() {
    write_zone();
    write_sections(CGNS_ENUMV(TETRA_4), whole_.tets, 3, std::string(kTetPrefix));
    write_sections(CGNS_ENUMV(TRI_3), whole_.triangles, 2, "");
    write_sections(CGNS_ENUMV(BAR_2), whole_.edges, 1, std::string(kEdgePrefix));
    write_fields();
  }

 private:
  void write_zone() {
    const auto most = static_cast<std::size_t>(std::numeric_limits<cgsize_t>::max());
    if (whole_.points > most || 4 * (whole_.num_tets() + whole_.num_triangles()) > most) {
      library_.fail("", "the mesh is too large for the integers of this CGNS library");
    }
    int base = 0, index = 0;
    library_.check(cg_base_write(library_.file(), kBaseName, 3, 3, &base), "base");
    const std::array<cgsize_t, 3> size = {static_cast<cgsize_t>(whole_.points),
                                          static_cast<cgsize_t>(whole_.num_tets()), 0};
    library_.check(
        cg_zone_write(library_.file(), base, kZoneName, size.data(), CGNS_ENUMV(Unstructured), &zone_),
        "zone");
    const double value = 0;
    for (const char* name : kCoordinates)
      library_.check(cg_coord_partial_write(library_.file(), base, zone_, CGNS_ENUMV(RealDouble), name, &kOne,
                                            &kOne, &value, &index),
                     "coordinates");
  }

  void write_sections(CGNS_ENUMT(ElementType_t) type, const RefCounts& counts, int dimension,
                      const std::string& prefix) {
    const std::array<cgsize_t, 4> nodes = {1, 1, 1, 1};
    for (const auto& [ref, count] : counts) {
      const std::string name = section_names_.unique(prefix + whole_.names.name(dimension, ref));
      const cgsize_t first = next_element_, last = first + static_cast<cgsize_t>(count) - 1;
      int section = 0;
      library_.check(cg_section_partial_write(library_.file(), kBase, zone_, name.c_str(), type, first, last,
                                              0, &section),
                     "section " + name);
      library_.check(
          cg_elements_partial_write(library_.file(), kBase, zone_, section, first, first, nodes.data()),
          "section " + name);
      if (dimension == 2) write_boundary(name, first, last);
      next_element_ = last + 1;
    }
  }

  void write_boundary(const std::string& name, cgsize_t first, cgsize_t last) {
    const std::array<cgsize_t, 2> range = {first, last};
    int boundary = 0;
    library_.check(cg_boco_write(library_.file(), kBase, zone_, name.c_str(), CGNS_ENUMV(BCTypeUserDefined),
                                 CGNS_ENUMV(PointRange), 2, range.data(), &boundary),
                   "boundary condition " + name);
    library_.check(
        cg_boco_gridlocation_write(library_.file(), kBase, zone_, boundary, CGNS_ENUMV(FaceCenter)),
        "boundary condition " + name);
  }

  void write_fields() {
    if (whole_.fields.fields.empty()) return;
    int solution = 0, index = 0;
    const double value = 0;
    library_.check(cg_sol_write(library_.file(), kBase, zone_, kSolutionName, CGNS_ENUMV(Vertex), &solution),
                   "solution");
    for (const std::string& name : component_names(whole_.fields))
      library_.check(cg_field_partial_write(library_.file(), kBase, zone_, solution, CGNS_ENUMV(RealDouble),
                                            name.c_str(), &kOne, &kOne, &value, &index),
                     "field " + name);
  }

  static constexpr cgsize_t kOne = 1;

  const Library& library_;
  const WholeMesh& whole_;
  int zone_ = 0;
  NodeNames section_names_;
  cgsize_t next_element_ = 1;
};

/// The nodes of the arrays that ZoneLayout writes: coordinates, sections of tets, triangles and edges, and
/// the components of fields.
std::vector<std::string> array_nodes(const WholeMesh& whole) {
  const std::string zone = fmt::format("/{}/{}/", kBaseName, kZoneName);
  std::vector<std::string> nodes;
  for (const char* name : kCoordinates)
    nodes.push_back(fmt::format("{}GridCoordinates/{}/ data", zone, name));
  NodeNames section_names;
  const auto add = [&](const RefCounts& counts, int dimension, const std::string& prefix) {
    for (const auto& [ref, count] : counts)
      nodes.push_back(fmt::format("{}{}/ElementConnectivity/ data", zone,
                                  section_names.unique(prefix + whole.names.name(dimension, ref))));
  };
  add(whole.tets, 3, std::string(kTetPrefix));
  add(whole.triangles, 2, "");
  add(whole.edges, 1, std::string(kEdgePrefix));
  for (const std::string& name : component_names(whole.fields))
    nodes.push_back(fmt::format("{}{}/{}/ data", zone, kSolutionName, name));
  return nodes;
}

/// Where the values of these arrays are in a file. HDF5 is quiet about what it does not find.
PartPlaces places_of(const std::filesystem::path& file, const std::string& name,
                     const std::vector<std::string>& nodes) {
  PartPlaces places;
  H5E_BEGIN_TRY {
    const hid_t opened = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    for (const std::string& node : nodes) {
      const hid_t array = H5Dopen2(opened, node.c_str(), H5P_DEFAULT);
      const haddr_t place = array >= 0 ? H5Dget_offset(array) : HADDR_UNDEF;
      if (array >= 0) H5Dclose(array);
      if (place == HADDR_UNDEF) break;
      places.push_back(place);
    }
    if (opened >= 0) H5Fclose(opened);
  }
  H5E_END_TRY
  if (places.size() < nodes.size())
    throw InputError(name, "", "cannot write: HDF5 has no place for " + nodes[places.size()]);
  return places;
}

/// Puts rows where the layout has their places.
class CgnsPartWriter final : public PartWriter {
 public:
  CgnsPartWriter(PartTarget target, const WholeMesh& whole, const PartPlaces& places)
      : file_(std::move(target)), whole_(whole), places_(places) {}

  void write(const MeshPart& part) override {
    for (int c = 0; c < 3; ++c)
      write_column(static_cast<std::size_t>(c), part.first_point, part.points.size(),
                   [&](std::size_t i) { return part.points[i][c]; });
    std::size_t array = kCoordinates.size();
    write_sections(part.tets, whole_.tets, array);
    write_sections(part.triangles, whole_.triangles, array);
    write_sections(part.edges, whole_.edges, array);
    for (const Field& field : part.fields.fields) {
      const auto length = static_cast<std::size_t>(components(field.kind));
      for (std::size_t c = 0; c < length; ++c)
        write_column(array++, part.first_point, field.values.size() / length,
                     [&](std::size_t i) { return field.values[i * length + c]; });
    }
  }
  void finish() override { file_.finish(); }

 private:
  template <class Value>
  void write_column(std::size_t array, std::uint64_t first, std::size_t count, const Value& value) {
    if (count == 0) return;
    file_.seek(places_.at(array) + first * sizeof(double));
    for (std::size_t i = 0; i < count; ++i) file_.write_value(double{value(i)});
  }

  template <std::size_t N>
  void write_sections(const ElementRows<N>& rows, const RefCounts& counts, std::size_t& array) {
    const auto by_ref = rows_by_ref(rows);
    for (const auto& [ref, count] : counts) {
      const std::uint64_t place = places_.at(array++);
      const auto of_ref = by_ref.find(ref);
      if (of_ref == by_ref.end()) continue;
      file_.seek(place + N * of_ref->second.first * sizeof(cgsize_t));
      for (const std::uint32_t i : of_ref->second.indices)
        for (const std::uint64_t v : rows.elements[i]) file_.write_value(static_cast<cgsize_t>(v + 1));
    }
  }

  FilePart file_;
  const WholeMesh& whole_;
  PartPlaces places_;
};

/// A block of the elements of a mesh in memory.
template <std::size_t N>
class ElementBlock {
 public:
  ElementBlock(const std::vector<std::array<std::uint32_t, N>>& elements,
               const std::vector<std::int32_t>& refs)
      : elements_(elements), refs_(refs) {
    for (const std::int32_t ref : refs) passed_.try_emplace(ref, 0);
  }
  /// The next rows; of the block before none are needed any more.
  ElementRows<N> next(std::size_t most) {
    for (const auto& [ref, count] : count_refs(refs_of(begin_, end_))) passed_[ref] += count;
    begin_ = end_;
    end_ = std::min(elements_.size(), begin_ + most);
    rows_.resize(end_ - begin_);
    for (std::size_t i = begin_; i < end_; ++i)
      std::copy(elements_[i].begin(), elements_[i].end(), rows_[i - begin_].begin());
    return {rows_, refs_of(begin_, end_), begin_, passed_};
  }

 private:
  std::span<const std::int32_t> refs_of(std::size_t begin, std::size_t end) const {
    return std::span(refs_).subspan(begin, end - begin);
  }

  const std::vector<std::array<std::uint32_t, N>>& elements_;
  const std::vector<std::int32_t>& refs_;
  std::size_t begin_ = 0, end_ = 0;
  std::vector<std::array<std::uint64_t, N>> rows_;
  RefCounts passed_;
};

/// Everything by one writer, elements in blocks.
void write_as_parts(const MeshView& contents, PartWriter& out) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 16;
  const MeshData& mesh = contents.mesh;
  const SolutionData none;
  ElementBlock<4> tets(mesh.tets, mesh.tet_refs);
  ElementBlock<3> triangles(mesh.triangles, mesh.triangle_refs);
  ElementBlock<2> edges(mesh.edges, mesh.edge_refs);
  out.write({0, mesh.points, mesh.point_refs, tets.next(kAtOnce), triangles.next(kAtOnce),
             edges.next(kAtOnce), contents.fields});
  const std::size_t most = std::max({mesh.tets.size(), mesh.triangles.size(), mesh.edges.size()});
  for (std::size_t begin = kAtOnce; begin < most; begin += kAtOnce)
    out.write({0, {}, {}, tets.next(kAtOnce), triangles.next(kAtOnce), edges.next(kAtOnce), none});
  out.finish();
}

/// The library does not look whether its bytes reached the disk.
void sync_file(const std::filesystem::path& path, const Library& library) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) library.fail("", "cannot write: the data did not reach the disk");
}

/// The library does not say why a file cannot be written ("File Close error"); the system's last error does.
void write_layout(const std::filesystem::path& file, const std::string& name, const WholeMesh& whole) {
  errno = 0;
  try {
    Library library(file, CG_MODE_WRITE, name);
    ZoneLayout(library, whole).write();
    library.close();
    sync_file(file, library);
  } catch (const InputError&) {
    const int error = errno;
    if (error != ENOSPC && error != EDQUOT && error != EFBIG && error != EIO) throw;
    throw InputError(name, "", "cannot write: " + std::generic_category().message(error));
  }
}

}  // namespace

PartPlaces begin_cgns_parts(const std::filesystem::path& file, const std::filesystem::path& name,
                            const WholeMesh& whole) {
  // A full disk keeps HDF5 from closing the file, and a later file would meet what is left of it: it is left
  // in another process. Its end closes the file, too.
  const std::lock_guard lock(library_mutex());
  const auto issue = issue_of_child(
      [&]() -> std::string {
        write_layout(file, name.string(), whole);
        return "";
      },
      0);
  if (!issue) throw InputError(name.string(), "", "cannot write: the CGNS library did not get to its end");
  if (!issue->empty()) throw InputError("", "", *issue);
  return places_of(file, name.string(), array_nodes(whole));
}

std::unique_ptr<PartWriter> open_cgns_part(PartTarget target, const WholeMesh& whole,
                                           const PartPlaces& places) {
  return std::make_unique<CgnsPartWriter>(std::move(target), whole, places);
}

void write_cgns(const std::filesystem::path& path, const MeshView& contents, const WriteOptions&) {
  check_lengths(contents.mesh, contents.fields);
  AtomicFile file(path);
  const WholeMesh whole = describe(contents);
  const PartPlaces places = begin_cgns_parts(file.temporary(), path, whole);
  write_as_parts(contents, *open_cgns_part({file.temporary(), path.string()}, whole, places));
  file.commit();
}

}  // namespace weft::meshing
