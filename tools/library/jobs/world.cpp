#include "tools/library/jobs/world.h"

#include <stdexcept>

#include "engine/run/runtime.h"
#include "graph/adaptation/engine_peers.h"
#include "meshing/base/error.h"
#include "partition/verify/check_subdomains.h"
#include "tools/library/jobs/resources/threads.h"
#include "weft/weft.h"

namespace weft::tools {

void telling(const bool& first, const std::function<void()>& work) {
  const auto tell = [&](const std::exception& error) {
    if (first) throw InputError("", "", error.what());
    throw RunError(error.what(), true);
  };
  try {
    work();
  } catch (const InputError& error) {
    tell(error);
  } catch (const OptionError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    tell(error);
  } catch (const partition::InvariantViolation& error) {
    tell(error);
  }
}

void on_world_telling(const RankBody& body) {
  bool first = true;
  telling(first, [&] {
    on_world([&](engine::Transport& transport) {
      first = transport.rank().value == 0;
      body(transport);
    });
  });
}

bool on_peers_of_world(const std::function<void(partition::Peers&)>& body, int threads) {
  bool first = true;
  on_world_telling([&](engine::Transport& transport) {
    engine::Registry registry;
    graph::adaptation::EnginePeers::register_types(registry);
    engine::Runtime runtime(transport, registry, {});
    graph::adaptation::EnginePeers peers(runtime);
    first = peers.rank() == 0;
    with_threads(number_of_threads(threads), [&] { body(peers); });
  });
  return first;
}

}  // namespace weft::tools
