// Initial meshes: volumes that triangles bound; triangles of CAD models and of simple bodies.
#include <cmath>
#include <utility>

#include "tools/bindings/c/asked.h"
#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"

namespace weft::c {
namespace {

FillOptions fill_options(const weft_fill_settings& s, const Options& options) {
  FillOptions fill;
  fill.growth = s.growth;
  fill.size = s.max_size;
  fill.merge = s.merge;
  fill.materials = s.materials != 0;
  fill.remesh_surface = s.remesh_surface != 0;
  fill.geometry = options.geometry;
  fill.run = options.run;
  return fill;
}

weft_fill_settings default_fill() {
  const FillOptions fill;
  weft_fill_settings s{};
  s.size = sizeof s;
  s.growth = fill.growth;
  s.max_size = fill.size;
  s.merge = fill.merge;
  s.materials = fill.materials;
  s.remesh_surface = fill.remesh_surface;
  return s;
}

/// `background` and `sizes`: NULL, or the sizes of another mesh.
FillResult filled_volume(const weft_mesh* surface, const Mesh* background, const Metric* sizes,
                         const weft_fill_settings* settings, const weft_options* options) {
  const auto input = mesh_of(surface, "surface");
  weft_fill_settings known = default_fill();
  if (settings) copy_sized(&known, sizeof known, settings, settings->size, "settings");
  const Asked asked(options);
  FillOptions how = fill_options(known, *asked);
  how.background = background;
  how.metric = sizes;
  return fill(*input, how);
}

void fill_volume(const weft_mesh* surface, const Mesh* background, const Metric* sizes,
                 const weft_fill_settings* settings, const weft_options* options, weft_mesh** mesh,
                 weft_metric** metric) {
  require_place(mesh, "mesh");
  FillResult filled = filled_volume(surface, background, sizes, settings, options);
  NewHandle of_metric = new_metric(std::make_shared<const Metric>(std::move(filled.metric)));
  give_mesh(mesh, std::make_shared<Mesh>(std::move(filled.mesh)));
  of_metric.give(metric);
}

void require_length(double value, const char* argument) {
  require(value > 0 && std::isfinite(value),
          std::string(argument) + ": " + std::to_string(value) + " is not a positive number");
}

void give_surface(weft_mesh** place, Mesh&& surface) {
  give_mesh(place, std::make_shared<Mesh>(std::move(surface)));
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_fill_settings_default(weft_fill_settings* settings) {
  return guarded([&] {
    require_place(settings, "settings");
    fill_sized(*settings, default_fill(), "settings");
  });
}

weft_status weft_fill(const weft_mesh* surface, const weft_fill_settings* settings,
                      const weft_options* options, weft_mesh** mesh, weft_metric** metric) {
  return guarded([&] { fill_volume(surface, nullptr, nullptr, settings, options, mesh, metric); });
}

weft_status weft_fill_to_background(const weft_mesh* surface, const weft_mesh* background,
                                    const weft_metric* sizes, const weft_fill_settings* settings,
                                    const weft_options* options, weft_mesh** mesh, weft_metric** metric) {
  return guarded([&] {
    const auto other = mesh_of(background, "background");
    const auto known = object_of<MetricObject>(sizes, "sizes")->metric;
    fill_volume(surface, other.get(), known.get(), settings, options, mesh, metric);
  });
}

weft_status weft_fill_to_result(const weft_mesh* surface, const weft_mesh* background,
                                const weft_metric* sizes, const weft_fill_settings* settings,
                                const weft_options* options, weft_result** result) {
  return guarded([&] {
    require_place(result, "result");
    const auto other = object_or_none<MeshObject>(background, "background");
    const auto known = object_or_none<MetricObject>(sizes, "sizes");
    auto object = std::make_shared<ResultObject>();
    object->filled = std::make_shared<weft::FillResult>(
        filled_volume(surface, other ? other->mesh.get() : nullptr, known ? known->metric.get() : nullptr,
                      settings, options));
    give(result, std::move(object));
  });
}

weft_status weft_tessellate(const weft_options* options, double angle, weft_mesh** surface) {
  return guarded([&] {
    require_place(surface, "surface");
    const auto asked = object_of<OptionsObject>(options, "options");
    const weft::GeometryOptions& geometry = asked->options.geometry;
    weft::TessellationOptions how;
    how.sagitta = geometry.hausd;
    require(angle >= 0 && angle <= 180, "angle: is not from 0 to 180 degrees");
    if (angle > 0) how.angle = angle;
    give_surface(surface, weft::tessellate(geometry, how));
  });
}

weft_status weft_ball_surface(double radius, const double center[3], double size, weft_mesh** surface) {
  return guarded([&] {
    require_place(surface, "surface");
    require_length(radius, "radius");
    require_length(size, "size");
    give_surface(surface, weft::ball_surface({point_of(center, "center"), radius, size}));
  });
}

weft_status weft_cylinder_surface(double radius, double height, const double base[3], double size,
                                  weft_mesh** surface) {
  return guarded([&] {
    require_place(surface, "surface");
    require_length(radius, "radius");
    require_length(height, "height");
    require_length(size, "size");
    give_surface(surface, weft::cylinder_surface({point_of(base, "base"), radius, height, size}));
  });
}

weft_status weft_delta_wing_surface(double size, weft_mesh** surface) {
  return guarded([&] {
    require_place(surface, "surface");
    if (size != 0) require_length(size, "size");
    give_surface(surface, weft::delta_wing_surface({size}));
  });
}

}  // extern "C"
