// Recorded runs: their replays, task graphs and pages.
#include <pybind11/stl.h>

#include "tools/bindings/python/src/parts.h"
#include "tools/bindings/python/src/texts.h"
#include "weft/replay.h"

namespace weft::python {
namespace {

std::uint64_t count_of(std::int64_t value, const char* option) {
  if (value < 0) throw OptionError(option, std::to_string(value) + " is less than 0");
  return static_cast<std::uint64_t>(value);
}

std::optional<std::uint64_t> count_of(const std::optional<std::int64_t>& value, const char* option) {
  return value ? std::optional(count_of(*value, option)) : std::nullopt;
}

/// The account: a text for people, one for programs.
py::tuple run_replay(const std::string& graph, int ranks, int threads, const std::string& network,
                     const std::string& balancer, double slowdown, bool processor_times, int copies,
                     int split, double grow, std::int64_t subdomain_bytes, const std::string& report,
                     const std::string& account, const std::string& trace) {
  const ReplayOptions options{.ranks = ranks,
                              .threads = threads,
                              .network = network,
                              .balancer = balancer,
                              .slowdown = slowdown,
                              .processor_times = processor_times,
                              .copies = copies,
                              .split = split,
                              .grow = grow,
                              .subdomain_bytes = count_of(subdomain_bytes, "--subdomain-bytes"),
                              .report = report,
                              .account = account,
                              .trace = trace};
  ReplayResult result;
  {
    const py::gil_scoped_release released;
    result = replay(graph, options);
  }
  return py::make_tuple(message_text(summary(result)), message_text(result.json));
}

py::str run_task_graph(const std::string& path, const std::string& format,
                       const std::optional<std::int64_t>& round, const std::optional<std::int64_t>& subdomain,
                       const std::string& collapse, bool critical_path, bool plan) {
  const GraphFilter filter{count_of(round, "--round"), count_of(subdomain, "--subdomain"), collapse,
                           critical_path, plan};
  std::string text;
  {
    const py::gil_scoped_release released;
    text = graph_text(path, format, filter);
  }
  return message_text(text);
}

void run_report_page(const std::string& profile, const std::string& page) {
  const py::gil_scoped_release released;
  write_report_page(profile, page);
}

py::str run_compare_reports(const std::string& a, const std::string& b, const std::string& page) {
  std::string text;
  {
    const py::gil_scoped_release released;
    text = compare_reports(a, b, page);
  }
  return message_text(text);
}

}  // namespace

void add_recordings(py::module_& module) {
  module.def("replay", &run_replay);
  module.def("task_graph", &run_task_graph);
  module.def("report_page", &run_report_page);
  module.def("compare_reports", &run_compare_reports);
}

}  // namespace weft::python
