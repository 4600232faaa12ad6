// Options: by struct and by name; progress and cancel.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"

namespace weft::c {
namespace {

weft_settings default_settings() {
  const Options options;
  weft_settings s{};
  s.size = sizeof s;
  s.complexity = options.metric.complexity;
  s.hmin = options.metric.hmin;
  s.hmax = options.metric.hmax;
  s.aspect = options.metric.aspect;
  s.hgrad = options.metric.hgrad;
  s.curvature = options.metric.curvature;
  s.sagitta = options.metric.sagitta;
  s.ridge_angle = options.geometry.ridge_angle;
  s.hausd = options.geometry.hausd;
  s.norm = options.metric.norm;
  s.threads = options.run.threads;
  s.subdomains = static_cast<std::int32_t>(options.distributed.subdomains);
  return s;
}

void apply(const weft_settings& s, Options& options) {
  options.metric.complexity = s.complexity;
  options.metric.hmin = s.hmin;
  options.metric.hmax = s.hmax;
  options.metric.aspect = s.aspect;
  options.metric.hgrad = s.hgrad;
  options.metric.curvature = s.curvature;
  options.metric.sagitta = s.sagitta;
  options.geometry.ridge_angle = s.ridge_angle;
  options.geometry.hausd = s.hausd;
  options.metric.norm = s.norm;
  options.run.threads = s.threads;
  set_option(options, "subdomains", std::to_string(s.subdomains));
  options.metric.implied = s.implied != 0;
  options.transfer = s.conservative ? TransferMethod::conservative : TransferMethod::linear;
  options.distributed.ghosts = s.ghosts != 0;
  options.run.force = s.force != 0;
}

std::function<bool(const Progress&)> progress_of(weft_progress_function function, void* user) {
  if (!function) return nullptr;
  return [function, user](const Progress& now) {
    const weft_progress told = {sizeof told, now.stage.c_str(), now.done, now.tets};
    return function(user, &told) != 0;
  };
}

}  // namespace

void copy_sized(void* to, std::size_t known, const void* from, std::size_t size, const char* argument) {
  // Sizes of structs are whole multiples: none ends within a pointer.
  require(size >= sizeof size && size <= known && size % sizeof size == 0,
          fmt::format("{}: its size says {} bytes, but this library knows {}: start from the defaults",
                      argument, size, known));
  std::memcpy(to, from, size);
}

}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_settings_default(weft_settings* settings) {
  return guarded([&] {
    require_place(settings, "settings");
    fill_sized(*settings, default_settings(), "settings");
  });
}

weft_status weft_options_create(const weft_settings* settings, weft_options** options) {
  return guarded([&] {
    require_place(options, "options");
    auto object = std::make_shared<OptionsObject>();
    object->options.run.cancel = &object->cancel;
    object->options.checkpoint.now = &object->checkpoint;
    if (settings) {
      weft_settings known = default_settings();
      copy_sized(&known, sizeof known, settings, settings->size, "settings");
      apply(known, object->options);
      weft::validate(object->options);
    }
    give(options, std::move(object));
  });
}

weft_status weft_options_set(weft_options* options, const char* name, const char* value) {
  return guarded([&] {
    const auto object = object_of<OptionsObject>(options, "options");
    weft::set_option(object->options, require_text(name, "name"), require_text(value, "value"));
  });
}

weft_status weft_options_set_number(weft_options* options, const char* name, double value) {
  return guarded([&] {
    const auto object = object_of<OptionsObject>(options, "options");
    weft::set_option(object->options, require_text(name, "name"), fmt::format("{:.17g}", value));
  });
}

const char* weft_option_name(int64_t index, const char** type, const char** text) {
  try {
    const auto& all = weft::named_options();
    if (index < 0 || index >= static_cast<int64_t>(all.size())) return nullptr;
    const weft::NamedOption& option = all[static_cast<std::size_t>(index)];
    if (type) *type = option.type.c_str();
    if (text) *text = option.text.c_str();
    return option.name.c_str();
  } catch (...) {
    return nullptr;
  }
}

weft_status weft_options_add_solution(weft_options* options, const weft_fields* solution) {
  return guarded([&] {
    const auto object = object_of<OptionsObject>(options, "options");
    object->options.metric.solutions.push_back(*object_of<FieldsObject>(solution, "solution")->fields);
  });
}

weft_status weft_options_set_progress(weft_options* options, weft_progress_function function, void* user) {
  return guarded([&] {
    const auto object = object_of<OptionsObject>(options, "options");
    object->options.run.progress = progress_of(function, user);
  });
}

weft_status weft_options_checkpoint(weft_options* options) {
  return guarded([&] { object_of<OptionsObject>(options, "options")->checkpoint = true; });
}

weft_status weft_options_cancel(weft_options* options, int cancel) {
  return guarded([&] { object_of<OptionsObject>(options, "options")->cancel = cancel != 0; });
}

}  // extern "C"
