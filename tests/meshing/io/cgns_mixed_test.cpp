// CGNS files with sections of mixed elements: whole, in ranges, as older and other programs write them,
// damaged.
#include <cgns_io.h>
#include <cgnslib.h>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "meshing/io/cgns.h"
#include "meshing/mesh/structured_box.h"
#include "tests/meshing/io/format_support.h"

namespace weft::meshing::cgns_mixed_test {
namespace {

using Numbers = std::vector<std::int64_t>;

struct Section {
  std::string name;
  bool mixed = true;
  Numbers data = {}, offsets = {0};

  template <std::size_t N>
  void add(CGNS_ENUMT(ElementType_t) type, const std::array<std::uint32_t, N>& nodes) {
    if (mixed) data.push_back(type);
    for (const std::uint32_t v : nodes) data.push_back(v + 1);
    offsets.push_back(static_cast<std::int64_t>(data.size()));
  }
};

/// Tets of a box in three sections, the second of them not mixed; in the others are triangles and edges, and
/// quadrangles, which are no part of the mesh that is expected. The mixed ones are longer than two blocks
/// of reading.
struct MixedBox {
  MixedBox() {
    const MeshData box = structured_box({{24, 24, 24}, {0, 0, 0}, {1, 1, 1}});
    mesh.points = box.points;
    const std::size_t third = box.tets.size() / 3;
    std::size_t triangle = 0, edge = 0;
    for (std::size_t t = 0; t < box.tets.size(); ++t) {
      Section& section = sections[std::min(t / third, std::size_t{2})];
      const std::int32_t ref = refs[std::min(t / third, std::size_t{2})];
      section.add(CGNS_ENUMV(TETRA_4), box.tets[t]);
      mesh.tets.push_back(box.tets[t]);
      mesh.tet_refs.push_back(ref);
      if (!section.mixed) continue;
      if (t % 7 == 0 && triangle < box.triangles.size()) {
        section.add(CGNS_ENUMV(TRI_3), box.triangles[triangle]);
        mesh.triangles.push_back(box.triangles[triangle++]);
        mesh.triangle_refs.push_back(ref);
      }
      if (t % 1000 == 0 && edge < box.edges.size()) {
        section.add(CGNS_ENUMV(BAR_2), box.edges[edge]);
        mesh.edges.push_back(box.edges[edge++]);
        mesh.edge_refs.push_back(ref);
      }
      if (t % 900 == 0) section.add(CGNS_ENUMV(QUAD_4), std::array<std::uint32_t, 4>{0, 1, 3, 2}), ++quads;
    }
    mesh.point_refs.assign(mesh.points.size(), 0);
  }

  static constexpr std::array<std::int32_t, 3> refs = {1, 6, 7};  // of "air": the first that is free
  std::array<Section, 3> sections = {{{"air"}, {"tets_6", false}, {"7"}}};
  MeshData mesh;
  std::uint64_t quads = 0;
};

std::vector<cgsize_t> as_sizes(const Numbers& numbers) { return {numbers.begin(), numbers.end()}; }

/// As the library writes them.
void write(const fs::path& path, const MixedBox& box) {
  int file = 0, index = 0;
  cgsize_t element = 1;
  const auto points = box.mesh.points.size();
  const std::array<cgsize_t, 3> size = {static_cast<cgsize_t>(points),
                                        static_cast<cgsize_t>(box.mesh.tets.size()), 0};
  cg_set_file_type(CG_FILE_HDF5);
  ASSERT_EQ(cg_open(path.c_str(), CG_MODE_WRITE, &file), CG_OK) << cg_get_error();
  ASSERT_EQ(cg_base_write(file, "Base", 3, 3, &index), CG_OK);
  ASSERT_EQ(cg_zone_write(file, 1, "Zone", size.data(), CGNS_ENUMV(Unstructured), &index), CG_OK);
  for (int c = 0; c < 3; ++c) {
    std::vector<double> column(points);
    for (std::size_t i = 0; i < points; ++i) column[i] = box.mesh.points[i][c];
    const std::string name = std::string("Coordinate") + "XYZ"[c];
    ASSERT_EQ(cg_coord_write(file, 1, 1, CGNS_ENUMV(RealDouble), name.c_str(), column.data(), &index), CG_OK);
  }
  for (const Section& section : box.sections) {
    const auto data = as_sizes(section.data), offsets = as_sizes(section.offsets);
    const cgsize_t last = element + static_cast<cgsize_t>(offsets.size()) - 2;
    const char* name = section.name.c_str();
    const int status = section.mixed ? cg_poly_section_write(file, 1, 1, name, CGNS_ENUMV(MIXED), element,
                                                             last, 0, data.data(), offsets.data(), &index)
                                     : cg_section_write(file, 1, 1, name, CGNS_ENUMV(TETRA_4), element, last,
                                                        0, data.data(), &index);
    ASSERT_EQ(status, CG_OK) << cg_get_error();
    element = last + 1;
  }
  ASSERT_EQ(cg_close(file), CG_OK);
}

/// A file changed below the library's functions for meshes.
class RawFile {
 public:
  explicit RawFile(const fs::path& path) {
    EXPECT_EQ(cgio_open_file(path.c_str(), CGIO_MODE_MODIFY, CGIO_FILE_HDF5, &io_), 0);
    EXPECT_EQ(cgio_get_root_id(io_, &root_), 0);
  }
  ~RawFile() { EXPECT_EQ(cgio_close_file(io_), 0); }
  RawFile(const RawFile&) = delete;
  RawFile& operator=(const RawFile&) = delete;

  /// The elements' data, in 64 bits.
  void put_data(const std::string& section, const Numbers& numbers, int dimensions = 1) const {
    put(section, numbers, "I8", dimensions);
  }
  void put_short_data(const std::string& section, const Numbers& numbers) const {
    put(section, std::vector<std::int32_t>(numbers.begin(), numbers.end()), "I4", 1);
  }
  void remove_offsets(const std::string& section) const {
    const double parent = node_of(root_, "Base/Zone/" + section);
    EXPECT_EQ(cgio_delete_node(io_, parent, node_of(parent, "ElementStartOffset")), 0);
  }
  /// Of all elements of a section.
  void put_type(const std::string& section, int type) const {
    const std::array<int, 2> values = {type, 0};
    EXPECT_EQ(cgio_write_all_data(io_, node_of(root_, "Base/Zone/" + section), values.data()), 0);
  }
  void put_version(float version) const {
    EXPECT_EQ(cgio_write_all_data(io_, node_of(root_, "CGNSLibraryVersion"), &version), 0);
  }

 private:
  template <class T>
  void put(const std::string& section, const std::vector<T>& numbers, const char* type,
           int dimensions) const {
    const double node = node_of(node_of(root_, "Base/Zone/" + section), "ElementConnectivity");
    const std::array<cgsize_t, 2> lengths = {static_cast<cgsize_t>(numbers.size()), 1};
    EXPECT_EQ(cgio_set_dimensions(io_, node, type, dimensions, lengths.data()), 0);
    EXPECT_EQ(cgio_write_all_data(io_, node, numbers.data()), 0);
  }
  double node_of(double parent, const std::string& name) const {
    double id = 0;
    EXPECT_EQ(cgio_get_node_id(io_, parent, name.c_str(), &id), 0) << name;
    return id;
  }

  int io_ = 0;
  double root_ = 0;
};

/// What differs between the files of versions and builds of the library.
struct Variant {
  const char* name;
  bool long_numbers;
  std::optional<float> version_without_offsets;
};

template <class T>
void append(const std::vector<T>& part, std::vector<T>& all) {
  all.insert(all.end(), part.begin(), part.end());
}

/// The mesh put together of what so many readers read.
MeshData read_in_parts(const fs::path& path, std::uint64_t parts, const RefNames& names) {
  const auto size = cgns_size(path);
  if (!size) throw std::runtime_error("no size");
  MeshData mesh;
  for (std::uint64_t p = 0; p < parts; ++p) {
    const auto begin = [&](std::uint64_t total, std::uint64_t part) { return total * part / parts; };
    const std::uint64_t point = begin(size->points, p), tet = begin(size->tets, p);
    const MeshContents read = read_cgns_range(
        path, {point, begin(size->points, p + 1) - point, tet, begin(size->tets, p + 1) - tet, p, parts});
    EXPECT_EQ(read.names.all(), names.all()) << p;
    EXPECT_EQ(read.mesh.tets.size(), begin(size->tets, p + 1) - tet);
    append(read.mesh.points, mesh.points), append(read.mesh.point_refs, mesh.point_refs);
    append(read.mesh.tets, mesh.tets), append(read.mesh.tet_refs, mesh.tet_refs);
    append(read.mesh.triangles, mesh.triangles), append(read.mesh.triangle_refs, mesh.triangle_refs);
    append(read.mesh.edges, mesh.edges), append(read.mesh.edge_refs, mesh.edge_refs);
  }
  return mesh;
}

class CgnsMixed : public testing::Test {
 protected:
  fs::path written(const MixedBox& box, const std::string& name) {
    write(directory / name, box);
    return directory / name;
  }
  TemporaryDirectory directory;
};

TEST_F(CgnsMixed, SectionsAreReadWholeAndInRangesAsTheyWereWritten) {
  const MixedBox box;
  for (const Section& section : {box.sections[0], box.sections[2]}) {
    ASSERT_GT(section.data.size(), std::size_t{2} << 16) << "more than two blocks";
  }
  for (const Variant& variant :
       {Variant{"m34.cgns", false, {}}, Variant{"long34.cgns", true, {}}, Variant{"m33.cgns", false, 3.3F},
        Variant{"long33.cgns", true, 3.3F}, Variant{"m25.cgns", false, 2.5F}}) {
    SCOPED_TRACE(variant.name);
    const fs::path path = written(box, variant.name);
    {
      const RawFile raw(path);
      for (const Section& section : box.sections) {
        if (variant.long_numbers) raw.put_data(section.name, section.data);
        if (variant.version_without_offsets && section.mixed) raw.remove_offsets(section.name);
      }
      if (variant.version_without_offsets) raw.put_version(*variant.version_without_offsets);
    }
    const MeshContents whole = read_cgns(path);
    expect_equal(whole.mesh, box.mesh);
    EXPECT_EQ(whole.names.name(3, 1), "air");
    EXPECT_TRUE(dropped(whole, "elements QUAD_4", box.quads));
    const auto size = cgns_size(path);
    ASSERT_TRUE(size);
    EXPECT_EQ(size->points, box.mesh.points.size());
    EXPECT_EQ(size->tets, box.mesh.tets.size());
    for (const std::uint64_t parts : {1u, 3u, 7u})
      expect_equal(read_in_parts(path, parts, whole.names), box.mesh);
    const std::vector<PieceSize> pieces = cgns_piece_sizes(path);
    ASSERT_EQ(pieces.size(), 1u);
    EXPECT_EQ(pieces[0].tets, box.mesh.tets.size());
  }
}

/// Of 3.0 a pyramid of 13 nodes has the number that one of 14 has had since, and all above it one more.
TEST_F(CgnsMixed, TypesOfOldVersionsAreThoseOfTheirTime) {
  const MixedBox whole;
  int number = 0;
  const auto message = [&](float version, std::int64_t first, std::size_t nodes) {
    MixedBox box = whole;
    const fs::path path = written(box, std::to_string(++number) + ".cgns");
    Numbers& data = box.sections[0].data;
    data.erase(data.begin(), data.begin() + 5);
    data.insert(data.begin(), nodes, 1);
    data.insert(data.begin(), first);
    {
      const RawFile raw(path);
      raw.put_short_data("air", data);  // on 64 bits the library crashes, where it has to change types
      for (const char* section : {"air", "7"}) {
        raw.remove_offsets(section);
        if (version < 3.1F) raw.put_type(section, CGNS_ENUMV(MIXED) + 1);
      }
      raw.put_version(version);
    }
    MeshContents read;
    const std::string issue = message_of([&] { read = read_cgns(path); });
    return issue == "no error" ? read.dropped.front().what : issue;
  };
  EXPECT_EQ(message(3.0F, 13, 13), "elements PYRA_13");
  EXPECT_EQ(message(3.0F, 14, 14), "elements PYRA_14");
  EXPECT_EQ(message(3.0F, 15, 6), "elements PENTA_6");
  EXPECT_EQ(message(3.1F, 14, 6), "elements PENTA_6");
  EXPECT_EQ(message(3.3F, 13, 14), "elements PYRA_14");
  expect_contains(message(3.1F, 22 + 4, 4), "section air, element 1: has the unknown type 26");  // a polygon
}

/// Of the first section, some way behind its first block.
TEST_F(CgnsMixed, DamageIsNamedWithItsElement) {
  const MixedBox box;
  const Section& section = box.sections[0];
  std::size_t element = 20000;
  const auto place_of = [&] { return static_cast<std::size_t>(section.offsets[element]); };
  while (section.data[place_of()] != CGNS_ENUMV(TETRA_4)) ++element;
  const std::size_t place = place_of();
  ASSERT_GT(place, std::size_t{1} << 16);
  int number = 0;
  const auto damaged = [&](const std::function<void(Numbers&)>& damage) {
    const fs::path path = written(box, std::to_string(++number) + ".cgns");
    Numbers data = section.data;
    damage(data);
    RawFile(path).put_data(section.name, data);
    return path;
  };
  const std::string here = "section air, element " + std::to_string(element + 1) + ": ",
                    last = "section air, element " + std::to_string(section.offsets.size() - 1) + ": ";
  const std::array<std::pair<std::function<void(Numbers&)>, std::string>, 6> damages = {
      {{[&](Numbers& d) { d[place] = 1000; }, here + "has an unknown type"},
       {[&](Numbers& d) { d[place] = (std::int64_t{1} << 32) + 10; }, here + "has an unknown type"},
       {[&](Numbers& d) { d[place] = 20; }, here + "has the unknown type 20"},
       {[&](Numbers& d) { d.pop_back(); }, last + "is missing"},
       {[&](Numbers& d) { d.resize(static_cast<std::size_t>(section.offsets.end()[-2])); },
        last + "is missing"},
       {[&](Numbers& d) { d.push_back(10); }, "section air: has more data than its range of elements says"}}};
  for (const auto& [damage, says] : damages) {
    const fs::path path = damaged(damage);
    const std::string message = message_of([&] { read_cgns(path); });
    expect_contains(message, says);
    EXPECT_EQ(message_of([&] { cgns_size(path); }), message);
    EXPECT_EQ(message_of([&] { read_cgns_range(path, {0, 10, 0, 10}); }), message);
  }

  const fs::path path = damaged([&](Numbers& d) { d[place + 3] = 5'000'000'001; });
  const std::string message = message_of([&] { read_cgns(path); });
  expect_contains(message, here + "vertex index 5000000001 is out of range 1..15625");
  EXPECT_EQ(message_of([&] { read_cgns_range(path, {0, 10, 10000, 10000}); }), message);
  EXPECT_NO_THROW(read_cgns_range(path, {0, 10, 60000, 10})) << "which has other tets";
}

TEST_F(CgnsMixed, DataOfOtherShapesAreNamed) {
  const MixedBox box;
  const auto message = [&](const char* section, const Numbers& data, int dimensions) {
    const fs::path path = written(box, "m" + std::to_string(data.size()) + section + ".cgns");
    RawFile(path).put_data(section, data, dimensions);
    return message_of([&] { read_cgns(path); });
  };
  Numbers tets = box.sections[1].data;
  EXPECT_EQ(message("tets_6", tets, 1), "no error");
  tets.pop_back();
  expect_contains(message("tets_6", tets, 1),
                  "section tets_6: its data are not those of its range of elements");
  expect_contains(message("7", box.sections[2].data, 2), "section 7: its data are no list of numbers");
}

}  // namespace
}  // namespace weft::meshing::cgns_mixed_test
