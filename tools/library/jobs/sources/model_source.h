// The CAD model that options name.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "meshing/geometry/model/model.h"
#include "meshing/mesh/mesh_data.h"
#include "weft/weft.h"

namespace weft::tools {

/// Null where none is named. `mesh`, called `mesh_name` in errors, may carry the model. Throws InputError.
std::shared_ptr<const meshing::Model> model_of(const GeometryOptions& options, const meshing::MeshData& mesh,
                                               const std::string& mesh_name);
/// A result's records are of the model of the options: where the input carried one it carries that, if it is
/// an .egads file, as refine writes them; else none. Returns a warning then, or none.
std::string carry_model(const GeometryOptions& options, meshing::Association& carried);
/// What the reader has to say, with the name of the model.
std::vector<std::string> model_warnings(const meshing::Model* model);

}  // namespace weft::tools
