// NumPy arrays to and from the plain data of weft. What is wrong with one is said by its name and index.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "weft/weft.h"

namespace weft::python {

namespace py = pybind11;

/// Arguments of a kind that makes no sense: weft.UsageError.
class UsageError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Rows of N real numbers, read in place where they are contiguous doubles; copied once where not.
py::array_t<double, py::array::c_style | py::array::forcecast> real_array(const py::object& values,
                                                                          const char* name);

std::vector<Point> points_of(const py::object& values, const char* name);
/// Rows of N indices below `limit`; none for None.
template <std::size_t N>
std::vector<std::array<std::uint32_t, N>> rows_of(const py::object& values, std::size_t limit,
                                                  const char* name);
std::vector<std::uint32_t> indices_of(const py::object& values, std::size_t limit, const char* name);
/// One reference for each of `count` entities; all 0 for None.
std::vector<std::int32_t> refs_of(const py::object& values, std::size_t count, const char* name);
/// Numbers of the whole mesh's vertices or tets; none for None.
std::vector<std::uint64_t> ids_of(const py::object& values, std::size_t count, const char* name);

/// Sizes (n), tensors (n, 6) in the order named or (n, 3, 3).
Metric metric_of(const py::object& values, const std::optional<std::string>& order);
/// Fields of a dictionary, which errors call `argument`: (n), (n, 3), (n, 3, 3), or (n, 6) in the order
/// named. Values are finite but where they are to be repaired.
enum class Values { finite, any };
Fields fields_of(const py::object& dictionary, std::size_t num_points,
                 const std::optional<std::string>& order, const std::string& argument = "fields",
                 Values values = Values::finite);
/// The reverse: views of the fields, which keep `owner` alive; tensors are copied to (n, 3, 3).
py::dict dictionary_of(const Fields& fields, const py::object& owner);
/// The same of fields that nobody else has: they stay as long as anybody looks at them.
py::dict held(Fields&& fields);
/// A metric's tensors as (n, 3, 3), or as (n, 6) in the order named.
py::array_t<double> tensors_of(const Metric& metric, const std::optional<std::string>& order);

/// A view, not to be written to, that keeps `owner` alive.
template <class Value>
py::array view(const Value* values, const std::vector<py::ssize_t>& shape, const py::object& owner) {
  py::array_t<Value> array(shape, values, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

}  // namespace weft::python
