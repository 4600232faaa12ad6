#include "tools/library/jobs/file_outputs.h"

#include <filesystem>
#include <vector>

#include "tools/common/inputs.h"
#include "tools/library/jobs/resources/threads.h"
#include "tools/library/jobs/sources/metric_source.h"
#include "tools/library/report/run_record.h"

namespace weft::tools {

namespace fs = std::filesystem;

RunResult begin_run(const Files& files, const Options& options) {
  RunResult run;
  run.arguments = files.arguments;
  run.input = files.input;
  run.metric_name = name_of(options.metric);
  run.outputs = output_paths(files.output);
  run.threads = number_of_threads(options.run.threads);
  if (!files.report.empty()) run.report_path = (fs::path(files.report) / "report.json").string();
  return run;
}

namespace {

/// Where --graph names the graph.json of the report, both are the same graph.
std::vector<OutputFile> outputs_of(const Files& files, const OutputPaths& outputs) {
  std::vector<OutputFile> all = {{"--out", outputs.mesh}};
  const bool beside = outputs.solution != outputs.mesh;
  if (beside) all.push_back({"--out", outputs.solution});
  if (beside && !files.fields.empty()) all.push_back({"--out", outputs.fields});
  if (!files.report.empty())
    for (const char* name : {"report.json", "profile.json", "report.html", "graph.json"})
      all.push_back({"--report", (fs::path(files.report) / name).string()});
  const std::string recorded = files.report.empty() ? "" : all.back().path;
  if (!files.graph.empty()) {
    if (place_of(files.graph) != place_of(recorded)) all.push_back({"--graph", files.graph});
    all.push_back({"--graph", planned_path(files.graph)});
  }
  all.push_back({"--trace", files.trace});
  return all;
}

}  // namespace

void check_outputs(const Files& files, const Options& options, const OutputPaths& outputs) {
  keep_apart(outputs_of(files, outputs));
  std::vector<std::string> inputs = files_of(options.metric);
  inputs.insert(inputs.end(), files.fields.begin(), files.fields.end());
  inputs.insert(inputs.end(), {files.input, files.background, options.geometry.model});
  keep_inputs(files.graph, "it", inputs, "--graph");
  keep_inputs(files.trace, "it", inputs, "--trace");
  if (!same_file(files.output, files.input)) {
    keep_inputs(outputs.mesh, "it", inputs);
    keep_inputs(outputs.solution, "its metric " + outputs.solution, inputs);
    if (!files.fields.empty()) keep_inputs(outputs.fields, "its fields " + outputs.fields, inputs);
  }
  check_writable(outputs.mesh);
  check_writable(outputs.solution);
  if (!files.fields.empty()) check_writable(outputs.fields);
  if (!options.checkpoint.folder.empty()) {
    make_folder(options.checkpoint.folder);
    check_writable((fs::path(options.checkpoint.folder) / "probe").string());
  }
  if (!files.report.empty()) {
    make_folder(files.report);
    check_writable((fs::path(files.report) / "report.json").string());
  }
  // Perhaps in the folder of the report.
  for (const std::string& path : {files.graph, files.trace})
    if (!path.empty()) check_writable(path);
  if (!files.graph.empty()) check_writable(planned_path(files.graph));
}

FilesResult files_result(const RunResult& run, const std::string& report_error, bool first) {
  FilesResult result;
  static_cast<Report&>(result) = run;
  result.input = run.input;
  result.metric_name = run.metric_name;
  result.mesh = run.outputs.mesh;
  result.metric = run.outputs.solution;
  if (!run.field_accounts.empty()) result.fields = run.outputs.fields;
  if (report_error.empty()) result.report = run.report_path;
  result.report_error = report_error;
  result.first = first;
  return result;
}

}  // namespace weft::tools
