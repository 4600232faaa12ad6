// Names of the coordinates that follow the boundary, as parts of a partitioner's name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace weft::partition {

/// A coordinate along which slabs are cut that follows the boundary.
struct BoundaryCoordinate {
  enum class Kind {
    none,      ///< slabs are planar
    harmonic,  ///< 0 on the triangles of refs[0], 1 on those of refs[1], Laplace's equation between
    wall       ///< distance from the triangles of these references
  };
  Kind kind = Kind::none;
  std::vector<std::int32_t> refs;  ///< of triangles

  bool asked() const { return kind != Kind::none; }
};

/// Whether a text means to name a coordinate: `harmonic=...` or `wall=...`.
bool names_coordinate(std::string_view text);

/// Reads `harmonic=A,B` and `wall=A` or `wall=A,B,...`. Throws std::invalid_argument that says what is wrong.
BoundaryCoordinate parse_coordinate(std::string_view text);

/// What parse_coordinate() reads; empty of none.
std::string text_of(const BoundaryCoordinate& coordinate);

}  // namespace weft::partition
