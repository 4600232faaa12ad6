// Texts to and from Python. Names and paths may have any bytes: those that are no UTF-8 become lone
// surrogates, as in os.fsdecode(), which become these bytes again.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace weft::python {

namespace py = pybind11;

/// Of a field, a reference, a file.
py::str name_text(const std::string& name);
/// The reverse, of a str. Throws py::cast_error for surrogates that stand for no byte.
std::string bytes_of_name(const py::handle& name);

/// What people read: bytes that are no UTF-8 are replaced.
py::str message_text(const std::string& message);
py::list message_texts(const std::vector<std::string>& messages);

}  // namespace weft::python
