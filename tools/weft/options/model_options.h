// The CAD model that a mesh lies on: --geometry, --geometry-scale.
#pragma once

#include <CLI/CLI.hpp>

#include "weft/weft.h"

namespace weft::tools {

void add_model(CLI::App& sub, GeometryOptions& geometry);

}  // namespace weft::tools
