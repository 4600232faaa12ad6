#include "tools/library/report/json_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "engine/json/json.h"
#include "meshing/base/error.h"

namespace weft::tools {

nlohmann::ordered_json read_json(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw meshing::InputError(path, "", std::string("cannot be opened: ") + std::strerror(errno));
  try {
    return nlohmann::ordered_json::parse(file);
  } catch (const nlohmann::json::parse_error& error) {
    throw meshing::InputError(path, "byte " + std::to_string(error.byte), "is no JSON");
  } catch (const nlohmann::json::out_of_range&) {
    throw meshing::InputError(path, "", "has a number that is too large");
  }
}

}  // namespace weft::tools
