// Where the rows of a mesh go while its file is read: nobody has to hold them all.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Rows of a mesh's triangles, edges and marks: of any of these arrays some or none, which follow those that
/// came before.
struct BoundaryRows {
  MeshData rows;  ///< no points, no tets
  /// Of formats that have two numbers for an element, as MeshStream::take_other_tet_refs().
  std::vector<std::int32_t> other_triangle_refs, other_edge_refs;
};

/// Calls f(of_rows) for each array, with of_rows(BoundaryRows&) the array.
template <class F>
constexpr void for_each_boundary_array(F f) {
  f([](auto& b) -> auto& { return b.rows.triangles; });
  f([](auto& b) -> auto& { return b.rows.triangle_refs; });
  f([](auto& b) -> auto& { return b.other_triangle_refs; });
  f([](auto& b) -> auto& { return b.rows.edges; });
  f([](auto& b) -> auto& { return b.rows.edge_refs; });
  f([](auto& b) -> auto& { return b.other_edge_refs; });
  f([](auto& b) -> auto& { return b.rows.ridges; });
  f([](auto& b) -> auto& { return b.rows.required_edges; });
  f([](auto& b) -> auto& { return b.rows.required_triangles; });
  f([](auto& b) -> auto& { return b.rows.corners; });
  f([](auto& b) -> auto& { return b.rows.required_points; });
}

inline constexpr std::size_t kBoundaryArrays = [] {
  std::size_t arrays = 0;
  for_each_boundary_array([&](auto) { ++arrays; });
  return arrays;
}();

/// Takes the rows of each array in the order of the file, in blocks; what a stream does not override it does
/// not want. An array of which nothing comes is one of zeros. Vertices are numbered as in the whole mesh;
/// whether they are in range the reader checks.
class MeshStream {
 public:
  /// Rows of a full block.
  static constexpr std::size_t kRows = std::size_t{1} << 16;

  virtual ~MeshStream() = default;
  virtual void take_points(std::vector<Point>) {}
  virtual void take_point_refs(std::vector<std::int32_t>) {}
  virtual void take_tets(std::vector<std::array<std::uint32_t, 4>>) {}
  virtual void take_tet_refs(std::vector<std::int32_t>) {}
  /// Of formats that have two numbers for a tet, of which the end of the file says which is the reference.
  virtual void take_other_tet_refs(std::vector<std::int32_t>) {}
  virtual void take_boundary(BoundaryRows) {}
  /// Of tets (3), triangles (2) or edges (1) the other numbers are the references, not the first.
  virtual void prefer_other_refs(int /*dimension*/) {}
  /// Of a single point, whatever the array says.
  virtual void set_point_ref(std::uint32_t /*point*/, std::int32_t /*ref*/) {}
};

/// One of the arrays on its way: a reader fills `rows`, and calls pass() after each row and at the end.
template <class T>
class StreamedRows {
 public:
  StreamedRows(MeshStream& stream, void (MeshStream::*take)(std::vector<T>)) : stream_(stream), take_(take) {}

  void add(const T& row) {
    rows_.push_back(row);
    ++count_;
    if (rows_.size() == MeshStream::kRows) pass();
  }
  void pass() {
    if (!rows_.empty()) (stream_.*take_)(std::exchange(rows_, {}));
  }
  std::uint64_t count() const { return count_; }  ///< of all rows so far

 private:
  MeshStream& stream_;
  void (MeshStream::*take_)(std::vector<T>);
  std::vector<T> rows_;
  std::uint64_t count_ = 0;
};

/// The boundary on its way: a reader fills `rows`, and calls pass_if_full() after each row and pass() at the
/// end.
class StreamedBoundary {
 public:
  explicit StreamedBoundary(MeshStream& stream) : stream_(stream) {}

  BoundaryRows rows;
  void pass_if_full() {
    const MeshData& mesh = rows.rows;
    for (const std::size_t n :
         {mesh.triangles.size(), mesh.triangle_refs.size(), mesh.edges.size(), mesh.ridges.size(),
          mesh.required_edges.size(), mesh.required_triangles.size(), mesh.corners.size(),
          mesh.required_points.size()})
      if (n >= MeshStream::kRows) return pass();
  }
  void pass() { stream_.take_boundary(std::exchange(rows, {})); }

 private:
  MeshStream& stream_;
};

/// Keeps everything.
class MeshCollector final : public MeshStream {
 public:
  void take_points(std::vector<Point> rows) override { append(mesh_.points, rows); }
  void take_point_refs(std::vector<std::int32_t> rows) override { append(mesh_.point_refs, rows); }
  void take_tets(std::vector<std::array<std::uint32_t, 4>> rows) override { append(mesh_.tets, rows); }
  void take_tet_refs(std::vector<std::int32_t> rows) override { append(mesh_.tet_refs, rows); }
  void take_other_tet_refs(std::vector<std::int32_t> rows) override { append(other_, rows); }
  void take_boundary(BoundaryRows rows) override {
    for_each_boundary_array([&](auto of_rows) { append(of_rows(boundary_), of_rows(rows)); });
  }
  void prefer_other_refs(int dimension) override {
    if (dimension == 3) mesh_.tet_refs = std::move(other_);
    if (dimension == 2) boundary_.rows.triangle_refs = std::move(boundary_.other_triangle_refs);
    if (dimension == 1) boundary_.rows.edge_refs = std::move(boundary_.other_edge_refs);
  }
  void set_point_ref(std::uint32_t point, std::int32_t ref) override {
    mesh_.point_refs.resize(mesh_.points.size());
    mesh_.point_refs[point] = ref;
  }

  /// All of it into a mesh that has at most corners, which it keeps, and an association.
  void put_into(MeshData& mesh) {
    append(boundary_.rows.corners, mesh.corners);
    boundary_.rows.association = std::move(mesh.association);
    mesh = std::move(boundary_.rows);
    mesh_.point_refs.resize(mesh_.points.size());
    mesh_.tet_refs.resize(mesh_.tets.size());
    mesh.points = std::move(mesh_.points);
    mesh.point_refs = std::move(mesh_.point_refs);
    mesh.tets = std::move(mesh_.tets);
    mesh.tet_refs = std::move(mesh_.tet_refs);
  }

 private:
  template <class T>
  static void append(std::vector<T>& all, const std::vector<T>& rows) {
    all.insert(all.end(), rows.begin(), rows.end());
  }

  MeshData mesh_;
  BoundaryRows boundary_;
  std::vector<std::int32_t> other_;
};

}  // namespace weft::meshing
