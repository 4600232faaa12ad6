// What is measured of meshes, as text and pictures.
#include <string>

#include "tools/bindings/c/asked.h"
#include "tools/bindings/c/calls.h"

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

}  // extern "C"
