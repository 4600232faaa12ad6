// Triangles on OpenCASCADE's shapes.
#pragma once

#include "meshing/cad/cad_reader.h"
#include "meshing/cad/occ_model.h"

namespace weft::meshing {

/// See CadReader::tessellate.
MeshData tessellate_occ(const OccModel& model, const CadTessellation& options);

}  // namespace weft::meshing
