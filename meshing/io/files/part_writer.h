// One mesh file that many write together: each its part of the rows, one of them what is no row.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "meshing/io/files/mesh_contents.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// A number for every reference: how many entities have it, or how many of these stand in front.
using RefCounts = std::map<std::int32_t, std::uint64_t>;

std::uint64_t sum_of(const RefCounts& counts);
RefCounts count_refs(std::span<const std::int32_t> refs);

/// What all writers know of the whole mesh before any row is written. It fixes the place of every row.
struct WholeMesh {
  struct Corner {
    std::uint64_t point;
    Point place;
    std::int32_t ref;  ///< of the point
  };

  std::uint64_t points = 0;
  RefCounts tets, triangles, edges;
  std::vector<Corner> corners;  ///< all of them: they are few
  bool point_refs = false;      ///< any is not 0
  Point low, high;              ///< the box of the points
  RefNames names;
  SolutionData fields;   ///< their kinds and names, no values
  WriteOptions options;  ///< of the file

  std::uint64_t num_tets() const { return sum_of(tets); }
  std::uint64_t num_triangles() const { return sum_of(triangles); }
  std::uint64_t num_edges() const { return sum_of(edges); }
};

/// What is known of a mesh that lies whole in memory.
WholeMesh describe(const MeshView& contents);

/// Elements of one kind; vertices by their 0-based numbers in the whole mesh.
template <std::size_t N, class Index = std::uint64_t>
struct ElementRows {
  std::span<const std::array<Index, N>> elements;
  std::span<const std::int32_t> refs;
  std::uint64_t first = 0;   ///< number of the first in the whole mesh
  RefCounts first_with_ref;  ///< of each reference: its number among those with the same reference
};

/// Rows that follow one another in the whole mesh.
template <class Index>
struct MeshRows {
  std::uint64_t first_point = 0;
  std::span<const Point> points;
  std::span<const std::int32_t> point_refs;
  ElementRows<4, Index> tets;
  ElementRows<3, Index> triangles;
  ElementRows<2, Index> edges;
  const SolutionData& fields;  ///< at these points
};

/// One part.
using MeshPart = MeshRows<std::uint64_t>;
/// All rows of a mesh that lies whole in memory.
MeshRows<std::uint32_t> all_rows(const MeshView& contents);

/// Which elements have a reference, in their order, and the place of the first of them among all that have
/// it.
struct RefRows {
  std::uint64_t first;
  std::vector<std::uint32_t> indices;
};
template <std::size_t N, class Index>
std::map<std::int32_t, RefRows> rows_by_ref(const ElementRows<N, Index>& rows) {
  std::map<std::int32_t, RefRows> result;
  for (std::uint32_t i = 0; i < rows.refs.size(); ++i) result[rows.refs[i]].indices.push_back(i);
  for (auto& [ref, of_ref] : result) of_ref.first = rows.first_with_ref.at(ref);
  return result;
}

/// One writer. Throws InputError when writing fails.
class PartWriter {
 public:
  virtual ~PartWriter() = default;
  virtual void write(const MeshPart& part) = 0;
  /// Everything to the disk. Nothing may be written afterwards.
  virtual void finish() = 0;
};

/// One part's rows of text, in the sections of a file.
class TextPart {
 public:
  virtual ~TextPart() = default;
  virtual std::string rows(std::size_t section) const = 0;
};

/// Places in a file that only who has laid it out knows; most formats need none.
using PartPlaces = std::vector<std::uint64_t>;

}  // namespace weft::meshing
