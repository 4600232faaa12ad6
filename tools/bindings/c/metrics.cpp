// Metrics and fields.
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "tools/bindings/c/calls.h"
#include "tools/bindings/c/settings.h"

namespace weft::c {
namespace {

/// Where the components 11 12 22 13 23 33 are in an order of the caller's.
std::array<std::size_t, 6> places_of(weft_tensor_order order) {
  switch (order) {
    case WEFT_ORDER_SOL:
      return {0, 1, 2, 3, 4, 5};
    case WEFT_ORDER_ROWS:
      return {0, 1, 3, 2, 4, 5};
    case WEFT_ORDER_VOIGT:
      return {0, 5, 1, 4, 3, 2};
  }
  throw Misuse("order: " + std::to_string(static_cast<int>(order)) + " is none of weft_tensor_order");
}

std::vector<Tensor> tensors_of(std::int64_t count, const double* values, weft_tensor_order order) {
  const auto at = places_of(order);
  std::vector<Tensor> tensors(static_cast<std::size_t>(count));
  for (std::size_t v = 0; v < tensors.size(); ++v) {
    const double* m = values + 6 * v;
    tensors[v] = {m[at[0]], m[at[1]], m[at[2]], m[at[3]], m[at[4]], m[at[5]]};
  }
  return tensors;
}

std::shared_ptr<const Metric> metric_of(const weft_metric* handle) {
  return object_of<MetricObject>(handle, "metric")->metric;
}
std::shared_ptr<Fields> fields_of(const weft_fields* handle) {
  return object_of<FieldsObject>(handle, "fields")->fields;
}

/// The transfer that fields come from; misuse where they come from none.
std::shared_ptr<const Transfer> transfer_of(const weft_fields* handle) {
  const auto object = object_of<FieldsObject>(handle, "fields");
  require(object->transfer != nullptr, "fields: are not those that weft_interpolate() has made");
  return object->transfer;
}

/// Its name is the transfer's, which lives as long as the fields.
weft_component_account account_of(const ComponentAccount& a) {
  return {sizeof(weft_component_account),
          a.name.c_str(),
          a.integral_before,
          a.integral_after,
          a.absolute,
          a.difference_l2,
          a.norm_l2,
          a.difference_max,
          a.norm_max,
          a.beyond_bounds};
}

/// `source` may be null.
MadeMetric made_metric(const Mesh& mesh, const Metric* source, const Options& options) {
  const int threads = options.run.threads;
  if (source) return make_metric(mesh, *source, options.metric, options.geometry, {}, threads);
  if (!options.metric.given())
    throw OptionError("--metric", "no metric: neither a source nor an option makes one");
  return make_metric(mesh, options.metric, options.geometry, {}, threads);
}

void give_new(weft_metric** place, Metric&& metric) {
  give_metric(place, std::make_shared<const Metric>(std::move(metric)));
}
void give_new(weft_fields** place, Fields&& fields) {
  give_fields(place, std::make_shared<Fields>(std::move(fields)));
}

Field field_of(std::size_t num_points, const std::string& name, int components, const double* values) {
  require(components == 1 || components == 3 || components == 6,
          "components: " + std::to_string(components) + " is none of 1, 3 and 6");
  require_array(values, static_cast<std::int64_t>(num_points), components, "values");
  const std::size_t count = num_points * static_cast<std::size_t>(components);
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(values[i]))
      throw InputError("", "", "values[" + std::to_string(i) + "]: is not finite");
  const Field::Kind kind = components == 1   ? Field::Kind::scalar
                           : components == 3 ? Field::Kind::vector
                                             : Field::Kind::tensor;
  return {kind, {values, values + count}, name};
}

}  // namespace
}  // namespace weft::c

using namespace weft::c;

extern "C" {

weft_status weft_metric_from_tensors(int64_t count, const double* tensors, weft_tensor_order order,
                                     weft_metric** metric) {
  return guarded([&] {
    require_place(metric, "metric");
    require_array(tensors, count, 6, "tensors");
    give_new(metric, weft::Metric::from_tensors(tensors_of(count, tensors, order)));
  });
}

weft_status weft_metric_from_sizes(int64_t count, const double* sizes, weft_metric** metric) {
  return guarded([&] {
    require_place(metric, "metric");
    require_array(sizes, count, 1, "sizes");
    give_new(metric,
             weft::Metric::from_sizes(std::span<const double>(sizes, static_cast<std::size_t>(count))));
  });
}

weft_status weft_metric_read(const char* path, const weft_mesh* mesh, weft_metric** metric) {
  return guarded([&] {
    const std::string file = require_text(path, "path");
    require_place(metric, "metric");
    give_new(metric, weft::read_metric(file, *mesh_of(mesh)));
  });
}

weft_status weft_metric_write(const weft_metric* metric, const char* path) {
  return guarded([&] { weft::write_fields(require_text(path, "path"), metric_of(metric)->fields()); });
}

weft_status weft_metric_make(const weft_mesh* mesh, const weft_metric* source, const weft_options* options,
                             weft_metric** metric) {
  return weft_metric_make_with(mesh, source, options, metric, nullptr);
}

weft_status weft_metric_make_with(const weft_mesh* mesh, const weft_metric* source,
                                  const weft_options* options, weft_metric** metric, weft_text** warnings) {
  return guarded([&] {
    require_place(metric, "metric");
    const auto known = mesh_of(mesh);
    const auto asked = object_of<OptionsObject>(options, "options");
    const auto given = object_or_none<MetricObject>(source, "source");
    weft::MadeMetric made = made_metric(*known, given ? given->metric.get() : nullptr, asked->options);
    NewHandle told = new_lines(made.warnings);
    give_new(metric, std::move(made.metric));
    told.give(warnings);
  });
}

weft_status weft_metric_count(const weft_metric* metric, int64_t* count) {
  return guarded([&] {
    require_place(count, "count");
    *count = static_cast<int64_t>(metric_of(metric)->size());
  });
}

weft_status weft_metric_get(const weft_metric* metric, weft_tensor_order order, int64_t capacity,
                            double* tensors) {
  return guarded([&] {
    const auto known = metric_of(metric);
    const auto at = places_of(order);
    require_array(tensors, capacity, 1, "tensors");
    const auto needed = static_cast<int64_t>(6 * known->size());
    require(needed <= capacity, "capacity: " + std::to_string(capacity) + " numbers, but " +
                                    std::to_string(needed) + " are needed");
    for (std::size_t v = 0; v < known->size(); ++v) {
      const weft::Tensor m = known->tensor(v);
      const std::array<double, 6> values = {m.xx, m.xy, m.yy, m.xz, m.yz, m.zz};
      for (std::size_t i = 0; i < 6; ++i) tensors[6 * v + at[i]] = values[i];
    }
  });
}

weft_status weft_metric_complexity(const weft_mesh* mesh, const weft_metric* metric, double* complexity) {
  return guarded([&] {
    require_place(complexity, "complexity");
    *complexity = weft::complexity(*mesh_of(mesh), *metric_of(metric));
  });
}

weft_status weft_fields_create(int64_t num_points, weft_fields** fields) {
  return guarded([&] {
    require_place(fields, "fields");
    require(num_points >= 0 && num_points < std::numeric_limits<std::uint32_t>::max(),
            "num_points: " + std::to_string(num_points) + " is no number of points that a mesh can have");
    give_new(fields, weft::Fields{static_cast<std::size_t>(num_points), {}});
  });
}

weft_status weft_fields_add(weft_fields* fields, const char* name, int components, const double* values) {
  return guarded([&] {
    const auto object = object_of<FieldsObject>(fields, "fields");
    weft::Field field = field_of(object->fields->num_points, require_text(name, "name"), components, values);
    object->own().fields.push_back(std::move(field));
  });
}

weft_status weft_fields_count(const weft_fields* fields, int64_t* num_fields, int64_t* num_points) {
  return guarded([&] {
    const auto known = fields_of(fields);
    if (num_fields) *num_fields = static_cast<int64_t>(known->fields.size());
    if (num_points) *num_points = static_cast<int64_t>(known->num_points);
  });
}

weft_status weft_fields_get(const weft_fields* fields, int64_t index, const char** name, int* components,
                            const double** values) {
  return guarded([&] {
    const auto known = fields_of(fields);
    require(index >= 0 && index < static_cast<int64_t>(known->fields.size()),
            "index: " + std::to_string(index) + " is none of the " + std::to_string(known->fields.size()) +
                " fields");
    const weft::Field& field = known->fields[static_cast<std::size_t>(index)];
    if (name) *name = field.name.c_str();
    if (components) *components = weft::components(field.kind);
    if (values) *values = field.values.data();
  });
}

weft_status weft_fields_read(const char* path, weft_fields** fields) {
  return guarded([&] {
    const std::string file = require_text(path, "path");
    require_place(fields, "fields");
    give_new(fields, weft::read_fields(file));
  });
}

weft_status weft_fields_write(const weft_fields* fields, const char* path) {
  return guarded([&] { weft::write_fields(require_text(path, "path"), *fields_of(fields)); });
}

weft_status weft_interpolate(const weft_mesh* from, const weft_fields* fields, const weft_mesh* to,
                             const weft_options* options, weft_fields** result) {
  return guarded([&] {
    require_place(result, "result");
    const auto old = mesh_of(from, "from"), fresh = mesh_of(to, "to");
    const auto asked = object_or_none<OptionsObject>(options, "options");
    const weft::Options how = asked ? asked->options : weft::Options{};
    weft::validate(how);
    auto transfer = std::make_shared<weft::Transfer>(
        weft::interpolate(*old, *fields_of(fields), *fresh, how.transfer, how.run.threads));
    auto values = std::make_shared<weft::Fields>(std::exchange(transfer->fields, {}));
    give_fields(result, std::move(values), std::move(transfer));
  });
}

weft_status weft_fields_account(const weft_fields* fields, int64_t index, weft_component_account* account) {
  return guarded([&] {
    require_place(account, "account");
    const auto& all = transfer_of(fields)->accounts;
    require(
        index >= 0 && index < static_cast<int64_t>(all.size()),
        "index: " + std::to_string(index) + " is none of the " + std::to_string(all.size()) + " components");
    fill_sized(*account, account_of(all[static_cast<std::size_t>(index)]), "account");
  });
}

weft_status weft_fields_outside(const weft_fields* fields, int64_t* vertices, double* farthest) {
  return guarded([&] {
    const auto transfer = transfer_of(fields);
    if (vertices) *vertices = static_cast<int64_t>(transfer->outside);
    if (farthest) *farthest = transfer->farthest;
  });
}

}  // extern "C"
