#include "tools/bindings/python/src/texts.h"

namespace weft::python {
namespace {

constexpr const char* kSurrogates = "surrogateescape";

py::str decoded(const std::string& bytes, const char* errors) {
  PyObject* text = PyUnicode_DecodeUTF8(bytes.data(), static_cast<py::ssize_t>(bytes.size()), errors);
  if (!text) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(text);
}

}  // namespace

py::str name_text(const std::string& name) { return decoded(name, kSurrogates); }

std::string bytes_of_name(const py::handle& name) {
  const auto bytes =
      py::reinterpret_steal<py::bytes>(PyUnicode_AsEncodedString(name.ptr(), "utf-8", kSurrogates));
  if (bytes) return bytes;
  PyErr_Clear();
  throw py::cast_error("a text that is none");
}

py::str message_text(const std::string& message) { return decoded(message, "replace"); }

py::list message_texts(const std::vector<std::string>& messages) {
  py::list all;
  for (const std::string& message : messages) all.append(message_text(message));
  return all;
}

}  // namespace weft::python
