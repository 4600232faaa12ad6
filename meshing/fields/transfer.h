// Carries fields to another mesh, linearly or keeping their integrals, and says what was lost on the way.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

enum class TransferMethod {
  /// Linear interpolation at the vertices: interpolate(). Exact for linear fields, never beyond the old
  /// values.
  linear,
  /// L2 projection through the common parts of both meshes' tets, then the least change that brings every
  /// value
  /// back between the smallest and the largest value that the old field takes in the tets round its vertex
  /// and that
  /// keeps the integral. Guaranteed for every component: the integral over the mesh is the old one to 1e-12
  /// of the
  /// integral of its absolute value; fields that are linear stay so where the new mesh covers the same
  /// domain; the
  /// bounds hold wherever they can. They cannot where the volumes of the meshes differ, because then a
  /// constant cannot
  /// keep both its value and its integral: what is left is added everywhere alike, and `beyond_bounds` is how
  /// much. A field of tensors that are all positive definite (a metric) stays that instead: its eigenvalues
  /// keep the bounds that the old ones had, its integral is the old one to 1e-12 of its trace's, and
  /// different volumes are made up for by a congruence (limit_tensors).
  conservative,
};

/// What became of one component of a field.
struct ComponentAccount {
  std::string name;            ///< of the field, with " 1", " 2", ... where it has several components
  double integral_before = 0;  ///< over the old mesh
  double integral_after = 0;   ///< over the new one
  double absolute = 0;         ///< the integral of the old |field| by lumped masses: the scale of both
  // The new field interpolated back to the old vertices, less the old field: over the old mesh.
  double difference_l2 = 0, norm_l2 = 0;    ///< root of the integral of the square; the old field's own
  double difference_max = 0, norm_max = 0;  ///< largest absolute value; the old field's own
  double beyond_bounds = 0;                 ///< conservative: see there
  bool stays_definite = false;              ///< conservative: of a field of positive definite tensors
};

struct Transfer {
  SolutionData fields;        ///< at the vertices of the new mesh, of the same kinds and names
  std::uint64_t outside = 0;  ///< vertices outside the old mesh; they read its closest point
  double farthest = 0;        ///< largest distance of one of them from it
  std::vector<ComponentAccount> accounts;
};

/// `fields` at the vertices of `from`, at those of `to`. Multithreaded on TBB; does not depend on the number
/// of threads. Both ways keep positive definite tensors definite; others go component by component. Cost:
/// linear 2 us a vertex; conservative 20 to 40 us a tet of the finer mesh, and 300 bytes a vertex of `to`.
/// Throws InputError naming the tet (1-based) of `from` without volume, and for a `to` with such a tet or
/// without any.
Transfer transfer(const MeshData& from, const SolutionData& fields, const MeshData& to,
                  TransferMethod method);

}  // namespace weft::meshing
