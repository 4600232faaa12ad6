// VTU files: what is written is parsed back by other means and by the reader; what other programs write;
// damage.
#include "meshing/io/vtk/vtu.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "tests/meshing/io/format_support.h"

namespace weft::meshing::vtu_test {
namespace {

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

MeshContents tets_only() {
  MeshContents c;
  c.mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  c.mesh.tets = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  c.mesh.tet_refs = {7, -8};
  c.complete();
  return c;
}

const std::vector<WriteOptions> kVariants = {
    {}, {.compress = true}, {.encoding = WriteOptions::Encoding::ascii}};

class Vtu : public testing::Test {
 protected:
  std::map<std::string, Array> write_and_parse(const MeshContents& contents) {
    write_vtu(directory / "m.vtu", contents);
    std::ifstream in(directory / "m.vtu", std::ios::binary);
    return parse({std::istreambuf_iterator<char>(in), {}}, xml);
  }

  MeshContents read_text(const std::string& text) const {
    put_bytes(directory / "m.vtu", text);
    return read_vtu(directory / "m.vtu");
  }
  std::string issue(const std::string& text) const {
    return message_of([&] { read_text(text); });
  }

  TemporaryDirectory directory;
  std::string xml;
};

TEST_F(Vtu, HoldsPointsCellsAndReferences) {
  auto arrays = write_and_parse(tets_only());
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
  MeshContents c = tets_only();
  SolutionData& fields = c.fields;
  fields.fields.push_back({Field::Kind::scalar, {1, 2, 3, 4, 5}, "a<b & \"c\""});
  fields.fields.push_back({Field::Kind::vector, std::vector<double>(15, 2.5), ""});
  auto arrays = write_and_parse(c);
  EXPECT_EQ(arrays["a&lt;b &amp; &quot;c&quot;"].as<double>(), fields.fields[0].values);
  EXPECT_EQ(arrays["field_2"].components, "3");
  EXPECT_EQ(arrays["field_2"].as<double>(), fields.fields[1].values);
}

TEST_F(Vtu, NamesOfArraysDiffer) {
  MeshContents c = tets_only();
  c.mesh.point_refs[0] = 4;
  for (const char* name : {"h", "h", "ref", "h_2", ""})
    c.fields.fields.push_back({Field::Kind::scalar, std::vector<double>(5, 0.5), name});
  write_vtu(directory / "m.vtu", c);
  const MeshContents read = read_vtu(directory / "m.vtu");
  std::vector<std::string> names;
  for (const Field& field : read.fields.fields) names.push_back(field.name);
  EXPECT_EQ(names, (std::vector<std::string>{"h", "h_2", "ref_2", "h_2_2", "field_5"}));
  EXPECT_EQ(read.mesh.point_refs[0], 4);
}

TEST_F(Vtu, NamesOfArraysAreTextThatXmlMayHold) {
  MeshContents c = tets_only();
  for (const char* name : {"Fl\u00e4che",
                           "Fl\xe4"
                           "che",
                           "a\x01", "cut \xd0"})
    c.fields.fields.push_back({Field::Kind::scalar, std::vector<double>(5, 0.5), name});
  auto arrays = write_and_parse(c);
  for (const char* name : {"Fl\u00e4che", "Fl?che", "a?", "cut ?"})
    EXPECT_TRUE(arrays.contains(name)) << name;
}

TEST_F(Vtu, PutsTensorsInVtkOrder) {
  MeshContents c;
  c.mesh.points = {{0, 0, 0}, {1, 0, 0}};
  c.complete();
  // xx xy yy xz yz zz, each value telling its place in the matrix.
  c.fields.fields = {{Field::Kind::tensor, {11, 12, 22, 13, 23, 33, 1, 2, 3, 4, 5, 6}, "metric"}};
  auto arrays = write_and_parse(c);
  EXPECT_EQ(arrays["metric"].components, "6");
  EXPECT_EQ(arrays["metric"].as<double>(), (std::vector<double>{11, 22, 33, 12, 23, 13, 1, 3, 6, 2, 5, 4}));
}

TEST_F(Vtu, EmptyMeshIsStillAFile) { EXPECT_EQ(write_and_parse(MeshContents{}).size(), 5u); }

TEST_F(Vtu, UnwritableTargetIsReported) {
  EXPECT_THROW(write_vtu(directory / "none/m.vtu", tets_only()), InputError);
  EXPECT_EQ(directory.num_entries(), 0u);
}

TEST_F(Vtu, RoundTripIsExactInEveryVariant) {
  MeshContents c = full_contents();
  MeshData expected = c.mesh;
  expected.ridges.clear();
  expected.required_points.clear();
  expected.required_edges.clear();
  expected.required_triangles.clear();
  for (const WriteOptions& options : kVariants) {
    write_vtu(directory / "m.vtu", c, options);
    const MeshContents read = read_vtu(directory / "m.vtu");
    expect_equal(read.mesh, expected);
    expect_equal_fields(read.fields, c.fields);
    EXPECT_TRUE(read.dropped.empty());
  }
}

TEST_F(Vtu, CompressionTakesSeveralBlocks) {
  MeshContents c;
  for (int i = 0; i < 100000; ++i) c.mesh.points.push_back({1.0 * i, 1.0 / (i + 1), -1.0 * i});
  c.complete();
  write_vtu(directory / "m.vtu", c, {.compress = true});
  EXPECT_EQ(read_vtu(directory / "m.vtu").mesh.points, c.mesh.points);
}

/// A file by hand, with these cells.
std::string by_hand(const std::string& connectivity, const std::string& offsets, const std::string& types,
                    const std::string& points = "0 0 0 1 0 0 0 1 0 0 0 1", int num_cells = 1) {
  const auto array = [](const std::string& attributes, const std::string& values) {
    return "<DataArray " + attributes + " format=\"ascii\">" + values + "</DataArray>";
  };
  return "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"" +
         std::to_string(num_cells) + "\"><Points>" +
         array("type=\"Float32\" NumberOfComponents=\"3\"", points) + "</Points><Cells>" +
         array("type=\"Int32\" Name=\"connectivity\"", connectivity) +
         array("type=\"Int32\" Name=\"offsets\"", offsets) + array("type=\"UInt8\" Name=\"types\"", types) +
         "</Cells></Piece></UnstructuredGrid></VTKFile>";
}

TEST_F(Vtu, OtherCellsAreCounted) {
  const MeshContents c =
      read_text(by_hand("0 1 2 3 0 1 2 3 0 1 2", "4 8 11", "9 12 99", "0 0 0 1 0 0 0 1 0 0 0 1", 3));
  EXPECT_TRUE(dropped(c, "quadrilaterals", 1));
  EXPECT_TRUE(dropped(c, "hexahedra", 1));
  EXPECT_TRUE(dropped(c, "cells of VTK type 99", 1));
  EXPECT_EQ(c.foreign_volumes, 2u);
}

TEST_F(Vtu, ReferencesMayBeRealsThatAreWholeNumbers) {
  const auto with_refs = [](const std::string& type, const std::string& values) {
    std::string text = by_hand("0 1 2 3 0 1 2", "4 7", "10 5", "0 0 0 1 0 0 0 1 0 0 0 1", 2);
    return text.insert(text.find("</Piece>"), "<CellData><DataArray type=\"" + type +
                                                  "\" Name=\"ref\" format=\"ascii\">" + values +
                                                  "</DataArray></CellData>");
  };
  for (const char* type : {"Int32", "Float64"}) {
    const MeshContents c = read_text(with_refs(type, "3 -4"));
    EXPECT_EQ(c.mesh.tet_refs, (std::vector<std::int32_t>{3}));
    EXPECT_EQ(c.mesh.triangle_refs, (std::vector<std::int32_t>{-4}));
    EXPECT_TRUE(c.dropped.empty());
  }
  for (const char* values : {"3 0.5", "nan 1", "3 1e300"}) {
    const MeshContents c = read_text(with_refs("Float64", values));
    EXPECT_EQ(c.mesh.tet_refs, (std::vector<std::int32_t>{0}));
    EXPECT_TRUE(dropped(c, "values of cell data ref", 2));
    EXPECT_EQ(read_vtu_range(directory / "m.vtu", {0, 4, 0, 1}).mesh.tet_refs, c.mesh.tet_refs);
  }
  read_text(with_refs("Float32", "3 -4"));
  EXPECT_EQ(read_vtu_range(directory / "m.vtu", {0, 4, 0, 1}).mesh.tet_refs, (std::vector<std::int32_t>{3}));
}

TEST_F(Vtu, ErrorsNameTheEntity) {
  EXPECT_EQ(issue(by_hand("0 1 2 3", "4", "10")), "no error");
  expect_contains(issue(by_hand("0 1 2 4", "4", "10")), "m.vtu: cell 0: point index 4 is out of range 0..3");
  expect_contains(issue(by_hand("0 1 2 -1", "4", "10")), "cell 0: point index -1 is out of range");
  expect_contains(issue(by_hand("0 1 2 3", "3", "10")), "cell 0: has 3 points instead of 4");
  expect_contains(issue(by_hand("0 1 2 3", "5", "10")), "cell 0: its offset 5 is out of range");
  expect_contains(issue(by_hand("0 1 2 3", "-1", "10")), "cell 0: its offset -1 is out of range");
  expect_contains(issue(by_hand("0 1 2 3 0", "4", "10")), "connectivity has more values");
  expect_contains(issue(by_hand("0 1 2 x", "4", "10")), "array connectivity, value 4: expected an integer");
  expect_contains(issue(by_hand("0 1 2 3", "4 5", "10")), "array offsets: has 2 values instead of 1");
  expect_contains(issue(by_hand("0 1 2 3", "4", "10", "0 0 0 1 0 nan 0 1 0 0 0 1")),
                  "point 1: a coordinate is not finite");
  expect_contains(issue(by_hand("", "", "", "0 0 0", 999999999)),
                  "a DataArray, value: the file is truncated, or its count of 12");
  expect_contains(issue("<VTKFile type=\"PolyData\"/>"), "not a VTKFile of type UnstructuredGrid");
  expect_contains(issue("<VTKFile type"), "not XML, or truncated");
  expect_contains(issue(""), "not XML, or truncated");
}

TEST_F(Vtu, DamageIsRefusedOrHarmless) {
  MeshContents c = tets_only();
  c.fields.fields.push_back({Field::Kind::scalar, {1, 2, 3, 4, 5}, "h"});
  for (const WriteOptions& options : kVariants) {
    write_vtu(directory / "m.vtu", c, options);
    const std::string bytes = bytes_of(directory / "m.vtu");
    damage_everywhere(directory / "m.vtu", bytes, read_vtu);
    const bool ascii = options.encoding == WriteOptions::Encoding::ascii;
    // Behind appended data only the closing tags may be missing.
    truncate_everywhere(directory / "m.vtu", bytes, read_vtu,
                        ascii ? 1 : std::string("\n</AppendedData>\n</VTKFile>\n").size());
  }
}

TEST_F(Vtu, DamagedBase64IsRefusedOrHarmless) {
  for (const char* name : {"vtk-box-base64-zlib.vtu", "vtk-box-inline.vtu"}) {
    const std::string bytes = bytes_of(sample(name));
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ 5);
      issue(damaged);
    }
  }
}

TEST_F(Vtu, FilesOfVtkAndMeshio) {
  for (const char* name :
       {"vtk-box-ascii.vtu", "vtk-box-inline.vtu", "vtk-box-inline-zlib.vtu", "vtk-box-base64.vtu",
        "vtk-box-base64-zlib.vtu", "vtk-box-raw-big-endian.vtu", "vtk-box-raw-zlib.vtu", "meshio-box.vtu"}) {
    SCOPED_TRACE(name);
    const MeshContents c = read_vtu(sample(name));
    ASSERT_EQ(c.mesh.points.size(), 14u);
    EXPECT_NEAR(total_volume(c.mesh), 1, 1e-14);
    EXPECT_EQ(c.mesh.tet_refs, std::vector<std::int32_t>(24, 30));
    EXPECT_EQ(std::ranges::count(c.mesh.triangle_refs, 10), 4);
    ASSERT_EQ(c.fields.fields.size(), 2u);
    EXPECT_EQ(c.fields.fields[0].name, "x");
    EXPECT_EQ(c.fields.fields[1].kind, Field::Kind::vector);
    for (std::size_t i = 0; i < 14; ++i) EXPECT_EQ(c.fields.fields[1].values[3 * i + 2], c.mesh.points[i].z);
  }
  expect_contains(message_of([] { read_vtu(sample("vtk-box-lz4.vtu")); }),
                  "vtkLZ4DataCompressor is not read");
}

}  // namespace
}  // namespace weft::meshing::vtu_test
