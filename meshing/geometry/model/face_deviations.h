// How far boundary triangles are from the CAD model that their vertices lie on.
#pragma once

#include <vector>

#include "meshing/geometry/model/model.h"
#include "meshing/mesh/mesh_data.h"

namespace weft::meshing {

/// Of a mesh whose vertices have records of where they lie (MeshData::association). Mesh and model must
/// outlive it.
class FaceDeviations {
 public:
  FaceDeviations(const MeshData& mesh, const Model& model);

  /// The distance of the triangle's centroid from the face that all its vertices have records of (the
  /// nearest, where there are several); NaN where there is none.
  double at(const Triangle& triangle) const;

 private:
  using OnFace = Association::OnFace;
  std::vector<OnFace>::const_iterator first_of(std::uint32_t vertex) const;
  bool lies_on(std::uint32_t vertex, std::int32_t face) const;

  const MeshData& mesh_;
  const Model& model_;
  std::vector<OnFace> records_;  ///< by vertex
};

}  // namespace weft::meshing
