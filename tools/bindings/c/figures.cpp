// What is measured of meshes, as text and pictures.
#include <cstddef>
#include <span>
#include <string>

#include "tools/bindings/c/asked.h"
#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"

namespace weft::c {
namespace {

weft_picture_settings default_picture() {
  static const PictureOptions options;
  weft_picture_settings s{};
  s.size = sizeof s;
  s.color_by = options.color_by.c_str();
  s.pixels = options.size.c_str();
  s.from = options.from.c_str();
  s.zoom = options.zoom;
  s.line_width = options.line_width;
  s.edges = options.edges;
  s.legend = options.legend;
  s.axes = options.axes;
  return s;
}

PictureOptions picture_options_of(const weft_picture_settings* settings) {
  weft_picture_settings s = default_picture();
  if (settings) copy_sized(&s, sizeof s, settings, settings->size, "settings");
  PictureOptions options;
  options.color_by = require_text(s.color_by, "color_by");
  options.size = require_text(s.pixels, "pixels");
  options.from = require_text(s.from, "from");
  options.up = text_or_none(s.up);
  options.clip = text_or_none(s.clip);
  options.focus = text_or_none(s.focus);
  options.range = text_or_none(s.range);
  options.title = text_or_none(s.title);
  if (s.only) {
    require_array(s.only, s.num_only, 1, "only");
    options.only.assign(s.only, s.only + s.num_only);
  }
  options.zoom = s.zoom;
  options.line_width = s.line_width;
  options.dark = s.dark != 0;
  options.flip = s.flip != 0;
  options.slice = s.slice != 0;
  options.edges = s.edges != 0;
  options.legend = s.legend != 0;
  options.axes = s.axes != 0;
  return options;
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_text_get(const weft_text* text, const char** letters) {
  return guarded([&] {
    require_place(letters, "letters");
    *letters = object_of<TextObject>(text, "text")->text.c_str();
  });
}

weft_status weft_mesh_compare(const weft_mesh* mesh, const weft_mesh* other, int64_t* num_differences) {
  return guarded([&] {
    require_place(num_differences, "num_differences");
    const auto known = mesh_of(mesh, "mesh"), against = mesh_of(other, "other");
    const auto found = weft::differences(weft::verify(*known, 0), weft::verify(*against, 0));
    std::string text = std::to_string(found.size()) + " differences";
    for (const std::string& difference : found) text += "; " + difference;
    if (!found.empty()) set_last_error(text);
    *num_differences = static_cast<int64_t>(found.size());
  });
}

weft_status weft_stat(const weft_mesh* mesh, const weft_metric* metric, const weft_options* options,
                      weft_text** json) {
  return guarded([&] {
    require_place(json, "json");
    const auto known = mesh_of(mesh);
    const auto given = object_or_none<MetricObject>(metric, "metric");
    const Asked asked(options);
    give_text(json, weft::to_json(weft::measure_all(*known, given ? given->metric.get() : nullptr,
                                                    asked->geometry, {}, asked->run.threads)));
  });
}

weft_status weft_draw_histograms(const char* path, const weft_mesh* mesh, const weft_metric* metric) {
  return guarded([&] {
    const std::string file = require_text(path, "path");
    const auto known = mesh_of(mesh);
    const auto given = object_of<MetricObject>(metric, "metric")->metric;
    weft::draw_histograms(file, weft::measure(*known, *given), "the mesh in the metric");
  });
}

weft_status weft_picture_settings_default(weft_picture_settings* settings) {
  return guarded([&] {
    require_place(settings, "settings");
    fill_sized(*settings, default_picture(), "settings");
  });
}

weft_status weft_draw(const char* path, const weft_mesh* mesh, const weft_metric* metric, const double* field,
                      int64_t num_values, const weft_picture_settings* settings) {
  return guarded([&] {
    const std::string file = require_text(path, "path");
    require(weft::is_picture_name(file), "path: '" + file + "' ends with none of .png, .svg and .pdf");
    const auto known = mesh_of(mesh);
    const auto given = object_or_none<MetricObject>(metric, "metric");
    weft::PictureOptions options = picture_options_of(settings);
    std::span<const double> values;
    if (field) {
      require_array(field, num_values, 1, "field");
      values = {field, static_cast<std::size_t>(num_values)};
      options.color_by = "field";
    }
    weft::draw(file, {*known, given ? given->metric.get() : nullptr, values, "field", nullptr}, options);
  });
}

}  // extern "C"
