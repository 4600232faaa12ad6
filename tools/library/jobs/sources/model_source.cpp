// Reads the model, scaled as asked.
#include "tools/library/jobs/sources/model_source.h"

#include "meshing/cad/load_model.h"

namespace weft::tools {

std::shared_ptr<const meshing::Model> model_of(const GeometryOptions& options, const meshing::MeshData& mesh,
                                               const std::string& mesh_name) {
  if (options.model.empty()) return nullptr;
  return std::make_shared<const meshing::Model>(options.model == "carried"
                                                    ? meshing::load_carried_model(mesh.association, mesh_name)
                                                    : meshing::load_model(options.model),
                                                options.model_scale);
}

std::vector<std::string> model_warnings(const meshing::Model* model) {
  std::vector<std::string> all;
  if (!model) return all;
  for (const std::string& warning : model->geometry().warnings())
    all.push_back(model->geometry().name() + ": " + warning);
  return all;
}

}  // namespace weft::tools
