// Shared by the tests of file formats: folders, small meshes, comparisons, and systematic damage.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/io/files/mesh_contents.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

namespace fs = std::filesystem;

/// A fresh directory that goes with its content.
class TemporaryDirectory {
 public:
  TemporaryDirectory() {
    std::string name = (root() / "weft-format-test-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("mkdtemp failed");
    path_ = name;
    fs::permissions(path_, fs::perms::owner_all | fs::perms::others_read | fs::perms::others_exec);
  }
  ~TemporaryDirectory() { fs::remove_all(path_); }
  fs::path operator/(const std::string& name) const { return path_ / name; }
  std::size_t num_entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }
  const fs::path& path() const { return path_; }

 private:
  /// In memory where there is such a folder: the tests write tens of thousands of small files.
  static fs::path root() {
    const fs::path memory = "/dev/shm";
    return ::access(memory.c_str(), W_OK | X_OK) == 0 ? memory : fs::temp_directory_path();
  }

  fs::path path_;
};

inline std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
inline int count(const std::string& text, const std::string& part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}
inline void put_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Two tets that share a face, with one of everything that a mesh can hold. The numbers are exact in 32 bits.
inline MeshData two_tets() {
  MeshData m;
  m.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1.5}};
  m.point_refs = {1, 2, 3, -4, 5};
  m.tets = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  m.tet_refs = {7, -8};
  m.triangles = {{0, 1, 2}, {1, 2, 4}, {0, 2, 3}};
  m.triangle_refs = {11, 12, -13};
  m.edges = {{0, 1}, {1, 2}};
  m.edge_refs = {21, -22};
  m.corners = {0, 4};
  m.ridges = {1};
  m.required_points = {2};
  m.required_edges = {0, 1};
  m.required_triangles = {2};
  return m;
}

inline void expect_equal(const MeshData& a, const MeshData& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.point_refs, b.point_refs);
  EXPECT_EQ(a.tets, b.tets);
  EXPECT_EQ(a.tet_refs, b.tet_refs);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.triangle_refs, b.triangle_refs);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.edge_refs, b.edge_refs);
  EXPECT_EQ(a.corners, b.corners);
  EXPECT_EQ(a.ridges, b.ridges);
  EXPECT_EQ(a.required_points, b.required_points);
  EXPECT_EQ(a.required_edges, b.required_edges);
  EXPECT_EQ(a.required_triangles, b.required_triangles);
  EXPECT_EQ(a.association, b.association);
}

inline void expect_equal(const SolutionData& a, const SolutionData& b) {
  EXPECT_EQ(a.num_points, b.num_points);
  ASSERT_EQ(a.fields.size(), b.fields.size());
  for (std::size_t i = 0; i < a.fields.size(); ++i) {
    EXPECT_EQ(a.fields[i].kind, b.fields[i].kind);
    EXPECT_EQ(a.fields[i].values, b.fields[i].values);
  }
}

/// Every index that a reader lets through must be usable.
inline void expect_in_range(const MeshData& m) {
  const auto below = [](std::size_t limit) { return [limit](std::uint32_t i) { return i < limit; }; };
  for (const auto& tet : m.tets) EXPECT_TRUE(std::ranges::all_of(tet, below(m.points.size())));
  for (const auto& triangle : m.triangles) EXPECT_TRUE(std::ranges::all_of(triangle, below(m.points.size())));
  for (const auto& edge : m.edges) EXPECT_TRUE(std::ranges::all_of(edge, below(m.points.size())));
  EXPECT_TRUE(std::ranges::all_of(m.corners, below(m.points.size())));
  EXPECT_TRUE(std::ranges::all_of(m.required_points, below(m.points.size())));
  EXPECT_TRUE(std::ranges::all_of(m.ridges, below(m.edges.size())));
  EXPECT_TRUE(std::ranges::all_of(m.required_edges, below(m.edges.size())));
  EXPECT_TRUE(std::ranges::all_of(m.required_triangles, below(m.triangles.size())));
  EXPECT_EQ(m.point_refs.size(), m.points.size());
  EXPECT_EQ(m.tet_refs.size(), m.tets.size());
}

inline std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

inline void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text << "\n  lacks: " << part;
}

/// Calls `read` on every version of `bytes` with one byte changed; it may throw InputError and nothing else.
template <class Read>
void change_every_byte(const fs::path& path, const std::string& bytes, Read read) {
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const int old = static_cast<unsigned char>(bytes[i]);
    for (const int value : {0, 1, 2, 3, 62, 0x7F, 0x80, 0xFF, old ^ 1, old ^ 0x80, old + 1, old - 1}) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(value);
      put_bytes(path, damaged);
      try {
        read(path);
      } catch (const InputError& error) {
        EXPECT_TRUE(std::string(error.what()).starts_with(path.string() + ": ")) << error.what();
      }
    }
  }
}

/// Reads every version of `bytes` with one byte changed; what is not refused must be usable. `Wanted`:
/// Coordinates, where the reader knows them.
template <class... Wanted>
void damage_everywhere(const fs::path& path, const std::string& bytes,
                       MeshContents (*read)(const fs::path&, Wanted...)) {
  change_every_byte(path, bytes, [read](const fs::path& damaged) {
    const MeshContents contents = read(damaged, Wanted{}...);
    expect_in_range(contents.mesh);
    check_lengths(contents.mesh, contents.fields);
  });
}

/// Reads every beginning of `bytes`. All must be refused, except that the last `optional` bytes may be
/// missing.
template <class... Wanted>
void truncate_everywhere(const fs::path& path, const std::string& bytes,
                         MeshContents (*read)(const fs::path&, Wanted...), std::size_t optional = 0) {
  for (std::size_t length = 0; length + optional < bytes.size(); ++length) {
    put_bytes(path, bytes.substr(0, length));
    const std::string message = message_of([&] { read(path, Wanted{}...); });
    EXPECT_TRUE(message.starts_with(path.string() + ": ")) << "length " << length << ": " << message;
  }
}

/// Everything that contents can hold, with numbers that need all 17 digits.
inline MeshContents full_contents() {
  MeshContents c;
  c.mesh = two_tets();
  c.mesh.points[0] = {1.0 / 3, -1e-300, 123456789.123456789};
  c.mesh.points[4] = {0.1, 2.0 / 7, 1e300};
  c.fields.num_points = 5;
  for (const auto kind : {Field::Kind::scalar, Field::Kind::vector, Field::Kind::tensor}) {
    Field field{kind, {}, "field of " + std::to_string(components(kind))};
    for (int i = 0; i < 5 * components(kind); ++i) field.values.push_back(0.1 * i - 1.0 / 3);
    c.fields.fields.push_back(field);
  }
  c.names.set(2, 11, "wing");
  c.names.set(2, 12, "far field");
  c.names.set(3, 7, "air");
  return c;
}

/// What a format keeps that knows no ridges or required entities, and references only of points that are
/// corners.
inline MeshData without_marks(MeshData mesh) {
  for (std::uint32_t i = 0; i < mesh.points.size(); ++i) {
    if (!std::ranges::count(mesh.corners, i)) mesh.point_refs[i] = 0;
  }
  mesh.ridges.clear();
  mesh.required_points.clear();
  mesh.required_edges.clear();
  mesh.required_triangles.clear();
  return mesh;
}

/// Orders elements by their references, as formats do that store them by group.
template <std::size_t N>
void sort_by_ref(std::vector<std::array<std::uint32_t, N>>& elements, std::vector<std::int32_t>& refs) {
  std::vector<std::array<std::uint32_t, N>> sorted;
  for (const auto& [ref, indices] : indices_by_ref(refs)) {
    for (const std::uint32_t i : indices) sorted.push_back(elements[i]);
  }
  elements = sorted;
  std::ranges::sort(refs);
}
inline MeshData sorted_by_ref(MeshData mesh) {
  sort_by_ref(mesh.tets, mesh.tet_refs);
  sort_by_ref(mesh.triangles, mesh.triangle_refs);
  sort_by_ref(mesh.edges, mesh.edge_refs);
  return mesh;
}

inline void expect_equal_fields(const SolutionData& a, const SolutionData& b) {
  expect_equal(a, b);
  for (std::size_t i = 0; i < a.fields.size() && i < b.fields.size(); ++i) {
    EXPECT_EQ(a.fields[i].name, b.fields[i].name);
  }
}

inline double total_volume(const MeshData& mesh) {
  double sum = 0;
  for (const auto& t : mesh.tets) {
    const double v = six_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    EXPECT_GT(v, 0);
    sum += v / 6;
  }
  return sum;
}

inline bool dropped(const MeshContents& contents, const std::string& what, std::uint64_t count) {
  return std::ranges::any_of(contents.dropped,
                             [&](const Dropped& d) { return d.what == what && d.count == count; });
}

/// A file that another program wrote; tests/data/formats/README.md says which.
inline fs::path sample(const std::string& name) { return fs::path(WEFT_TEST_DATA) / "formats" / name; }

}  // namespace weft::meshing
