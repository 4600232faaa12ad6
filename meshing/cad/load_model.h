// CAD models from files, through OpenCASCADE where this build has it.
#pragma once

#include <memory>
#include <string>

#include "meshing/cad/cad_reader.h"

namespace weft::meshing {

/// Whether the extension is one of a CAD model; those that are, for messages.
bool is_model_name(const std::string& path);
std::string model_extensions();

/// Reads a model. Throws InputError naming the file; where weft has been built without OpenCASCADE it says
/// what to install.
std::shared_ptr<const GeometryModel> load_model(const std::string& path);
/// Reads the model that a mesh file carries: .egads as refine writes it.
std::shared_ptr<const GeometryModel> load_carried_model(const Association& association,
                                                        const std::string& mesh_name);
MeshData tessellate_model(const std::string& path, const GeometryModel& model,
                          const CadTessellation& options);

}  // namespace weft::meshing
