// Names of the ways to decompose a mesh, as on the command line.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "partition/decompose/coordinate_name.h"

namespace weft::partition {

/// How tets are divided among subdomains.
struct Partitioner {
  enum class Kind {
    pqr,        ///< sorted by a coordinate into P slabs, each into Q, each into R
    bisection,  ///< cut in two across the axis that is longest in wanted sizes, again and again
    graph       ///< METIS on the tets' dual graph
  };
  Kind kind = Kind::graph;
  std::array<std::uint32_t, 3> slabs{0, 0, 0};  ///< of pqr: P, Q, R; zero: to be chosen by the shape
  bool principal_axes = false;                  ///< of pqr: along the work's principal axes, not x, y, z
  bool fewer = false;  ///< of pqr: fewer where they would be mostly interface (thin_slabs.h)
  /// Of pqr: what P slabs are cut along, in place of the first axis. Q and R stay along the other two.
  BoundaryCoordinate coordinate = {};
  /// Of graph: what is nearly as wanted already is cut by runs (runs.h), which costs next to nothing.
  bool runs_suffice = false;
};

/// Reads `bisection`, `graph`, or `pqr` followed by any of `:PxQxR`, a coordinate (coordinate_name.h) such as
/// `:harmonic=3,5` or `:wall=3`, `:principal` and `:fewer`, in this order. `num_subdomains` (0: not given)
/// must be P Q R where both are given. Throws std::invalid_argument that names what is wrong and what is
/// allowed.
Partitioner parse_partitioner(const std::string& text, std::uint32_t num_subdomains = 0);

}  // namespace weft::partition
