// The engine's benchmarks: each is run by all ranks and returns its figures at rank 0, elsewhere null.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "engine/network/transport.h"

namespace weft::bench {

using nlohmann::ordered_json;

/// Handler-to-handler ping-pong of two ranks, and of two objects of one rank.
ordered_json latency(engine::Transport& transport);

/// Tiny handlers handled a second by a rank, called by the rank itself and by the other one (2 ranks).
ordered_json rate(engine::Transport& transport);

/// Objects of several sizes that move back and forth (2 ranks).
ordered_json migration(engine::Transport& transport);

/// Objects with heavy-tailed costs that grow and shrink, all on rank 0 at first, under a policy.
ordered_json balance(engine::Transport& transport, const std::string& policy);

/// What keeping spans costs tasks of 1 ms.
ordered_json trace(engine::Transport& transport);

/// CPU that ranks use while they wait for rank 0, which sleeps in a handler.
ordered_json idle(engine::Transport& transport);

}  // namespace weft::bench
