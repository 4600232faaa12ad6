// Everything that the report shows, as one JSON document of schema "weft-profile-1": see
// tools/report/README.md and tools/report/weft-profile-1.schema.json.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/trace/chrome_trace.h"
#include "engine/trace/summary.h"
#include "graph/dataflow/dump/graph_dump.h"
#include "meshing/base/box.h"
#include "tools/report/hardware.h"
#include "tools/report/mesh_view.h"

namespace weft::report {

/// How much memory a rank had in use.
struct MemorySamples {
  int rank = 0;
  std::vector<double> seconds;       ///< since the run's start, ascending
  std::vector<std::uint64_t> bytes;  ///< as many

  template <class Archive>
  void serialize(Archive& archive) {
    archive(rank, seconds, bytes);
  }
};

struct ProfileOptions {
  std::size_t most_runs = 200'000;  ///< of the executed graph; a larger one is left out
  std::size_t most_uses = 150'000;  ///< more, and those off the critical path are left out, smallest first
  std::size_t most_waits = 100;     ///< pairs of subdomains
};

/// What a profile is made from; what is empty or null was not recorded.
struct ProfileInput {
  const nlohmann::ordered_json&
      report;  ///< of schema "weft-report-1"; null: of a simulated run, which made no mesh
  const nlohmann::ordered_json* simulation = nullptr;  ///< of a replay: what it says of itself
  std::string case_name = {};                          ///< the user's; see published.h
  const engine::RunSummary* engine = nullptr;          ///< of the adaptation
  const graph::dataflow::GraphDump* graph = nullptr;   ///< executed
  std::vector<engine::RankTimeline> timelines = {};    ///< of the ranks to show; none: all
  engine::TimePoint start = 0;  ///< what the graph's times count from, on rank 0's clock
  std::vector<Hardware> hardware = {};
  std::vector<MemorySamples> memory = {};
  MeshView mesh = {};
  meshing::Box box = {};  ///< of the mesh
};

nlohmann::ordered_json profile_json(const ProfileInput& input, const ProfileOptions& options = {});

}  // namespace weft::report
