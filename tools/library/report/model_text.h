// How a mesh lies on a CAD model, as text and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "weft/data.h"

namespace weft::tools {

/// A few lines; with `entities` a table of them too.
std::string model_text(const meshing::ModelAccount& account, bool entities);
nlohmann::ordered_json json_of(const meshing::ModelAccount& account);

}  // namespace weft::tools
