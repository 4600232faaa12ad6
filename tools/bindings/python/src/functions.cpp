// Metrics, measures, checks, transfer, simple meshes.
#include <pybind11/stl.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "tools/bindings/python/src/arrays.h"
#include "tools/bindings/python/src/parts.h"
#include "tools/bindings/python/src/texts.h"

namespace weft::python {
namespace {

template <class Value>
std::shared_ptr<Value> shared(Value&& value) {
  return std::make_shared<Value>(std::forward<Value>(value));
}

py::tuple run_make_metric(const Mesh& mesh, const std::shared_ptr<Metric>& source, const py::dict& values,
                          const py::object& solutions, const std::optional<std::string>& order) {
  Options options = options_of(values);
  if (!solutions.is_none())
    options.metric.solutions = {fields_of(solutions, mesh.points.size(), order, "solutions")};
  if (!source && !options.metric.given())
    throw OptionError("--metric", "no metric: give one, solutions, or an option that makes one");
  MadeMetric made;
  {
    const py::gil_scoped_release released;
    made = source ? make_metric(mesh, *source, options.metric, options.geometry, {}, options.run.threads)
                  : make_metric(mesh, options.metric, options.geometry, {}, options.run.threads);
  }
  return py::make_tuple(shared(std::move(made.metric)), message_texts(made.warnings));
}

std::string run_stat(const Mesh& mesh, const std::shared_ptr<Metric>& metric, const py::dict& values) {
  const Options options = options_of(values);
  const py::gil_scoped_release released;
  return to_json(measure_all(mesh, metric.get(), options.geometry, {}, options.run.threads));
}

/// `against`: null, or another mesh; in what they differ is among the problems.
py::dict run_verify(const Mesh& mesh, const std::shared_ptr<Mesh>& against, int max_problems) {
  CheckReport report;
  {
    const py::gil_scoped_release released;
    report = verify(mesh, max_problems);
    if (against) {
      const std::vector<std::string> found = differences(report, verify(*against, 0));
      report.problems.insert(report.problems.end(), found.begin(), found.end());
      report.num_problems += found.size();
    }
  }
  py::dict all;
  all["ok"] = report.ok();
  all["problems"] = report.problems;
  all["num_problems"] = report.num_problems;
  all["num_components"] = report.num_components;
  all["volume"] = report.volume;
  all["volume_by_ref"] = report.volume_by_ref;
  all["area_by_ref"] = report.area_by_ref;
  all["unreferenced_points"] = report.unreferenced_points;
  all["touching_edges"] = report.touching_edges;
  all["touching_vertices"] = report.touching_vertices;
  return all;
}

/// What was done, a line each.
std::vector<std::string> lines_of(const std::vector<Mend>& mends) {
  std::istringstream text(mends_text(mends));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

py::tuple run_repair(const Mesh& mesh, const py::object& fields, const std::optional<std::string>& order) {
  const auto mended = std::make_shared<Mesh>(mesh);
  Fields carried = fields_of(fields, mesh.points.size(), order);
  std::vector<Mend> mends;
  {
    const py::gil_scoped_release released;
    mends = repair(*mended, &carried);
  }
  return py::make_tuple(mended, held(std::move(carried)), lines_of(mends));
}

py::tuple run_repair_metric(const Mesh& mesh, const py::object& fields,
                            const std::optional<std::string>& order) {
  Fields mended = fields_of(fields, mesh.points.size(), order, "fields", Values::any);
  std::vector<Mend> mends;
  {
    const py::gil_scoped_release released;
    mends = repair_metric(mesh, mended);
  }
  return py::make_tuple(held(std::move(mended)), lines_of(mends));
}

py::tuple run_repair_surface(const Mesh& surface) {
  const auto mended = std::make_shared<Mesh>(surface);
  std::vector<Mend> mends;
  {
    const py::gil_scoped_release released;
    mends = repair_surface(*mended);
  }
  return py::make_tuple(mended, lines_of(mends));
}

py::dict account(const ComponentAccount& a) {
  py::dict all;
  all["name"] = name_text(a.name);
  all["integral_before"] = a.integral_before;
  all["integral_after"] = a.integral_after;
  all["absolute"] = a.absolute;
  all["difference_l2"] = a.difference_l2;
  all["norm_l2"] = a.norm_l2;
  all["difference_max"] = a.difference_max;
  all["norm_max"] = a.norm_max;
  all["beyond_bounds"] = a.beyond_bounds;
  all["stays_definite"] = a.stays_definite;
  return all;
}

py::dict run_interpolate(const Mesh& from, const py::object& fields, const Mesh& to, const py::dict& values,
                         const std::optional<std::string>& order) {
  const Options options = options_of(values);
  validate(options);
  const Fields given = fields_of(fields, from.points.size(), order);
  auto transfer = std::make_shared<Transfer>();
  {
    const py::gil_scoped_release released;
    *transfer = interpolate(from, given, to, options.transfer, options.run.threads);
  }
  py::list accounts;
  for (const ComponentAccount& a : transfer->accounts) accounts.append(account(a));
  const py::capsule owner(new std::shared_ptr<Transfer>(transfer),
                          [](void* held) { delete static_cast<std::shared_ptr<Transfer>*>(held); });
  py::dict all;
  all["fields"] = dictionary_of(transfer->fields, owner);
  all["outside"] = transfer->outside;
  all["farthest"] = transfer->farthest;
  all["accounts"] = accounts;
  return all;
}

Point point_of(const std::array<double, 3>& x) { return {x[0], x[1], x[2]}; }

void require_length(const char* name, double value) {
  if (!(value > 0 && std::isfinite(value)))
    throw OptionError(std::string("--") + name, std::to_string(value) + " is not a positive number");
}

std::shared_ptr<Mesh> run_box(const std::array<std::uint32_t, 3>& cells, const std::array<double, 3>& min,
                              const std::array<double, 3>& max) {
  std::uint64_t tets = 6;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (cells[axis] == 0) throw OptionError("--cells", "0 are too few");
    if (!(min[axis] < max[axis]) || !std::isfinite(max[axis] - min[axis]))
      throw OptionError("--max", "must be above --min in every direction");
    tets *= cells[axis];
    if (tets > std::numeric_limits<std::uint32_t>::max())
      throw OptionError("--cells", "are more than a mesh can have");
  }
  return shared(box({cells, point_of(min), point_of(max)}));
}

std::shared_ptr<Mesh> run_ball(double radius, const std::array<double, 3>& center, double size) {
  require_length("radius", radius);
  require_length("size", size);
  return shared(ball_surface({point_of(center), radius, size}));
}

std::shared_ptr<Mesh> run_cylinder(double radius, double height, const std::array<double, 3>& base,
                                   double size) {
  require_length("radius", radius);
  require_length("height", height);
  require_length("size", size);
  return shared(cylinder_surface({point_of(base), radius, height, size}));
}

std::shared_ptr<Mesh> run_tessellate(const py::dict& values, double angle) {
  const Options options = options_of(values);
  if (!(angle > 0 && angle <= 180)) throw OptionError("--angle", "is not from 0 to 180 degrees");
  const py::gil_scoped_release released;
  return shared(tessellate(options.geometry, {options.geometry.hausd, angle}));
}

py::list run_named_options() {
  py::list all;
  for (const NamedOption& option : named_options())
    all.append(py::make_tuple(option.name, option.type, option.text, option.of_command));
  return all;
}

}  // namespace

void add_functions(py::module_& module) {
  using Released = py::call_guard<py::gil_scoped_release>;
  module.def("make_metric", &run_make_metric);
  module.def("complexity", &complexity, Released());
  module.def(
      "measure", [](const Mesh& mesh, const Metric& metric) { return to_json(measure(mesh, metric)); },
      Released());
  module.def("stat", &run_stat);
  module.def("verify", &run_verify);
  module.def("interpolate", &run_interpolate);
  module.def("repair", &run_repair);
  module.def("repair_metric", &run_repair_metric);
  module.def("repair_surface", &run_repair_surface);
  module.def("box", &run_box, Released());
  module.def("ball_surface", &run_ball, Released());
  module.def("cylinder_surface", &run_cylinder, Released());
  module.def(
      "delta_wing_surface", [](double size) { return shared(delta_wing_surface({size})); }, Released());
  module.def("tessellate", &run_tessellate);
  module.def("named_options", &run_named_options);
  module.def("version", &version);
  module.def("version_details", &version_details);
}

}  // namespace weft::python
