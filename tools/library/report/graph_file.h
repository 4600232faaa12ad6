// A recorded graph, from whatever file holds one.
#pragma once

#include <stdexcept>
#include <string>

#include "engine/json/json.h"
#include "graph/dataflow/dump/graph_dump.h"
#include "meshing/base/error.h"

namespace weft::tools {

/// call(); what it has against a document is said with the file's name.
template <class Call>
auto naming_document(const std::string& file, const Call& call) {
  try {
    return call();
  } catch (const std::invalid_argument& error) {
    throw meshing::InputError(file, "", error.what());
  } catch (const nlohmann::json::exception& error) {
    throw meshing::InputError(file, "", error.what());
  }
}

/// From a graph.json or the graph in a profile.json. Throws InputError, also where that profile has a part of
/// it. `profile`: becomes the profile without its graph, null for a graph.json.
graph::dataflow::GraphDump read_graph(const std::string& path, nlohmann::ordered_json* profile = nullptr);

}  // namespace weft::tools
