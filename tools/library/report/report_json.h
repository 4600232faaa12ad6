// report.json: everything about a run, for programs. Its shape is named by "schema".
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "meshing/metric/measures.h"
#include "tools/library/jobs/run_result.h"

namespace weft::tools {

nlohmann::ordered_json json_of(const meshing::Measures& measures);

/// Schema "weft-report-1".
nlohmann::ordered_json json_of(const RunResult& run);

}  // namespace weft::tools
