// What runs from files have in common: the beginning and the end of their account, and checks of what they
// will write.
#pragma once

#include <string>
#include <vector>

#include "tools/library/jobs/run_result.h"
#include "weft/weft.h"

namespace weft::tools {

bool same_file(const std::string& a, const std::string& b);

/// Throws OptionError where `output`, called `name`, is one of the inputs.
void keep_inputs(const std::string& output, const std::string& name, const std::vector<std::string>& inputs);

/// What is known of a run before it starts.
RunResult begin_run(const Files& files, const Options& options);

/// Hours of work must not end with "no such folder". Makes the folder of the report. Throws InputError, and
/// OptionError where the result would replace an input other than the mesh.
void check_outputs(const Files& files, const Options& options, const OutputPaths& outputs);

FilesResult files_result(const RunResult& run, const std::string& report_error, bool first = true);

}  // namespace weft::tools
