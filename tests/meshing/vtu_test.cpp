// VTU files: what is written is parsed back, XML and appended arrays.
#include "meshing/io/vtu.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "meshing/error.h"

namespace weft::meshing {
namespace {

namespace fs = std::filesystem;

/// One DataArray: its attributes and its bytes.
struct Array {
  std::string type, components, bytes;
  template <class T>
  std::vector<T> as() const {
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
  }
};

/// The value of attribute `name` in the XML element that begins at `element`.
std::string attribute(const std::string& xml, std::size_t element, const std::string& name) {
  const std::size_t begin = xml.find(" " + name + "=\"", element) + name.size() + 3;
  return xml.substr(begin, xml.find('"', begin) - begin);
}

/// The arrays of a .vtu by name, in a minimal reading of the format; `xml` gets the text before the data.
std::map<std::string, Array> parse(const std::string& file, std::string& xml) {
  const std::string marker = "<AppendedData encoding=\"raw\">\n_";
  const std::size_t data = file.find(marker) + marker.size();
  xml = file.substr(0, data - marker.size());
  std::map<std::string, Array> arrays;
  std::uint64_t expected_offset = 0;
  for (std::size_t at = xml.find("<DataArray"); at != std::string::npos;
       at = xml.find("<DataArray", at + 1)) {
    EXPECT_EQ(attribute(xml, at, "format"), "appended");
    const std::uint64_t offset = std::stoull(attribute(xml, at, "offset"));
    EXPECT_EQ(offset, expected_offset);
    std::uint64_t size;
    std::memcpy(&size, file.data() + data + offset, sizeof size);
    arrays[attribute(xml, at, "Name")] = {attribute(xml, at, "type"),
                                          attribute(xml, at, "NumberOfComponents"),
                                          file.substr(data + offset + sizeof size, size)};
    expected_offset = offset + sizeof size + size;
  }
  EXPECT_EQ(file.substr(data + expected_offset), "\n</AppendedData>\n</VTKFile>\n");
  return arrays;
}

MeshData two_tets() {
  MeshData m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  m.point_refs = {0, 0, 0, 0, 0};
  m.tets = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  m.tet_refs = {7, -8};
  return m;
}

class Vtu : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "weft-vtu-test-XXXXXX").string();
    ASSERT_TRUE(::mkdtemp(name.data()));
    directory = name;
  }
  void TearDown() override { fs::remove_all(directory); }

  std::map<std::string, Array> write_and_parse(const MeshData& mesh, const SolutionData* fields) {
    write_vtu(directory / "m.vtu", mesh, fields);
    std::ifstream in(directory / "m.vtu", std::ios::binary);
    return parse({std::istreambuf_iterator<char>(in), {}}, xml);
  }

  fs::path directory;
  std::string xml;
};

TEST_F(Vtu, HoldsPointsCellsAndReferences) {
  auto arrays = write_and_parse(two_tets(), nullptr);
  EXPECT_NE(xml.find("NumberOfPoints=\"5\" NumberOfCells=\"2\""), std::string::npos);
  EXPECT_NE(xml.find("header_type=\"UInt64\""), std::string::npos);
  EXPECT_EQ(arrays.size(), 5u);
  EXPECT_EQ(arrays["Points"].components, "3");
  EXPECT_EQ(arrays["Points"].as<double>(),
            (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(arrays["connectivity"].as<std::int64_t>(), (std::vector<std::int64_t>{0, 1, 2, 3, 1, 2, 3, 4}));
  EXPECT_EQ(arrays["offsets"].as<std::int64_t>(), (std::vector<std::int64_t>{4, 8}));
  EXPECT_EQ(arrays["connectivity"].type, "Int64");
  EXPECT_EQ(arrays["types"].as<std::uint8_t>(), (std::vector<std::uint8_t>{10, 10}));
  EXPECT_EQ(arrays["ref"].as<std::int32_t>(), (std::vector<std::int32_t>{7, -8}));
}

TEST_F(Vtu, HoldsFieldsUnderTheirNames) {
  SolutionData fields{5, {}};
  fields.fields.push_back({Field::Kind::scalar, {1, 2, 3, 4, 5}, "a<b & \"c\""});
  fields.fields.push_back({Field::Kind::vector, std::vector<double>(15, 2.5), ""});
  auto arrays = write_and_parse(two_tets(), &fields);
  EXPECT_EQ(arrays["a&lt;b &amp; &quot;c&quot;"].as<double>(), fields.fields[0].values);
  EXPECT_EQ(arrays["field_2"].components, "3");
  EXPECT_EQ(arrays["field_2"].as<double>(), fields.fields[1].values);
}

TEST_F(Vtu, PutsTensorsInVtkOrder) {
  MeshData mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}};
  mesh.point_refs = {0, 0};
  // xx xy yy xz yz zz, each value telling its place in the matrix.
  const SolutionData fields{2, {{Field::Kind::tensor, {11, 12, 22, 13, 23, 33, 1, 2, 3, 4, 5, 6}, "metric"}}};
  auto arrays = write_and_parse(mesh, &fields);
  EXPECT_EQ(arrays["metric"].components, "6");
  EXPECT_EQ(arrays["metric"].as<double>(), (std::vector<double>{11, 22, 33, 12, 23, 13, 1, 3, 6, 2, 5, 4}));
}

TEST_F(Vtu, EmptyMeshIsStillAFile) { EXPECT_EQ(write_and_parse(MeshData{}, nullptr).size(), 5u); }

TEST_F(Vtu, UnwritableTargetIsReported) {
  EXPECT_THROW(write_vtu(directory / "none" / "m.vtu", two_tets()), InputError);
  EXPECT_TRUE(fs::is_empty(directory));
}

}  // namespace
}  // namespace weft::meshing
