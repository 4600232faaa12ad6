// What runs from files have in common: the beginning and the end of their account, and checks of what they
// will write.
#pragma once

#include <string>

#include "tools/common/inputs.h"
#include "tools/library/jobs/run_result.h"
#include "weft/weft.h"

namespace weft::tools {

/// What is known of a run before it starts.
RunResult begin_run(const Files& files, const Options& options);

/// Hours of work must not end with "no such folder". Makes the folder of the report. Throws InputError, and
/// OptionError where the result would replace an input other than the mesh, or a trace any, and where two
/// outputs are one file.
void check_outputs(const Files& files, const Options& options, const OutputPaths& outputs);

FilesResult files_result(const RunResult& run, const std::string& report_error, bool first = true);

}  // namespace weft::tools
