// Passes a body's wishes on to its instance.
#include "graph/dataflow/node_context.h"

#include "graph/dataflow/instance_core.h"

namespace weft::graph::dataflow {

void NodeContext::count(std::string_view name, double amount) { instance_.count(name, amount); }

void NodeContext::send_packed(const void* event, engine::ObjectId target, std::uint64_t round,
                              engine::Payload value) {
  instance_.send(engine_, node_, event, target, round, std::move(value));
}

void NodeContext::declare(const void* event, std::uint64_t round, std::vector<engine::ObjectId> from,
                          engine::Seconds seconds) {
  instance_.declare(engine_, event, round, std::move(from), seconds);
}

}  // namespace weft::graph::dataflow
