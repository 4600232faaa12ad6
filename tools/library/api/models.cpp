// CAD models: how a mesh lies on one, and triangles on one.
#include <algorithm>
#include <utility>

#include "engine/json/json.h"
#include "meshing/base/error.h"
#include "meshing/cad/load_model.h"
#include "meshing/kernel/import_mesh.h"
#include "meshing/kernel/on_model.h"
#include "meshing/metric/expectations.h"
#include "tools/common/naming.h"
#include "tools/library/api/whole_mesh.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/sources/model_source.h"
#include "tools/library/report/model_text.h"
#include "tools/library/report/report_json.h"
#include "weft/weft.h"

namespace weft {
namespace {

void check(const GeometryOptions& geometry, int threads) {
  Options options;
  options.geometry = geometry;
  options.run.threads = threads;
  validate(options);
  if (geometry.model.empty()) throw OptionError("--geometry", "no CAD model is named");
}

}  // namespace

ModelAccount measure_on_model(const Mesh& mesh, const GeometryOptions& geometry, const std::string& name,
                              int threads, std::vector<double>* deviations,
                              std::vector<std::string>* warnings) {
  check(geometry, threads);
  const WholeMesh whole(mesh);
  return tools::with_threads(tools::number_of_threads(threads), [&] {
    const auto model = tools::model_of(geometry, *whole, name);
    return tools::naming(name, [&] {
      const meshing::ImportedMesh imported =
          meshing::import_mesh(*whole, geometry.ridge_angle, mesh.points.size(), mesh.tets.size(), model);
      if (warnings) {
        *warnings = tools::model_warnings(model.get());
        warnings->insert(warnings->end(), imported.warnings.begin(), imported.warnings.end());
      }
      ModelAccount account = meshing::account_on_model(*imported.mesh, *imported.surface, deviations);
      account.input = {account.off, account.largest, account.turned};
      return account;
    });
  });
}

std::string summary(const ModelAccount& account) { return tools::model_text(account, true); }
std::string to_json(const ModelAccount& account) { return tools::text_of(tools::json_of(account), 1); }

bool is_model_name(const std::string& path) { return meshing::is_model_name(path); }
std::string model_extensions() { return meshing::model_extensions(); }

Mesh tessellate(const GeometryOptions& geometry, const TessellationOptions& options) {
  check(geometry, 1);
  const auto read = meshing::load_model(geometry.model);
  const meshing::Model model(read);
  meshing::CadTessellation wanted;
  wanted.sagitta =
      options.sagitta > 0 ? options.sagitta / geometry.model_scale : meshing::kHausdOfDiagonal * model.size();
  wanted.angle_degrees = options.angle;
  for (std::uint32_t f = 0; options.sagitta == 0 && f < model.num_faces(); ++f)
    wanted.face_sagittas.push_back(model.detail(f));
  Mesh mesh = meshing::tessellate_model(geometry.model, *read, wanted);
  for (Point& p : mesh.points) p = geometry.model_scale * p;
  return mesh;
}

}  // namespace weft
