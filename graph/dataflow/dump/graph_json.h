// Graph dumps as JSON, schema "weft-graph-1": described with an example in README.md, and formally in
// graph/weft-graph-1.schema.json.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "graph/dataflow/dump/graph_dump.h"

namespace weft::graph::dataflow {

nlohmann::ordered_json json_of(const GraphDump& dump);

/// The opposite. Throws std::invalid_argument, naming the member, for what is no such document: another
/// schema, missing members, columns of different lengths, indices out of range, runs that end before they
/// begin, values that were sent outside their run.
GraphDump dump_from_json(const nlohmann::ordered_json& json);

}  // namespace weft::graph::dataflow
