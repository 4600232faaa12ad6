// Bytes as payloads and back.
#include "graph/adaptation/engine_peers.h"

#include <utility>

#include "engine/base/serialize.h"

namespace weft::graph::adaptation {

std::vector<partition::Bytes> EnginePeers::all_to_all(std::vector<partition::Bytes> to_each) {
  const auto mine = static_cast<std::size_t>(rank());
  std::vector<engine::Payload> payloads(to_each.size());
  for (std::size_t to = 0; to < to_each.size(); ++to) {
    if (to == mine || to_each[to].empty()) continue;
    engine::Packer packer(true);
    packer(to_each[to]);
    payloads[to] = packer.take();
  }
  payloads = exchange_.exchange(std::move(payloads));
  std::vector<partition::Bytes> received(payloads.size());
  for (std::size_t from = 0; from < received.size(); ++from) {
    if (from == mine || payloads[from].size() == 0) continue;
    engine::Unpacker unpacker(std::move(payloads[from]));
    unpacker(received[from]);
    unpacker.finish();
  }
  received[mine] = std::move(to_each[mine]);
  return received;
}

}  // namespace weft::graph::adaptation
