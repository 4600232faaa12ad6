#include "tools/bindings/python/src/arrays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tools/bindings/python/src/texts.h"

namespace weft::python {
namespace {

using RealArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using IndexArray = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void refuse(const std::string& name, const std::string& reason) {
  throw InputError("", name, reason);
}

std::string at(const char* name, std::size_t row) {
  return std::string(name) + "[" + std::to_string(row) + "]";
}
std::string at(const char* name, std::size_t row, std::size_t column) {
  return std::string(name) + "[" + std::to_string(row) + ", " + std::to_string(column) + "]";
}

py::array array_of(const py::object& values, const char* name, const char* kinds, const char* wanted) {
  py::array array = py::array::ensure(values);
  if (!array) {
    PyErr_Clear();
    throw UsageError(std::string(name) + ": is no array of " + wanted);
  }
  if (array.size() > 0 && std::string(kinds).find(array.dtype().kind()) == std::string::npos)
    throw UsageError(std::string(name) + ": has dtype " + std::string(py::str(array.dtype())) +
                     ", not one of " + wanted);
  return array;
}

void require_shape(const py::array& array, std::size_t width, const char* name) {
  const bool good =
      width == 1 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == static_cast<py::ssize_t>(width);
  if (good || (array.size() == 0 && array.ndim() <= 2)) return;
  refuse(name, "has shape " + shape_text(array) + ", not (n" +
                   (width == 1 ? std::string(",)") : ", " + std::to_string(width) + ")"));
}

/// Calls use(values) with the contiguous numbers of an index array in its own type.
template <class Use>
void with_indices(const py::object& values, std::size_t width, const char* name, const Use& use) {
  const py::array array = array_of(values, name, "iu", "whole numbers");
  require_shape(array, width, name);
  const auto count = static_cast<std::size_t>(array.size());
  if (count == 0) return use(static_cast<const std::int64_t*>(nullptr), std::size_t{0});
  const bool in_place = (array.flags() & py::array::c_style) != 0;
  if (in_place && py::isinstance<py::array_t<std::int32_t>>(array))
    return use(static_cast<const std::int32_t*>(array.data()), count);
  if (in_place && py::isinstance<py::array_t<std::uint32_t>>(array))
    return use(static_cast<const std::uint32_t*>(array.data()), count);
  if (py::isinstance<py::array_t<std::uint64_t>>(array)) {
    const py::array_t<std::uint64_t, py::array::c_style> wide(array);
    return use(wide.data(), count);
  }
  const IndexArray wide(array);
  use(wide.data(), count);
}

/// Whether a number of any integer type is in [0, limit).
template <class Value>
bool is_index(Value value, std::size_t limit) {
  return std::cmp_greater_equal(value, 0) && std::cmp_less(value, limit);
}

std::array<std::size_t, 6> places_of(const std::optional<std::string>& order, const char* name) {
  if (!order)
    throw UsageError(
        std::string(name) +
        ": has 6 components; say by order= which is where: 'sol' (11 12 22 13 23 33), 'rows' (11 12 13 "
        "22 23 33) or 'voigt' (11 22 33 23 13 12)");
  if (*order == "sol") return {0, 1, 2, 3, 4, 5};
  if (*order == "rows") return {0, 1, 3, 2, 4, 5};
  if (*order == "voigt") return {0, 5, 1, 4, 3, 2};
  throw UsageError("order: '" + *order + "' is none of 'sol', 'rows', 'voigt'");
}

Tensor full_tensor(const double* m, const char* name, std::size_t row) {
  double largest = 0;
  for (int i = 0; i < 9; ++i) largest = std::max(largest, std::abs(m[i]));
  constexpr double kRounding = 1e-10;
  for (const auto& [a, b] : {std::pair(1, 3), std::pair(2, 6), std::pair(5, 7)})
    if (!(std::abs(m[a] - m[b]) <= kRounding * largest)) refuse(at(name, row), "is not symmetric");
  return {m[0], m[1], m[4], m[2], m[5], m[8]};
}

/// Tensors of an array of shape (n, 6) or (n, 3, 3).
std::vector<Tensor> read_tensors(const RealArray& array, const std::optional<std::string>& order,
                                 const char* name) {
  const auto count = static_cast<std::size_t>(array.shape(0));
  std::vector<Tensor> tensors(count);
  const double* values = array.data();
  if (array.ndim() == 3) {
    for (std::size_t v = 0; v < count; ++v) tensors[v] = full_tensor(values + 9 * v, name, v);
    return tensors;
  }
  const auto place = places_of(order, name);
  for (std::size_t v = 0; v < count; ++v) {
    const double* m = values + 6 * v;
    tensors[v] = {m[place[0]], m[place[1]], m[place[2]], m[place[3]], m[place[4]], m[place[5]]};
  }
  return tensors;
}

void require_finite(const RealArray& array, const char* name) {
  const double* values = array.data();
  const auto size = static_cast<std::size_t>(array.size());
  const std::size_t width =
      array.ndim() > 0 && array.shape(0) > 0 ? size / static_cast<std::size_t>(array.shape(0)) : 1;
  for (std::size_t i = 0; i < size; ++i)
    if (!std::isfinite(values[i])) refuse(at(name, i / width), "is not finite");
}

bool is_full_tensors(const py::array& array) {
  return array.ndim() == 3 && array.shape(1) == 3 && array.shape(2) == 3;
}

/// Errors call it `argument['name']`.
Field field_of(const std::string& argument, const std::string& name, const py::object& given,
               std::size_t num_points, const std::optional<std::string>& order, Values values) {
  const std::string called = argument + "['" + name + "']";
  const RealArray array = real_array(given, called.c_str());
  if (array.ndim() < 1 || array.shape(0) != static_cast<py::ssize_t>(num_points))
    refuse(called, "has shape " + shape_text(array) + ", not one row for each of the " +
                       std::to_string(num_points) + " points");
  if (values == Values::finite) require_finite(array, called.c_str());
  const bool tensors = is_full_tensors(array) || (array.ndim() == 2 && array.shape(1) == 6);
  if (tensors) {
    Field field{Field::Kind::tensor, {}, name};
    for (const Tensor& m : read_tensors(array, order, called.c_str()))
      field.values.insert(field.values.end(), {m.xx, m.xy, m.yy, m.xz, m.yz, m.zz});
    return field;
  }
  const bool scalar = array.ndim() == 1 || (array.ndim() == 2 && array.shape(1) == 1);
  if (!scalar && !(array.ndim() == 2 && array.shape(1) == 3))
    refuse(called, "has shape " + shape_text(array) + ", not (n,), (n, 3), (n, 6) or (n, 3, 3)");
  return {
      scalar ? Field::Kind::scalar : Field::Kind::vector, {array.data(), array.data() + array.size()}, name};
}

void write_full(const Tensor& m, double* to) {
  const std::array<double, 9> full = {m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz};
  std::copy(full.begin(), full.end(), to);
}

}  // namespace

RealArray real_array(const py::object& values, const char* name) {
  return RealArray(array_of(values, name, "fiu", "real numbers"));
}

std::vector<Point> points_of(const py::object& values, const char* name) {
  const RealArray array = real_array(values, name);
  require_shape(array, 3, name);
  require_finite(array, name);
  std::vector<Point> points(static_cast<std::size_t>(array.size()) / 3);
  const double* x = array.data();
  for (std::size_t p = 0; p < points.size(); ++p) points[p] = {x[3 * p], x[3 * p + 1], x[3 * p + 2]};
  return points;
}

template <std::size_t N>
std::vector<std::array<std::uint32_t, N>> rows_of(const py::object& values, std::size_t limit,
                                                  const char* name) {
  std::vector<std::array<std::uint32_t, N>> rows;
  if (values.is_none()) return rows;
  with_indices(values, N, name, [&](const auto* numbers, std::size_t count) {
    rows.resize(count / N);
    for (std::size_t i = 0; i < count; ++i) {
      if (!is_index(numbers[i], limit))
        refuse(at(name, i / N, i % N),
               std::to_string(numbers[i]) + " is not an index of the " + std::to_string(limit) + " points");
      rows[i / N][i % N] = static_cast<std::uint32_t>(numbers[i]);
    }
  });
  return rows;
}

template std::vector<std::array<std::uint32_t, 4>> rows_of<4>(const py::object&, std::size_t, const char*);
template std::vector<std::array<std::uint32_t, 3>> rows_of<3>(const py::object&, std::size_t, const char*);
template std::vector<std::array<std::uint32_t, 2>> rows_of<2>(const py::object&, std::size_t, const char*);

std::vector<std::uint32_t> indices_of(const py::object& values, std::size_t limit, const char* name) {
  std::vector<std::uint32_t> indices;
  if (values.is_none()) return indices;
  with_indices(values, 1, name, [&](const auto* numbers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      if (!is_index(numbers[i], limit))
        refuse(at(name, i), std::to_string(numbers[i]) + " is not an index below " + std::to_string(limit));
      indices.push_back(static_cast<std::uint32_t>(numbers[i]));
    }
  });
  return indices;
}

std::vector<std::int32_t> refs_of(const py::object& values, std::size_t entities, const char* name) {
  std::vector<std::int32_t> refs(entities);
  if (values.is_none()) return refs;
  with_indices(values, 1, name, [&](const auto* numbers, std::size_t count) {
    if (count != entities)
      refuse(name, "has " + std::to_string(count) + " references, not one for each of the " +
                       std::to_string(entities) + " entities");
    for (std::size_t i = 0; i < count; ++i) {
      if (!std::in_range<std::int32_t>(numbers[i]))
        refuse(at(name, i), std::to_string(numbers[i]) + " does not fit into 32 bits");
      refs[i] = static_cast<std::int32_t>(numbers[i]);
    }
  });
  return refs;
}

std::vector<std::uint64_t> ids_of(const py::object& values, std::size_t entities, const char* name) {
  std::vector<std::uint64_t> ids;
  if (values.is_none()) return ids;
  with_indices(values, 1, name, [&](const auto* numbers, std::size_t count) {
    if (count != entities)
      refuse(name, "has " + std::to_string(count) + " ids, not one for each of the " +
                       std::to_string(entities) + " entities");
    ids.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      if (std::cmp_less(numbers[i], 0)) refuse(at(name, i), std::to_string(numbers[i]) + " is negative");
      ids[i] = static_cast<std::uint64_t>(numbers[i]);
    }
  });
  std::vector<std::size_t> order(ids.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (ids[order[i]] == ids[order[i - 1]])
      refuse(at(name, order[i]),
             std::to_string(ids[order[i]]) + " is that of " + at(name, order[i - 1]) + " too");
  return ids;
}

Metric metric_of(const py::object& values, const std::optional<std::string>& order) {
  constexpr const char* kName = "metric";
  const RealArray array = real_array(values, kName);
  require_finite(array, kName);
  if (array.ndim() == 1 || (array.ndim() == 2 && array.shape(1) == 1)) {
    for (py::ssize_t i = 0; i < array.size(); ++i)
      if (!(array.data()[i] > 0)) refuse(at(kName, static_cast<std::size_t>(i)), "is not a size above 0");
    return Metric::from_sizes(std::span(array.data(), static_cast<std::size_t>(array.size())));
  }
  if (!is_full_tensors(array) && !(array.ndim() == 2 && array.shape(1) == 6))
    refuse(kName, "has shape " + shape_text(array) + ", not (n,), (n, 6) or (n, 3, 3)");
  const std::vector<Tensor> tensors = read_tensors(array, order, kName);
  try {
    return Metric::from_tensors(tensors);
  } catch (const InputError& error) {  // "metric: vertex 1: ...": as in files, where arrays count from 0
    const std::string begin = std::string(kName) + ": vertex ", said = error.what();
    if (!said.starts_with(begin)) throw;
    std::size_t digits = 0;
    const std::size_t vertex = std::stoull(said.substr(begin.size()), &digits);
    refuse(at(kName, vertex - 1), said.substr(begin.size() + digits + 2));
  }
}

Fields fields_of(const py::object& dictionary, std::size_t num_points,
                 const std::optional<std::string>& order, const std::string& argument, Values values) {
  Fields fields{num_points, {}};
  if (dictionary.is_none()) return fields;
  if (!py::isinstance<py::dict>(dictionary))
    throw UsageError(argument + ": is no dictionary from names to arrays");
  for (const auto& [key, array] : py::reinterpret_borrow<py::dict>(dictionary)) {
    std::string name;
    try {
      name = bytes_of_name(py::str(key));
    } catch (const py::cast_error&) {
      throw UsageError(argument + ": has a name that is no text");
    }
    fields.fields.push_back(
        field_of(argument, name, py::reinterpret_borrow<py::object>(array), num_points, order, values));
  }
  return fields;
}

py::dict dictionary_of(const Fields& fields, const py::object& owner) {
  py::dict all;
  const auto count = static_cast<py::ssize_t>(fields.num_points);
  for (std::size_t f = 0; f < fields.fields.size(); ++f) {
    const Field& field = fields.fields[f];
    std::string name = field.name.empty() ? "field" + std::to_string(f + 1) : field.name;
    while (all.contains(name_text(name))) name += "_";
    const py::str key = name_text(name);
    if (field.kind == Field::Kind::scalar) {
      all[key] = view(field.values.data(), {count}, owner);
    } else if (field.kind == Field::Kind::vector) {
      all[key] = view(field.values.data(), {count, 3}, owner);
    } else {
      py::array_t<double> tensors(std::vector<py::ssize_t>{count, 3, 3});
      for (std::size_t v = 0; v < fields.num_points; ++v) {
        const double* m = field.values.data() + 6 * v;
        write_full({m[0], m[1], m[2], m[3], m[4], m[5]}, tensors.mutable_data() + 9 * v);
      }
      all[key] = std::move(tensors);
    }
  }
  return all;
}

py::dict held(Fields&& fields) {
  auto* kept = new Fields(std::move(fields));
  const py::capsule owner(kept, [](void* place) { delete static_cast<Fields*>(place); });
  return dictionary_of(*kept, owner);
}

py::array_t<double> tensors_of(const Metric& metric, const std::optional<std::string>& order) {
  const auto count = static_cast<py::ssize_t>(metric.size());
  if (!order) {
    py::array_t<double> full(std::vector<py::ssize_t>{count, 3, 3});
    for (std::size_t v = 0; v < metric.size(); ++v) write_full(metric.tensor(v), full.mutable_data() + 9 * v);
    return full;
  }
  const auto place = places_of(order, "order");
  py::array_t<double> tensors(std::vector<py::ssize_t>{count, 6});
  for (std::size_t v = 0; v < metric.size(); ++v) {
    const Tensor m = metric.tensor(v);
    const std::array<double, 6> values = {m.xx, m.xy, m.yy, m.xz, m.yz, m.zz};
    for (std::size_t i = 0; i < 6; ++i) tensors.mutable_data()[6 * v + place[i]] = values[i];
  }
  return tensors;
}

}  // namespace weft::python
