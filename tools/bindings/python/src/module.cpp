// The module weft._weft: what weft/__init__.py is made of. Errors become the classes of weft/_errors.py.
#include <new>
#include <stdexcept>

#include "tools/bindings/python/src/arrays.h"
#include "tools/bindings/python/src/parts.h"
#include "tools/bindings/python/src/texts.h"

namespace {

namespace py = pybind11;

void raise_as(const char* name, const char* text) {
  const py::object type = py::module_::import("weft._errors").attr(name);
  PyErr_SetObject(type.ptr(), weft::python::message_text(text).ptr());
}

/// As the statuses of C (tools/bindings/c/calls.cpp). What pybind11 and callbacks have raised stays what it
/// is.
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
  } catch (const std::length_error&) {
    raise_as("OutOfMemory", "out of memory: larger than any array can be");
  } catch (const py::error_already_set&) {
    throw;
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const std::exception& e) {
    raise_as("InternalError", e.what());
  }
}

}  // namespace

PYBIND11_MODULE(_weft, module) {
  module.doc() = "The compiled part of weft.";
  py::register_local_exception_translator(&translate);  // exceptions of other modules are theirs
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
  weft::python::add_recordings(module);
}
