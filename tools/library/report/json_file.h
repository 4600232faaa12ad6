// JSON documents as files.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace weft::tools {

/// Throws meshing::InputError, naming file and place, for a file that cannot be read or is no JSON.
nlohmann::ordered_json read_json(const std::string& path);

}  // namespace weft::tools
