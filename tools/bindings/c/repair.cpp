// Imperfect input, mended.
#include "tools/bindings/c/calls.h"

namespace weft::c {
namespace {

/// `place` may be null.
void tell(const std::vector<Mend>& mends, weft_text** place) {
  if (place) give_text(place, weft::mends_text(mends));
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

weft_status weft_mesh_repair(weft_mesh* mesh, weft_fields* fields, weft_text** mends) {
  return guarded([&] {
    const auto object = object_of<MeshObject>(mesh, "mesh");
    const auto values = object_or_none<FieldsObject>(fields, "fields");
    weft::Mesh mended = *object->mesh;  // nothing changes where it cannot be mended
    weft::Fields carried = values ? *values->fields : weft::Fields{};
    const auto done = weft::repair(mended, values ? &carried : nullptr);
    object->own() = std::move(mended);
    if (values) values->own() = std::move(carried);
    tell(done, mends);
  });
}

weft_status weft_fields_repair_metric(weft_fields* fields, const weft_mesh* mesh, weft_text** mends) {
  return guarded([&] {
    const auto values = object_of<FieldsObject>(fields, "fields");
    weft::Fields mended = *values->fields;
    const auto done = weft::repair_metric(*mesh_of(mesh), mended);
    values->own() = std::move(mended);
    tell(done, mends);
  });
}

weft_status weft_surface_repair(weft_mesh* surface, weft_text** mends) {
  return guarded([&] {
    const auto object = object_of<MeshObject>(surface, "surface");
    weft::Mesh mended = *object->mesh;
    const auto done = weft::repair_surface(mended);
    object->own() = std::move(mended);
    tell(done, mends);
  });
}
