// Adaptation: of one mesh, of files, of a mesh in parts; initial meshes; and what runs tell of themselves.
#include <malloc.h>
#include <pybind11/stl.h>

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <utility>

#include "tools/bindings/python/src/arrays.h"
#include "tools/bindings/python/src/parts.h"
#include "tools/bindings/python/src/texts.h"
#include "weft/replay.h"

namespace weft::python {
namespace {

/// Ctrl-C ends the run, and the caller gets the mesh all the same: as the member `result` of the exception.
[[noreturn]] void raise_interrupted(const py::object& result) {
  const py::object type = py::module_::import("weft._errors").attr("Interrupted");
  const py::object error = type("interrupted; the exception's result has a valid mesh");
  error.attr("result") = result;
  PyErr_SetObject(type.ptr(), error.ptr());
  throw py::error_already_set();
}

/// While one lives, freed arrays go back to the system at once, as in the command (its main.cpp says why),
/// and what the caller has freed before. glibc's thresholds cannot be read: afterwards they are the largest
/// that it comes to by itself in a process that has freed large arrays, so that NumPy keeps its own. Whoever
/// sets them in the environment is left alone.
class FreedArraysGoBack {
 public:
  FreedArraysGoBack() {
    if (running()++ == 0) set(1 << 23, 1 << 24);
  }
  ~FreedArraysGoBack() {
    if (--running() == 0) set(32 << 20, 64 << 20);
  }
  FreedArraysGoBack(const FreedArraysGoBack&) = delete;
  FreedArraysGoBack& operator=(const FreedArraysGoBack&) = delete;

 private:
  /// Runs in all threads.
  static std::atomic<int>& running() {
    static std::atomic<int> count = 0;
    return count;
  }
  static void set([[maybe_unused]] int map, [[maybe_unused]] int trim) {
#ifdef __GLIBC__
    if (std::getenv("MALLOC_MMAP_THRESHOLD_") || std::getenv("MALLOC_TRIM_THRESHOLD_")) return;
    mallopt(M_MMAP_THRESHOLD, map);
    mallopt(M_TRIM_THRESHOLD, trim);
    malloc_trim(0);
#endif
  }
};

/// Runs call() without Python's lock, under watch, and wraps what it returns. Where there is nothing, what a
/// callback has raised says more than the error that the end has led to.
template <class Call>
py::object watched(Options& options, const py::object& progress, const std::shared_ptr<Cancel>& cancel,
                   const Call& call) {
  const Watch watch(progress, cancel, options);
  std::shared_ptr<decltype(call())> result;
  try {
    const py::gil_scoped_release released;
    const FreedArraysGoBack thresholds;
    result = std::make_shared<decltype(call())>(call());
  } catch (...) {
    watch.raise();
    throw;
  }
  py::object wrapped = py::cast(std::move(result));
  if (watch.interrupted()) raise_interrupted(wrapped);
  watch.raise();
  return wrapped;
}

void check_that_a_metric_is_given(const std::shared_ptr<Metric>& metric, const Options& options) {
  if (!metric && !options.metric.given())
    throw OptionError("--metric",
                      "no metric: give one, solutions, or an option that makes one (metric_fn, "
                      "implied, curvature, ...)");
}

py::object run_adapt(const Mesh& mesh, const std::shared_ptr<Metric>& metric, const py::dict& values,
                     const py::object& fields, const py::object& solutions,
                     const std::optional<std::string>& order, const std::shared_ptr<Mesh>& background,
                     const py::object& progress, const std::shared_ptr<Cancel>& cancel) {
  Options options = options_of(values);
  const Fields carried = fields_of(fields, mesh.points.size(), order);
  const Mesh& of_metric = background ? *background : mesh;
  if (!solutions.is_none())
    options.metric.solutions = {fields_of(solutions, of_metric.points.size(), order, "solutions")};
  check_that_a_metric_is_given(metric, options);
  return watched(options, progress, cancel, [&] {
    if (background && metric) return adapt(mesh, *background, *metric, options, carried);
    if (background) return adapt(mesh, *background, options, carried);
    return metric ? adapt(mesh, *metric, options, carried) : adapt(mesh, options, carried);
  });
}

/// MPI's own errors abort, so what is wrong with a communicator is found out before.
MPI_Comm communicator_of(int handle) {
  int running = 0;
  MPI_Initialized(&running);
  if (!running) throw UsageError("comm: MPI has not been initialised; import mpi4py.MPI first");
  MPI_Finalized(&running);
  if (running) throw UsageError("comm: MPI has been finalised");
  const MPI_Comm communicator = MPI_Comm_f2c(handle);
  if (communicator == MPI_COMM_NULL) throw UsageError("comm: is MPI.COMM_NULL");
  return communicator;
}

/// What a rank has prepared for an adaptation in parts: made and checked before any rank waits for another.
struct PreparedPart {
  Part part;
  std::optional<Part> background;  ///< that the metric belongs to, where it is not `part`
  std::shared_ptr<Metric> metric;
  Options options;
};

/// A mesh, which is taken if nobody else has it, and the numbers of its points and tets; `prefix` stands
/// before the names of these two arrays.
Part part_of(Mesh& mesh, bool take, const py::object& ids, const py::object& tet_ids,
             const std::string& prefix) {
  const std::string name = prefix + "ids", tets = prefix + "tet_ids";
  if (ids.is_none() && !mesh.points.empty()) throw UsageError(name + ": are needed with comm");
  Part part;
  part.ids = ids_of(ids, mesh.points.size(), name.c_str());
  part.tet_ids = ids_of(tet_ids, mesh.tets.size(), tets.c_str());
  part.mesh = take ? std::move(mesh) : mesh;
  return part;
}

/// `order` is that of the fields' tensors; `take`, `take_background`: the meshes have been made for this
/// call.
std::shared_ptr<PreparedPart> prepare_part(
    const std::shared_ptr<Mesh>& mesh, const std::shared_ptr<Metric>& metric, const py::object& ids,
    const py::object& tet_ids, const std::shared_ptr<Mesh>& background, const py::object& background_ids,
    const py::object& background_tet_ids, const py::dict& values, const py::object& fields,
    const py::object& solutions, const std::optional<std::string>& order, bool take, bool take_background) {
  auto prepared = std::make_shared<PreparedPart>();
  prepared->options = options_of(values);
  const Mesh& of_metric = background ? *background : *mesh;
  if (!solutions.is_none())
    prepared->options.metric.solutions = {fields_of(solutions, of_metric.points.size(), order, "solutions")};
  check_that_a_metric_is_given(metric, prepared->options);
  validate(prepared->options);
  Fields carried = fields_of(fields, mesh->points.size(), order);
  prepared->part = part_of(*mesh, take, ids, tet_ids, "");
  prepared->part.fields = std::move(carried);
  if (background)
    prepared->background =
        part_of(*background, take_background, background_ids, background_tet_ids, "background_");
  prepared->metric = metric;
  return prepared;
}

PartResult adapt_part(MPI_Comm communicator, const PreparedPart& p) {
  if (p.background)
    return p.metric ? adapt(communicator, p.part, *p.background, *p.metric, p.options)
                    : adapt(communicator, p.part, *p.background, p.options);
  return p.metric ? adapt(communicator, p.part, *p.metric, p.options)
                  : adapt(communicator, p.part, p.options);
}

py::object run_adapt_prepared(int comm, PreparedPart& prepared, const py::object& progress,
                              const std::shared_ptr<Cancel>& cancel) {
  const MPI_Comm communicator = communicator_of(comm);
  return watched(prepared.options, progress, cancel, [&] { return adapt_part(communicator, prepared); });
}

std::pair<int, py::str> run_first_error(int comm, const std::string& issue) {
  const MPI_Comm communicator = communicator_of(comm);
  RankError first;
  {
    const py::gil_scoped_release released;
    first = first_error(communicator, issue);
  }
  return {first.rank, message_text(first.text)};
}

/// `texts`: the members of Files that name one file each, by the names of Python.
Files files_of(const py::dict& texts, const std::vector<std::string>& fields, bool page) {
  const auto text = [&](const char* name) { return texts[name].cast<std::string>(); };
  Files files;
  files.input = text("input");
  files.output = text("output");
  files.background = text("background");
  files.report = text("report");
  files.case_name = text("case");
  files.graph = text("graph");
  files.trace = text("trace");
  files.fields = fields;
  files.page = page;
  return files;
}

/// `ranks`: 0: no ranks are simulated.
py::object run_adapt_files(const py::dict& texts, const std::vector<std::string>& fields, bool page,
                           const py::dict& values, int ranks, const std::string& network, double slowdown,
                           int cores, const py::object& progress, const std::shared_ptr<Cancel>& cancel) {
  Options options = options_of(values);
  const Files files = files_of(texts, fields, page);
  if (ranks == 0) return watched(options, progress, cancel, [&] { return adapt_files(files, options); });
  const SimulatedRanks simulated{ranks, network, slowdown, cores};
  return watched(options, progress, cancel, [&] { return adapt_files_on(simulated, files, options); });
}

py::object run_fill(const Mesh& surface, double growth, double size, double merge, bool materials,
                    bool remesh_surface, const std::shared_ptr<Mesh>& background,
                    const std::shared_ptr<Metric>& metric, const py::dict& values, const py::object& progress,
                    const std::shared_ptr<Cancel>& cancel) {
  Options options = options_of(values);
  FillOptions fill_options;
  fill_options.growth = growth;
  fill_options.size = size;
  fill_options.merge = merge;
  fill_options.materials = materials;
  fill_options.remesh_surface = remesh_surface;
  fill_options.background = background.get();
  fill_options.metric = metric.get();
  return watched(options, progress, cancel, [&] {
    fill_options.geometry = options.geometry;
    fill_options.run = options.run;
    return fill(surface, fill_options);
  });
}

/// A member of a result as an object that keeps the result.
template <class Owner, class Member>
std::shared_ptr<Member> member(const std::shared_ptr<Owner>& owner, Member& of) {
  return {owner, &of};
}

/// A result with its measures: those that its run has left out, because it was ended early or told not to
/// measure, are taken now, while other threads of Python work.
const Result& measured(Result& result) {
  static std::mutex mutex;
  const py::gil_scoped_release released;
  const std::lock_guard lock(mutex);
  measures(result);
  return result;
}

auto path_of(std::string FilesResult::*member) {
  return [member](const FilesResult& result) { return name_text(result.*member); };
}

void add_reports(py::module_& module) {
  py::class_<Report, std::shared_ptr<Report>>(module, "Report", "What is known after an adaptation.")
      .def_property_readonly("goal_met", &Report::goal_met,
                             "Whether the mesh is known to be what was asked for.")
      .def_property_readonly(
          "missed", [](const Report& report) { return message_texts(report.missed); },
          "Why it is not; empty when it is, or was not measured.")
      .def_readonly("cancelled", &Report::cancelled, "Whether the run was ended early.")
      .def_property_readonly("warnings", [](const Report& report) { return message_texts(report.warnings); })
      .def_property_readonly(
          "mends", [](const Report& report) { return mends_text(report.mends); },
          "What repair has done to the input, a line each.")
      .def(
          "summary", [](const Report& report) { return message_text(summary(report)); },
          "What the command prints.")
      .def(
          "json", [](const Report& report) { return to_json(report); }, "JSON of schema weft-report-1.");
  py::class_<Result, Report, std::shared_ptr<Result>>(module, "Result", "A mesh that has been adapted.")
      .def_property_readonly(
          "goal_met", [](Result& r) { return !r.cancelled && measured(r).goal_met(); },
          "Whether the mesh is what was asked for. Measures it where that has not been done.")
      .def_property_readonly(
          "missed", [](Result& r) { return message_texts(measured(r).missed); },
          "Why it is not; empty when it is. Measures it where that has not been done.")
      .def(
          "summary", [](Result& r) { return message_text(summary(measured(r))); },
          "What the command prints. Measures the mesh where that has not been done.")
      .def(
          "json", [](Result& r) { return to_json(measured(r)); },
          "JSON of schema weft-report-1. Measures the mesh where that has not been done.")
      .def_property_readonly(
          "mesh", [](const std::shared_ptr<Result>& r) { return member(r, r->mesh); }, "weft.Mesh.")
      .def_property_readonly(
          "metric", [](const std::shared_ptr<Result>& r) { return member(r, r->metric); },
          "weft.Metric, at the vertices of the mesh.")
      .def_property_readonly(
          "fields",
          [](const py::object& self) { return dictionary_of(self.cast<const Result&>().fields, self); },
          "Those carried along, by name, at the vertices of the mesh.");
  py::class_<PartResult, Report, std::shared_ptr<PartResult>>(
      module, "PartResult", "This rank's part of a mesh that has been adapted.")
      .def_property_readonly(
          "mesh", [](const std::shared_ptr<PartResult>& r) { return member(r, r->part.mesh); },
          "weft.Mesh; ghosts come last.")
      .def_property_readonly(
          "metric", [](const std::shared_ptr<PartResult>& r) { return member(r, r->metric); },
          "weft.Metric, at the points of the part.")
      .def_property_readonly(
          "fields",
          [](const py::object& self) {
            return dictionary_of(self.cast<const PartResult&>().part.fields, self);
          },
          "Those carried along, by name, at the points of the part.")
      .def_property_readonly(
          "ids",
          [](const py::object& self) {
            const auto& ids = self.cast<const PartResult&>().part.ids;
            return view(reinterpret_cast<const std::int64_t*>(ids.data()),
                        {static_cast<py::ssize_t>(ids.size())}, self);
          },
          "(n,) int64: global numbers of the points, from 0 without gaps.")
      .def_property_readonly(
          "owners",
          [](const py::object& self) {
            const auto& owners = self.cast<const PartResult&>().part.owners;
            return view(owners.data(), {static_cast<py::ssize_t>(owners.size())}, self);
          },
          "(n,) int32: the rank that owns each point.")
      .def_property_readonly(
          "ghost_owners",
          [](const py::object& self) {
            const auto& owners = self.cast<const PartResult&>().part.ghost_owners;
            return view(owners.data(), {static_cast<py::ssize_t>(owners.size())}, self);
          },
          "(g,) int32: of the ghost tets, the rank that has each.")
      .def_property_readonly(
          "num_own_tets", [](const PartResult& r) { return r.part.num_own_tets; },
          "Tets from this one on are ghosts.");
  py::class_<FilesResult, Report, std::shared_ptr<FilesResult>>(module, "FilesResult",
                                                                "What has been written.")
      .def_property_readonly("mesh", path_of(&FilesResult::mesh))
      .def_property_readonly("metric", path_of(&FilesResult::metric))
      .def_property_readonly("fields", path_of(&FilesResult::fields))
      .def_property_readonly("report", path_of(&FilesResult::report), "report.json; empty: none.")
      .def_property_readonly(
          "report_error", [](const FilesResult& result) { return message_text(result.report_error); },
          "What could not be written beside the mesh, and why; there is no report then.")
      .def("summary", [](const FilesResult& result) { return message_text(summary(result)); });
  py::class_<SimulatedFilesResult, FilesResult, std::shared_ptr<SimulatedFilesResult>>(
      module, "SimulatedFilesResult", "What has been written, and times of virtual clocks.")
      .def_readonly("seconds", &SimulatedFilesResult::seconds, "Virtual, until the last rank has ended.")
      .def_readonly("simulation_seconds", &SimulatedFilesResult::simulation_seconds, "That it took here.")
      .def("summary", [](const SimulatedFilesResult& result) { return message_text(summary(result)); });
  py::class_<FillResult, std::shared_ptr<FillResult>>(module, "FillResult", "A mesh that fills a surface.")
      .def_property_readonly("mesh", [](const std::shared_ptr<FillResult>& r) { return member(r, r->mesh); })
      .def_property_readonly(
          "metric", [](const std::shared_ptr<FillResult>& r) { return member(r, r->metric); },
          "The metric that it was made for.")
      .def_readonly("regions", &FillResult::regions)
      .def_property_readonly("warnings", [](const FillResult& r) { return message_texts(r.warnings); })
      .def_property_readonly(
          "mends", [](const FillResult& r) { return mends_text(r.mends); },
          "What repair has done to the surface, a line each.")
      .def_readonly("deviation", &FillResult::deviation,
                    "Of repair: largest distance of the mended surface from the one given.")
      .def_property_readonly(
          "missed", [](const FillResult& r) { return message_texts(r.missed); },
          "Where it lies on the CAD model worse than the surface did; empty: nowhere.")
      .def_readonly("cancelled", &FillResult::cancelled)
      .def_readonly("ended_by", &FillResult::ended_by);
}

bool is_text(const py::handle& value) {
  return py::isinstance<py::str>(value) || py::isinstance<py::bytes>(value);
}

/// Not an array of no dimensions.
bool is_list(const py::handle& value) {
  if (is_text(value) || PySequence_Check(value.ptr()) == 0) return false;
  const bool has_length = PySequence_Size(value.ptr()) >= 0;
  if (!has_length) PyErr_Clear();
  return has_length;
}

/// What C would read the start of is no text.
std::string whole_text(const py::handle& value) {
  const std::string text = py::isinstance<py::str>(value) ? bytes_of_name(value) : value.cast<std::string>();
  if (text.find('\0') != std::string::npos) throw py::cast_error();
  return text;
}

std::string text_of(const std::string& name, const py::handle& value) {
  try {
    if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "yes" : "no";
    if (is_text(value)) return whole_text(value);
    if (py::hasattr(value, "__fspath__")) return whole_text(py::module_::import("os").attr("fspath")(value));
    if (py::hasattr(value, "__index__")) return py::str(py::module_::import("operator").attr("index")(value));
    if (PyNumber_Check(value.ptr())) return py::repr(py::float_(py::reinterpret_borrow<py::object>(value)));
  } catch (const py::cast_error&) {
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
  }
  throw UsageError(name + ": is a " + std::string(py::str(py::type::of(value).attr("__name__"))) +
                   ", neither a number nor a text");
}

}  // namespace

Options options_of(const py::dict& values) {
  Options options;
  for (const auto& [key, value] : values) {
    const std::string name = py::str(key);
    if (value.is_none()) continue;
    const bool several = is_list(value);
    if (several && name == "sol") {
      for (const py::handle one : value) set_option(options, name, text_of(name, one));
    } else if (several) {
      std::string joined;
      for (const py::handle one : value) joined += (joined.empty() ? "" : ",") + text_of(name, one);
      set_option(options, name, joined);
    } else {
      set_option(options, name, text_of(name, value));
    }
  }
  return options;
}

Watch::Watch(const py::object& progress, const std::shared_ptr<Cancel>& cancel, Options& options)
    : progress_(progress), cancel_(cancel ? cancel : std::make_shared<Cancel>()) {
  options.run.cancel = &cancel_->wanted;
  options.checkpoint.now = &cancel_->checkpoint;
  options.run.progress = [this](const Progress& now) { return tell(now); };
}

bool Watch::tell(const Progress& now) {
  const py::gil_scoped_acquire locked;
  if (raised_) return false;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress_.is_none()) return true;
    const py::object go_on = progress_(now.stage, now.done, now.tets);
    return !(py::isinstance<py::bool_>(go_on) && !go_on.cast<bool>());
  } catch (...) {
    raised_ = std::current_exception();
    return false;
  }
}

void Watch::raise() const {
  if (raised_) std::rethrow_exception(raised_);
}

bool Watch::interrupted() const {
  try {
    raise();
  } catch (const py::error_already_set& error) {
    return error.matches(PyExc_KeyboardInterrupt);
  } catch (...) {
  }
  return false;
}

void add_runs(py::module_& module) {
  add_reports(module);
  py::class_<Cancel, std::shared_ptr<Cancel>>(
      module, "Cancel",
      "A wish to end a run early, which any thread may utter; the run then returns a valid mesh.")
      .def(py::init<>())
      .def("cancel", [](Cancel& self) { self.wanted = true; })
      .def(
          "checkpoint", [](Cancel& self) { self.checkpoint = true; },
          "Asks for a checkpoint now instead (the option checkpoint names its folder).")
      .def(
          "reset", [](Cancel& self) { self.wanted = false; }, "Before the object serves another run.")
      .def_property_readonly("wanted", [](const Cancel& self) { return self.wanted.load(); });
  // NOLINTNEXTLINE(bugprone-unused-raii)
  py::class_<PreparedPart, std::shared_ptr<PreparedPart>>(module, "_PreparedPart");
  module.def("adapt", &run_adapt);
  module.def("prepare_part", &prepare_part);
  module.def("adapt_prepared", &run_adapt_prepared);
  module.def("first_error", &run_first_error);
  module.def("adapt_files", &run_adapt_files);
  module.def("fill", &run_fill);
}

}  // namespace weft::python
