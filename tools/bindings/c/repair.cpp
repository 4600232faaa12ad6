// Imperfect input, mended. What is mended takes the place of what was given when all is done.
#include <memory>
#include <utility>

#include "tools/bindings/c/calls.h"

using namespace weft::c;

weft_status weft_mesh_repair(weft_mesh* mesh, weft_fields* fields, weft_text** mends) {
  return guarded([&] {
    const auto object = object_of<MeshObject>(mesh, "mesh");
    const auto values = object_or_none<FieldsObject>(fields, "fields");
    const auto mended = std::make_shared<weft::Mesh>(*object->mesh);
    const auto carried = values ? std::make_shared<weft::Fields>(*values->fields) : nullptr;
    NewHandle told = new_text(weft::mends_text(weft::repair(*mended, carried.get())));
    object->mesh = mended;
    if (values) values->fields = carried;
    told.give(mends);
  });
}

weft_status weft_fields_repair_metric(weft_fields* fields, const weft_mesh* mesh, weft_text** mends) {
  return guarded([&] {
    const auto values = object_of<FieldsObject>(fields, "fields");
    const auto mended = std::make_shared<weft::Fields>(*values->fields);
    NewHandle told = new_text(weft::mends_text(weft::repair_metric(*mesh_of(mesh), *mended)));
    values->fields = mended;
    told.give(mends);
  });
}

weft_status weft_surface_repair(weft_mesh* surface, weft_text** mends) {
  return guarded([&] {
    const auto object = object_of<MeshObject>(surface, "surface");
    const auto mended = std::make_shared<weft::Mesh>(*object->mesh);
    NewHandle told = new_text(weft::mends_text(weft::repair_surface(*mended)));
    object->mesh = mended;
    told.give(mends);
  });
}
