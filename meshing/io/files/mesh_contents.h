// What a mesh file of any format holds: the mesh, fields, names of references, and an account of the rest.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "meshing/io/files/coordinates.h"
#include "meshing/mesh/mesh_data.h"
#include "weft/data.h"

namespace weft::meshing {

/// Gives references to names, for formats that know names only. "ref_N" and "N" mean N where N is free; any
/// other name gets the smallest number not taken.
class RefNumbering {
 public:
  RefNumbering(int dimension, RefNames& names) : dimension_(dimension), names_(names) {}
  std::int32_t ref(std::string_view name);

 private:
  int dimension_;
  RefNames& names_;
  std::map<std::string, std::int32_t, std::less<>> refs_;
  std::set<std::int32_t> taken_;
  std::int32_t next_ = 1;
};

struct MeshContents {
  MeshData mesh;
  SolutionData fields;  ///< at the vertices; often none
  RefNames names;
  std::vector<Dropped> dropped;       ///< what of the file has no place here
  std::uint64_t foreign_volumes = 0;  ///< volume elements among the dropped: the mesh has holes then

  /// Counts `count` more of `what`; none is not noted.
  void drop(const std::string& what, std::uint64_t count = 1);
  void drop_volumes(const std::string& what, std::uint64_t count) {
    drop(what, count);
    foreign_volumes += count;
  }
  /// All references that are still missing, as 0; the number of points into the fields.
  void complete();
};

/// How many points and tets the mesh of a file has; of the rest where a format says it nowhere in one place,
/// and readers of ranges have counted it.
struct MeshSize {
  std::uint64_t points = 0, tets = 0;
  std::uint64_t triangles = 0, edges = 0, corners = 0;
};

/// What one of several readers keeps: contiguous ranges of a file's points and tets, counted from 0, and one
/// of equal parts of its triangles, of its edges, and of each list of marks, in their order.
struct MeshRange {
  std::uint64_t first_point = 0, num_points = 0;
  std::uint64_t first_tet = 0, num_tets = 0;
  std::uint64_t part = 0, parts = 1;
  std::optional<MeshSize> whole = {};  ///< what the file has; else readers that need it count once more

  /// Of `total` rows that are dealt in parts, those of this one.
  std::uint64_t part_begin(std::uint64_t total) const { return total * part / parts; }
  std::uint64_t part_end(std::uint64_t total) const { return total * (part + 1) / parts; }
};

/// Which rows of one kind are kept while all of them are passed over.
class KeptRows {
 public:
  /// All of them.
  KeptRows() = default;
  KeptRows(const MeshRange& range, std::uint64_t total)
      : first_(range.part_begin(total)), end_(range.part_end(total)) {}
  KeptRows(std::uint64_t first, std::uint64_t count)
      : first_(first), end_(count > kAll - first ? kAll : first + count) {}

  /// The same rows, none of them passed.
  KeptRows again() const {
    KeptRows same = *this;
    same.passed_ = 0;
    return same;
  }
  /// Passes the next row; whether it is kept.
  bool take() {
    const std::uint64_t row = passed_++;
    return row >= first_ && row < end_;
  }
  struct Rows {
    std::uint64_t first = 0, count = 0;  ///< from the next one on
  };
  /// Of the next `count`, which are not passed.
  Rows among(std::uint64_t count) const {
    const std::uint64_t begin = std::max(first_, passed_), end = std::min(end_, passed_ + count);
    return begin < end ? Rows{begin - passed_, end - begin} : Rows{};
  }
  void pass(std::uint64_t count) { passed_ += count; }

 private:
  static constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t first_ = 0, end_ = kAll, passed_ = 0;
};

/// Leaves of corners those of the range's part: for formats that are read with all of them.
void keep_part_of_corners(const MeshRange& range, MeshData& mesh);

/// The same for writers, who need not own it.
struct MeshView {
  MeshView(const MeshData& m, const SolutionData& f, const RefNames& n) : mesh(m), fields(f), names(n) {}
  MeshView(const MeshContents& contents) : MeshView(contents.mesh, contents.fields, contents.names) {}

  const MeshData& mesh;
  const SolutionData& fields;
  const RefNames& names;
};

/// The triangles and edges with the points they use, for formats of surfaces. A mesh without tets stays as it
/// is.
MeshContents surface_of(const MeshView& contents);

/// Where a symmetric tensor of a field (m11 m12 m22 m13 m23 m33) lies in a full one, row by row.
inline constexpr int kFullTensorPlaces[9] = {0, 1, 3, 1, 2, 4, 3, 4, 5};
/// Makes a symmetric tensor field of full tensors; false where they are not symmetric.
bool fold_full_tensors(const std::vector<double>& full, std::vector<double>& folded);
/// As which these are dropped then.
inline constexpr const char* kSkewTensors = "fields of tensors that are not symmetric";

/// The name of field `i`, or "field_N" for one without.
std::string field_name(const SolutionData& fields, std::size_t i);

/// Names of siblings in a file, which must differ: the second `a` becomes `a_2`.
class UniqueNames {
 public:
  /// Names are cut to `longest` bytes, where a character of UTF-8 ends.
  explicit UniqueNames(std::size_t longest = std::string::npos) : longest_(longest) {}
  std::string unique(const std::string& name);
  /// What several siblings begin with, each with one of `ends`.
  std::string unique_begin(const std::string& name, std::span<const char* const> ends);

 private:
  std::size_t longest_;
  std::set<std::string> taken_;
};

/// Whether any is not 0.
bool has_refs(const std::vector<std::int32_t>& refs);

/// Which entities have a reference, by reference and in their order.
std::map<std::int32_t, std::vector<std::uint32_t>> indices_by_ref(const std::vector<std::int32_t>& refs);

/// Throws std::logic_error where arrays that belong together differ in length.
void check_lengths(const MeshData& mesh, const SolutionData& fields);

}  // namespace weft::meshing
