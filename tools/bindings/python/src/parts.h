// The pieces that the module is made of, and what they share.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "weft/weft.h"

namespace weft::python {

namespace py = pybind11;

void add_objects(py::module_& module);
void add_runs(py::module_& module);
void add_functions(py::module_& module);
void add_files(py::module_& module);
void add_recordings(py::module_& module);

/// What any thread may ask of a run: to end early, to write a checkpoint.
struct Cancel {
  std::atomic<bool> wanted = false, checkpoint = false;
};

/// Options of a dictionary by the names of the command.
Options options_of(const py::dict& values);

/// Looks after a run that goes on without Python's lock: passes progress on, hears Ctrl-C, and cancels. What
/// a callback raises ends the run and is raised again when it is over.
class Watch {
 public:
  Watch(const py::object& progress, const std::shared_ptr<Cancel>& cancel, Options& options);
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  // After the run, with Python's lock.

  /// Raises what has been raised meanwhile, if anything.
  void raise() const;
  /// Whether that was Ctrl-C.
  bool interrupted() const;

 private:
  bool tell(const Progress& now);
  py::object progress_;
  std::shared_ptr<Cancel> cancel_;
  std::exception_ptr raised_;
};

}  // namespace weft::python
