// Where the points and tets of a mesh go while its file is read: nobody has to hold them all.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "meshing/base/point.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Takes the rows of each array in the order of the file, in blocks. An array of which nothing comes is one
/// of zeros. Vertices are numbered as in the whole mesh; whether they are in range the reader checks.
class MeshStream {
 public:
  /// Rows of a full block.
  static constexpr std::size_t kRows = std::size_t{1} << 16;

  virtual ~MeshStream() = default;
  virtual void take_points(std::vector<Point> rows) = 0;
  virtual void take_point_refs(std::vector<std::int32_t> rows) = 0;
  virtual void take_tets(std::vector<std::array<std::uint32_t, 4>> rows) = 0;
  virtual void take_tet_refs(std::vector<std::int32_t> rows) = 0;
  /// Of formats that have two numbers for a tet, of which the end of the file says which is the reference.
  virtual void take_other_tet_refs(std::vector<std::int32_t> rows) = 0;
  /// These are the references, not the first.
  virtual void prefer_other_tet_refs() = 0;
  /// Of a single point, whatever the array says.
  virtual void set_point_ref(std::uint32_t point, std::int32_t ref) = 0;
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

/// Keeps everything.
class MeshCollector final : public MeshStream {
 public:
  void take_points(std::vector<Point> rows) override { append(mesh_.points, rows); }
  void take_point_refs(std::vector<std::int32_t> rows) override { append(mesh_.point_refs, rows); }
  void take_tets(std::vector<std::array<std::uint32_t, 4>> rows) override { append(mesh_.tets, rows); }
  void take_tet_refs(std::vector<std::int32_t> rows) override { append(mesh_.tet_refs, rows); }
  void take_other_tet_refs(std::vector<std::int32_t> rows) override { append(other_, rows); }
  void prefer_other_tet_refs() override { mesh_.tet_refs = std::move(other_); }
  void set_point_ref(std::uint32_t point, std::int32_t ref) override {
    mesh_.point_refs.resize(mesh_.points.size());
    mesh_.point_refs[point] = ref;
  }

  /// Points and tets with their references, into a mesh that has none.
  void put_into(MeshData& mesh) {
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
  std::vector<std::int32_t> other_;
};

}  // namespace weft::meshing
