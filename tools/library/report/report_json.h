// report.json: everything about a run, for programs. Its shape is named by "schema".
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "meshing/metric/measures.h"
#include "tools/library/jobs/run_result.h"

namespace weft::tools {

nlohmann::ordered_json json_of(const meshing::Measures& measures);

/// Schema "weft-report-1".
nlohmann::ordered_json json_of(const RunResult& run);

/// As a document's text. Bytes of names that are no UTF-8 are replaced: a file's name may have any.
std::string text_of(const nlohmann::ordered_json& document, int indent = -1);

}  // namespace weft::tools
