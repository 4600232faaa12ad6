// The part of reading rows that depends on no kind of file.
#include "meshing/io/gmf/gmf_rows.h"

namespace weft::meshing::gmf {

std::vector<Field> make_fields(const std::string& file, const std::vector<std::int64_t>& types) {
  if (types.empty()) throw InputError(file, "SolAtVertices", "has no fields");
  std::vector<Field> fields;
  for (const std::int64_t type : types) {
    if (type < 1 || type > 3) {
      throw InputError(file, "SolAtVertices",
                       "field " + std::to_string(fields.size() + 1) + " has type " + std::to_string(type) +
                           "; known are 1 (scalar), 2 (vector) and 3 (symmetric tensor)");
    }
    fields.push_back({static_cast<Field::Kind>(type), {}, {}});
  }
  return fields;
}

}  // namespace weft::meshing::gmf
