// Whether a CAD model that has been read is one: readers make shapes of damaged files, too.
#pragma once

#include <string>
#include <vector>

#include "meshing/geometry/model/geometry_model.h"

namespace weft::meshing {

/// What is wrong with a model, by entity; ids count from 1.
struct ModelDefects {
  std::vector<std::string> fatal;  ///< a mesh on it would not be one of the body that is meant
  std::vector<std::string> slight;
};

/// Ranges and coordinates are finite, and no face is far larger than all edges; edges end on their nodes and
/// lie on their faces, and tolerances are no larger, than to a hundredth of the model's size (fatal) and,
/// where the tolerances allow less, a hundred thousandth of it (slight); borders of faces are closed.
ModelDefects defects_of(const GeometryModel& model);

}  // namespace weft::meshing
