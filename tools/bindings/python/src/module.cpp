// The module weft._weft: what weft/__init__.py is made of. Errors become the classes of weft/_errors.py.
#include <new>

#include "tools/bindings/python/src/arrays.h"
#include "tools/bindings/python/src/parts.h"
#include "tools/bindings/python/src/texts.h"

namespace {

namespace py = pybind11;

void raise_as(const char* name, const char* text) {
  const py::object type = py::module_::import("weft._errors").attr(name);
  PyErr_SetObject(type.ptr(), weft::python::message_text(text).ptr());
}

void translate(std::exception_ptr error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const weft::python::UsageError& e) {
    raise_as("UsageError", e.what());
  } catch (const weft::InputError& e) {
    raise_as("InputError", e.what());
  } catch (const weft::OptionError& e) {
    raise_as("OptionError", e.what());
  } catch (const weft::RunError& e) {
    raise_as("RunError", e.what());
  } catch (const std::bad_alloc&) {
    raise_as("OutOfMemory", "out of memory");
  }
}

}  // namespace

PYBIND11_MODULE(_weft, module) {
  module.doc() = "The compiled part of weft.";
  py::register_exception_translator(&translate);
#if defined(MPICH_VERSION)
  module.attr("mpi") = "MPICH";
#elif defined(OPEN_MPI)
  module.attr("mpi") = "Open MPI";
#else
  module.attr("mpi") = "";
#endif
  weft::python::add_objects(module);
  weft::python::add_runs(module);
  weft::python::add_functions(module);
  weft::python::add_files(module);
}
