// Bytes as payloads and back.
#include "graph/adaptation/engine_peers.h"

#include <utility>

#include "engine/base/blob_pool.h"
#include "engine/base/serialize.h"

namespace weft::graph::adaptation {

namespace {

engine::Payload to_payload(partition::Bytes bytes) {
  engine::Packer packer(true);
  packer(bytes);
  return packer.take();
}

partition::Bytes to_bytes(engine::Payload payload) {
  partition::Bytes bytes;
  engine::Unpacker unpacker(std::move(payload));
  unpacker(bytes);
  unpacker.finish();
  return bytes;
}

}  // namespace

std::vector<partition::Bytes> EnginePeers::all_to_all(std::vector<partition::Bytes> to_each) {
  const auto mine = static_cast<std::size_t>(rank());
  std::vector<engine::Payload> payloads(to_each.size());
  for (std::size_t to = 0; to < to_each.size(); ++to) {
    if (to == mine || to_each[to].empty()) continue;
    payloads[to] = to_payload(std::move(to_each[to]));
  }
  payloads = exchange_.exchange(std::move(payloads));
  std::vector<partition::Bytes> received(payloads.size());
  for (std::size_t from = 0; from < received.size(); ++from) {
    if (from == mine || payloads[from].size() == 0) continue;
    received[from] = to_bytes(std::move(payloads[from]));
  }
  received[mine] = std::move(to_each[mine]);
  engine::give_back_freed_blobs();  // the next exchange is of something else
  return received;
}

std::vector<partition::Bytes> EnginePeers::allgather(partition::Bytes mine) {
  return exchange_.allgather(std::move(mine));
}

partition::Bytes EnginePeers::allgather_joined(partition::Bytes mine) {
  return exchange_.allgather_joined(std::move(mine));
}

partition::Bytes EnginePeers::reduce(partition::Bytes mine, const Combine& combine) {
  return exchange_.reduce(std::move(mine), combine);
}

}  // namespace weft::graph::adaptation
