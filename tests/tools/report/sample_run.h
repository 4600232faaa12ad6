// A whole run for the report's tests: the protocol is simulated, the mesh is a small one that has been
// adapted.
#pragma once

#include "engine/json/json.h"
#include "graph/dataflow/dump/graph_dump.h"
#include "tests/support/simulated_run.h"
#include "tools/library/jobs/run_result.h"

namespace weft::testing {

struct SampleRun {
  SimulatedRun simulated;
  graph::dataflow::GraphDump graph;
  engine::TimePoint start = 0;  ///< what the graph's times count from
  nlohmann::ordered_json profile;
};

/// `cells`: of the box, along each axis.
SampleRun sample_run(const SimulationRules& rules, std::uint32_t cells);

}  // namespace weft::testing
