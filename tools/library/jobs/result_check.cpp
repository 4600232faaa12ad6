// The sums say only that something is wrong, the full check what.
#include "tools/library/jobs/result_check.h"

#include <string>

#include "meshing/geometry/surface/face_directions.h"
#include "meshing/mesh/check_mesh.h"
#include "meshing/mesh/face_sums.h"

namespace weft::tools {

void check_conforms(const Mesh& mesh) {
  const bool folds = meshing::may_curve(mesh) && meshing::crowded_sides(mesh) > 0;
  if (!folds && meshing::sum_faces(mesh).ok()) return;
  const CheckReport report = meshing::check_mesh(mesh, 5);
  std::string text = "the result does not conform";
  for (const std::string& problem : report.problems) text += "\n  " + problem;
  throw RunError(text);
}

}  // namespace weft::tools
