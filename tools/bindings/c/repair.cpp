// Imperfect input, mended. What is mended takes the place of what was given when all is done.
#include <memory>
#include <utility>

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
    const auto mended = std::make_shared<weft::Mesh>(*object->mesh);
    const auto carried = values ? std::make_shared<weft::Fields>(*values->fields) : nullptr;
    const auto done = weft::repair(*mended, carried.get());
    object->mesh = mended;
    if (values) values->fields = carried;
    tell(done, mends);
  });
}

weft_status weft_fields_repair_metric(weft_fields* fields, const weft_mesh* mesh, weft_text** mends) {
  return guarded([&] {
    const auto values = object_of<FieldsObject>(fields, "fields");
    const auto mended = std::make_shared<weft::Fields>(*values->fields);
    const auto done = weft::repair_metric(*mesh_of(mesh), *mended);
    values->fields = mended;
    tell(done, mends);
  });
}

weft_status weft_surface_repair(weft_mesh* surface, weft_text** mends) {
  return guarded([&] {
    const auto object = object_of<MeshObject>(surface, "surface");
    const auto mended = std::make_shared<weft::Mesh>(*object->mesh);
    const auto done = weft::repair_surface(*mended);
    object->mesh = mended;
    tell(done, mends);
  });
}
