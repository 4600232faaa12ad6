// Translation of the words; the library checks what they name.
#include "tools/weft/options/model_options.h"

namespace weft::tools {

void add_model(CLI::App& sub, GeometryOptions& geometry) {
  sub.add_option("--geometry", geometry.model,
                 "the CAD model the boundary lies on: .step, .iges, .brep, .egads; or: carried")
      ->type_name("FILE")
      ->group("Geometry");
  sub.add_option("--geometry-scale", geometry.model_scale, "multiply the model's lengths by this; default 1")
      ->type_name("S")
      ->group("Geometry");
}

}  // namespace weft::tools
