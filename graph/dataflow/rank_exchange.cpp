// One mailbox a rank, one run an exchange.
#include "graph/dataflow/rank_exchange.h"

#include <cstdint>
#include <stdexcept>
#include <utility>

#include "engine/base/text.h"

namespace weft::graph::dataflow {
namespace {

/// Without serialize(): it never moves.
struct Mailbox {
  std::vector<engine::Payload> from_each;

  void put(engine::Context&, std::int32_t from, engine::Payload payload) {
    from_each.at(static_cast<std::size_t>(from)) = std::move(payload);
  }
};

engine::MobilePtr<Mailbox> mailbox_of(int rank) { return {{engine::Rank(rank), 1}}; }

}  // namespace

void RankExchange::register_types(engine::Registry& registry) {
  registry.type<Mailbox>("RankExchange").method<&Mailbox::put>("put");
}

RankExchange::RankExchange(engine::Runtime& runtime) : runtime_(runtime) {
  bool exists = false;
  runtime_.visit<Mailbox>([&](engine::MobilePtr<Mailbox>, Mailbox&) { exists = true; });
  runtime_.run([&](engine::Context& context) {
    if (exists) return;
    const auto mailbox = context.create<Mailbox>();
    if (mailbox != mailbox_of(context.rank().value)) {
      throw std::logic_error(
          engine::text("a rank's mailbox must be its first object, but has the number ", mailbox.id.number));
    }
  });
}

std::vector<engine::Payload> RankExchange::exchange(std::vector<engine::Payload> to_each) {
  const int ranks = runtime_.ranks();
  const int mine = runtime_.rank().value;
  const auto with_mailbox = [&](const auto& use) {
    runtime_.visit<Mailbox>([&](engine::MobilePtr<Mailbox>, Mailbox& mailbox) { use(mailbox); });
  };
  with_mailbox([&](Mailbox& mailbox) {
    mailbox.from_each.clear();
    mailbox.from_each.resize(static_cast<std::size_t>(ranks));
  });
  runtime_.run([&](engine::Context& context) {
    if (to_each.size() != static_cast<std::size_t>(ranks)) {
      throw std::logic_error(engine::text(to_each.size(), " payloads for ", ranks, " ranks"));
    }
    for (int step = 1; step < ranks; ++step) {  // not all to the same rank at first
      const int to = (mine + step) % ranks;
      engine::Payload& payload = to_each[static_cast<std::size_t>(to)];
      // What is not sent is empty where it would have come: the run's end says that nothing comes any more.
      if (payload.size() > 0) context.invoke<&Mailbox::put>(mailbox_of(to), mine, std::move(payload));
    }
  });
  std::vector<engine::Payload> received;
  with_mailbox([&](Mailbox& mailbox) { received = std::move(mailbox.from_each); });
  received[static_cast<std::size_t>(mine)] = std::move(to_each[static_cast<std::size_t>(mine)]);
  return received;
}

}  // namespace weft::graph::dataflow
