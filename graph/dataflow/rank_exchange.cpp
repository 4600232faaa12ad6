// One mailbox a rank, one run an exchange.
#include "graph/dataflow/rank_exchange.h"

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <utility>

#include "engine/base/text.h"

namespace weft::graph::dataflow {
namespace {

struct Mailbox;
engine::MobilePtr<Mailbox> mailbox_of(int rank) { return {{engine::Rank(rank), 1}}; }

/// What one or several ranks have given.
struct Contributions {
  std::vector<std::int32_t> ranks;
  std::vector<RankExchange::Bytes> values;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(ranks, values);
  }
};

/// Without serialize(): it never moves.
struct Mailbox {
  std::vector<engine::Payload> from_each;

  // Of the tree: rank r has the children 2 r + 1 and 2 r + 2. What has come from this rank and its children.
  std::array<std::optional<Contributions>, 3> parts;
  Contributions all;
  const RankExchange::Combine* combine = nullptr;  ///< null: all are kept

  void put(engine::Context&, std::int32_t from, engine::Payload payload) {
    from_each.at(static_cast<std::size_t>(from)) = std::move(payload);
  }

  void rise(engine::Context& context, std::int32_t from, Contributions part) {
    const int rank = context.rank().value, ranks = context.ranks();
    parts.at(static_cast<std::size_t>(from == rank ? 0 : from - 2 * rank)) = std::move(part);
    for (int k = 0; k < 3; ++k)
      if ((k == 0 || 2 * rank + k < ranks) && !parts[static_cast<std::size_t>(k)]) return;
    Contributions sum = joined();
    if (rank > 0)
      context.invoke<&Mailbox::rise>(mailbox_of((rank - 1) / 2), rank, std::move(sum));
    else
      sink(context, std::move(sum));
  }

  void sink(engine::Context& context, Contributions sum) {
    for (int child = 2 * context.rank().value + 1; child <= 2 * context.rank().value + 2; ++child)
      if (child < context.ranks()) context.invoke<&Mailbox::sink>(mailbox_of(child), sum);
    all = std::move(sum);
  }

  Contributions joined() {
    Contributions sum = std::move(*parts[0]);
    for (std::size_t k = 1; k < parts.size(); ++k) {
      if (!parts[k]) continue;
      for (std::size_t i = 0; i < parts[k]->ranks.size(); ++i) {
        if (combine != nullptr) {
          (*combine)(sum.values[0], parts[k]->values[i]);
        } else {
          sum.ranks.push_back(parts[k]->ranks[i]);
          sum.values.push_back(std::move(parts[k]->values[i]));
        }
      }
    }
    return sum;
  }
};

/// Up and down the tree.
Contributions gather(engine::Runtime& runtime, RankExchange::Bytes mine,
                     const RankExchange::Combine* combine) {
  const auto with_mailbox = [&](const auto& use) {
    runtime.visit<Mailbox>([&](engine::MobilePtr<Mailbox>, Mailbox& mailbox) { use(mailbox); });
  };
  with_mailbox([&](Mailbox& mailbox) { mailbox.parts = {}, mailbox.all = {}, mailbox.combine = combine; });
  runtime.run([&](engine::Context& context) {
    const std::int32_t rank = context.rank().value;
    Contributions part{{rank}, {}};
    part.values.push_back(std::move(mine));
    context.invoke<&Mailbox::rise>(mailbox_of(rank), rank, std::move(part));
  });
  Contributions all;
  with_mailbox([&](Mailbox& mailbox) { all = std::move(mailbox.all); });
  return all;
}

}  // namespace

void RankExchange::register_types(engine::Registry& registry) {
  registry.type<Mailbox>("RankExchange")
      .method<&Mailbox::put>("put")
      .method<&Mailbox::rise>("rise")
      .method<&Mailbox::sink>("sink");
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

std::vector<RankExchange::Bytes> RankExchange::allgather(Bytes mine) {
  std::vector<Bytes> result(static_cast<std::size_t>(runtime_.ranks()));
  Contributions all = gather(runtime_, std::move(mine), nullptr);
  for (std::size_t i = 0; i < all.ranks.size(); ++i)
    result.at(static_cast<std::size_t>(all.ranks[i])) = std::move(all.values[i]);
  return result;
}

RankExchange::Bytes RankExchange::reduce(Bytes mine, const Combine& combine) {
  return std::move(gather(runtime_, std::move(mine), &combine).values.at(0));
}

}  // namespace weft::graph::dataflow
