// A caller's mesh, checked and completed: what was left out becomes what readers of files make of it.
#pragma once

#include <cstddef>
#include <optional>

#include "meshing/mesh/check_mesh.h"
#include "weft/weft.h"

namespace weft {

/// References that are missing altogether are 0. Throws InputError for arrays that do not fit each other,
/// indices out of range and coordinates that are not finite. Refers to the caller's mesh where nothing was
/// missing.
class WholeMesh {
 public:
  explicit WholeMesh(const Mesh& mesh,
                     meshing::CollapsedTriangles collapsed = meshing::CollapsedTriangles::refused);
  const Mesh& operator*() const { return completed_ ? *completed_ : mesh_; }

 private:
  const Mesh& mesh_;
  std::optional<Mesh> completed_;
};

/// Throws InputError where `what` has not one entry for each of the mesh's vertices.
void check_length(const Mesh& mesh, std::size_t values, const char* what);

/// The same for each field, which must have finite values.
void check_fields(const Mesh& mesh, const Fields& fields);

}  // namespace weft
