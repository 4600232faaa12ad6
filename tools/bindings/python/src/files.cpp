// Reading, writing, drawing.
#include <pybind11/stl.h>

#include "tools/bindings/python/src/arrays.h"
#include "tools/bindings/python/src/parts.h"
#include "tools/bindings/python/src/texts.h"

namespace weft::python {
namespace {

/// (what, how many).
py::list list_of(const std::vector<Dropped>& dropped) {
  py::list all;
  for (const Dropped& what : dropped) all.append(py::make_tuple(message_text(what.what), what.count));
  return all;
}

std::shared_ptr<Mesh> run_read(const std::string& path) {
  const py::gil_scoped_release released;
  return std::make_shared<Mesh>(read_mesh(path));
}

py::tuple run_read_all(const std::string& path) {
  MeshFile file;
  {
    const py::gil_scoped_release released;
    file = read_mesh_file(path);
  }
  py::dict names;
  for (const auto& [key, name] : file.names.all())
    names[py::make_tuple(key.dimension, key.ref)] = name_text(name);
  return py::make_tuple(std::make_shared<Mesh>(std::move(file.mesh)), held(std::move(file.fields)), names,
                        list_of(file.dropped));
}

RefNames names_of(const py::object& dictionary) {
  RefNames names;
  if (dictionary.is_none()) return names;
  const char* what = "names: is no dictionary from (dimension, reference) to texts";
  if (!py::isinstance<py::dict>(dictionary)) throw UsageError(what);
  try {
    for (const auto& [key, name] : py::reinterpret_borrow<py::dict>(dictionary)) {
      const auto [dimension, ref] = key.cast<std::pair<int, std::int32_t>>();
      if (!py::isinstance<py::str>(name)) throw UsageError(what);
      names.set(dimension, ref, bytes_of_name(name));
    }
  } catch (const py::cast_error&) {
    throw UsageError(what);
  }
  return names;
}

void run_write(const std::string& path, const Mesh& mesh, const std::shared_ptr<Metric>& metric,
               const py::object& fields, const std::optional<std::string>& order, const py::object& names) {
  const Fields given = fields_of(fields, mesh.points.size(), order);
  const RefNames known = names_of(names);
  const py::gil_scoped_release released;
  if (metric)
    write_result(path, mesh, *metric, given, known);
  else
    write_mesh(path, mesh, given, known);
}

py::dict run_read_fields(const std::string& path) {
  Fields fields;
  {
    const py::gil_scoped_release released;
    fields = read_fields(path);
  }
  return held(std::move(fields));
}

std::shared_ptr<Metric> run_read_metric(const std::string& path, const Mesh& mesh) {
  const py::gil_scoped_release released;
  return std::make_shared<Metric>(read_metric(path, mesh));
}

void run_write_fields(const std::string& path, const py::object& fields,
                      const std::optional<std::string>& order) {
  const py::dict all = fields.cast<py::dict>();
  std::size_t points = 0;
  for (const auto& [name, values] : all) points = py::hasattr(values, "__len__") ? py::len(values) : 0;
  const Fields given = fields_of(fields, points, order);
  const py::gil_scoped_release released;
  write_fields(path, given);
}

void run_write_metric(const std::string& path, const Metric& metric) {
  const py::gil_scoped_release released;
  write_fields(path, metric.fields());
}

template <class Value>
Value value_of(const std::string& name, const py::object& value) {
  try {
    return value.cast<Value>();
  } catch (const std::exception&) {  // pybind11's, or Python's own
    throw UsageError(name + ": a " + std::string(py::str(py::type::of(value).attr("__name__"))) +
                     " makes no sense there");
  }
}

void set_picture_option(PictureOptions& options, const std::string& name, const py::object& value) {
  if (name == "color_by")
    options.color_by = value_of<std::string>(name, value);
  else if (name == "size")
    options.size = value_of<std::string>(name, value);
  else if (name == "view_from")
    options.from = value_of<std::string>(name, value);
  else if (name == "up")
    options.up = value_of<std::string>(name, value);
  else if (name == "clip")
    options.clip = value_of<std::string>(name, value);
  else if (name == "focus")
    options.focus = value_of<std::string>(name, value);
  else if (name == "range")
    options.range = value_of<std::string>(name, value);
  else if (name == "title")
    options.title = value_of<std::string>(name, value);
  else if (name == "only")
    options.only = value_of<std::vector<std::int32_t>>(name, value);
  else if (name == "zoom")
    options.zoom = value_of<double>(name, value);
  else if (name == "line_width")
    options.line_width = value_of<double>(name, value);
  else if (name == "dark")
    options.dark = value_of<bool>(name, value);
  else if (name == "flip")
    options.flip = value_of<bool>(name, value);
  else if (name == "slice")
    options.slice = value_of<bool>(name, value);
  else if (name == "edges")
    options.edges = value_of<bool>(name, value);
  else if (name == "legend")
    options.legend = value_of<bool>(name, value);
  else if (name == "axes")
    options.axes = value_of<bool>(name, value);
  else
    throw OptionError("--" + printable(name), "is not an option of pictures");
}

void run_draw(const std::string& path, const Mesh& mesh, const std::shared_ptr<Metric>& metric,
              const py::object& field, const py::dict& values) {
  if (!is_picture_name(path)) throw InputError(path, "", "is no name of a picture: .png, .svg or .pdf");
  PictureOptions options;
  for (const auto& [name, value] : values)
    set_picture_option(options, py::str(name), py::reinterpret_borrow<py::object>(value));
  std::vector<double> colours;
  if (!field.is_none()) {
    const auto array = real_array(field, "field");
    colours.assign(array.data(), array.data() + array.size());
    if (colours.size() != mesh.points.size())
      throw InputError("", "field",
                       "has " + std::to_string(colours.size()) + " values, not one for each of the " +
                           std::to_string(mesh.points.size()) + " points");
    options.color_by = "field";
  }
  const py::gil_scoped_release released;
  draw(path, {mesh, metric.get(), colours, "field", nullptr}, options);
}

WriteOptions write_options_of(const std::string& encoding, const std::string& msh_version, bool compress,
                              int pieces) {
  WriteOptions options;
  if (encoding == "ascii")
    options.encoding = WriteOptions::Encoding::ascii;
  else if (encoding == "big-endian")
    options.encoding = WriteOptions::Encoding::big_endian;
  else if (encoding != "binary")
    throw OptionError("--encoding", "'" + printable(encoding) + "' is none of binary, ascii, big-endian");
  if (msh_version != "4.1" && msh_version != "2.2")
    throw OptionError("--msh-version", "'" + printable(msh_version) + "' is neither 4.1 nor 2.2");
  options.gmsh_version = msh_version == "2.2" ? 2 : 4;
  options.compress = compress;
  if (pieces < 1 || pieces > 100000)
    throw OptionError("--pieces", std::to_string(pieces) + " is not from 1 to 100000");
  options.pieces = pieces;
  return options;
}

py::list run_convert(const std::string& input, const std::string& output, const std::string& solution,
                     const std::string& encoding, const std::string& msh_version, bool compress, int pieces) {
  const WriteOptions options = write_options_of(encoding, msh_version, compress, pieces);
  Converted done;
  {
    const py::gil_scoped_release released;
    done = convert(input, output, solution, options);
  }
  return list_of(done.dropped);
}

void run_draw_histograms(const std::string& path, const Mesh& mesh, const Metric& metric,
                         const std::string& title) {
  if (!is_picture_name(path)) throw InputError(path, "", "is no name of a picture: .png, .svg or .pdf");
  const py::gil_scoped_release released;
  draw_histograms(path, measure(mesh, metric), title);
}

}  // namespace

void add_files(py::module_& module) {
  module.def("read", &run_read);
  module.def("read_all", &run_read_all);
  module.def("write", &run_write);
  module.def("read_metric", &run_read_metric);
  module.def("read_fields", &run_read_fields);
  module.def("write_fields", &run_write_fields);
  module.def("write_metric", &run_write_metric);
  module.def("convert", &run_convert);
  module.def("draw", &run_draw);
  module.def("draw_histograms", &run_draw_histograms);
}

}  // namespace weft::python
