// Faces of tets as they meet at the rank of their lowest vertex.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>

#include "meshing/mesh/tet_tables.h"

namespace weft::partition {

/// One face of one tet. Ordered by vertices, then by tet and face.
struct FaceRecord {
  std::array<std::uint32_t, 3> vertices;  ///< ascending
  std::int32_t tet_ref;
  std::uint64_t code;  ///< ((tet * 4) + face) * 8 + turn; tet numbered as in the whole input

  std::uint64_t tet() const { return code >> 5; }
  /// Whether the tet sees its face's vertices turn the one way or the other.
  bool odd() const { return code & 1; }
  /// The vertices in the order of kTetFaces.
  std::array<std::uint32_t, 3> in_order() const {
    const std::uint64_t first = code >> 1 & 3, step = odd() ? 2 : 1;
    return {vertices[first], vertices[(first + step) % 3], vertices[(first + 2 * step) % 3]};
  }
};

inline FaceRecord face_record(const std::array<std::uint32_t, 4>& tet, std::int32_t tet_ref,
                              std::uint64_t number, std::size_t face) {
  const auto& f = meshing::kTetFaces[face];
  const std::array<std::uint32_t, 3> v{tet[f[0]], tet[f[1]], tet[f[2]]};
  FaceRecord record{v, tet_ref, 0};
  std::sort(record.vertices.begin(), record.vertices.end());
  const auto place = [&](std::uint32_t vertex) {
    return static_cast<std::uint64_t>(std::find(record.vertices.begin(), record.vertices.end(), vertex) -
                                      record.vertices.begin());
  };
  const std::uint64_t first = place(v[0]), odd = place(v[1]) == (first + 1) % 3 ? 0 : 1;
  record.code = (number * 4 + face) << 3 | first << 1 | odd;
  return record;
}

inline bool same_face(const FaceRecord& a, const FaceRecord& b) { return a.vertices == b.vertices; }

inline bool operator<(const FaceRecord& a, const FaceRecord& b) {
  return a.vertices != b.vertices ? a.vertices < b.vertices : a.code < b.code;
}

}  // namespace weft::partition
