// One mailbox a rank, one run an exchange.
#include "graph/dataflow/rank_exchange.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <map>
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

/// Small payloads that go the same way, packed as one.
class Bundle {
 public:
  struct Message {
    std::int32_t from, to;
    std::uint64_t bytes;     ///< of the payload, its segments' included
    std::uint64_t segments;  ///< entries of segment_sizes_
  };

  void add(int from, int to, const engine::Payload& payload) {
    messages_.push_back({from, to, payload.size(), payload.segments.size()});
    bytes_.insert(bytes_.end(), payload.bytes.begin(), payload.bytes.end());
    for (const engine::Blob& segment : payload.segments) {
      segment_sizes_.push_back(segment.size());
      bytes_.insert(bytes_.end(), segment.data(), segment.data() + segment.size());
    }
  }
  void append(const Bundle& other) {
    other.each([&](const Message& message, const std::byte* bytes, const std::uint64_t* sizes) {
      add(message, bytes, sizes);
    });
  }
  /// Takes out the messages for which goes(to).
  template <class Goes>
  Bundle take(const Goes& goes) {
    Bundle going, staying;
    each([&](const Message& message, const std::byte* bytes, const std::uint64_t* sizes) {
      (goes(message.to) ? going : staying).add(message, bytes, sizes);
    });
    *this = std::move(staying);
    return going;
  }
  /// Calls deliver(from, payload) for each.
  template <class Deliver>
  void open(const Deliver& deliver) const {
    each([&](const Message& message, const std::byte* bytes, const std::uint64_t* sizes) {
      engine::Payload payload;
      std::uint64_t in_segments = 0;
      for (std::uint64_t s = 0; s < message.segments; ++s) in_segments += sizes[s];
      const std::byte* next = bytes + (message.bytes - in_segments);
      payload.bytes.assign(bytes, next);
      for (std::uint64_t s = 0; s < message.segments; next += sizes[s++]) {
        payload.segments.push_back(engine::Blob::allocate(sizes[s]));
        if (sizes[s] > 0) std::memcpy(payload.segments.back().data(), next, sizes[s]);
      }
      deliver(message.from, std::move(payload));
    });
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(messages_, segment_sizes_, bytes_);
  }

 private:
  void add(const Message& message, const std::byte* bytes, const std::uint64_t* sizes) {
    messages_.push_back(message);
    bytes_.insert(bytes_.end(), bytes, bytes + message.bytes);
    segment_sizes_.insert(segment_sizes_.end(), sizes, sizes + message.segments);
  }
  template <class Visit>
  void each(const Visit& visit) const {
    const std::byte* bytes = bytes_.data();
    const std::uint64_t* sizes = segment_sizes_.data();
    for (const Message& message : messages_) {
      visit(message, bytes, sizes);
      bytes += message.bytes;
      sizes += message.segments;
    }
  }

  std::vector<Message> messages_;
  std::vector<std::uint64_t> segment_sizes_;
  std::vector<std::byte> bytes_;
};

/// Without serialize(): it never moves.
struct Mailbox {
  std::vector<engine::Payload> from_each;

  // Of small payloads, on their way through this rank: after `step` steps those are here whose way from here,
  // upwards and round, is a multiple of 2^step ranks.
  Bundle held;
  std::map<std::int32_t, Bundle> arrived;  ///< by step; a rank may be steps ahead
  std::int32_t step = 0;
  bool began = false, passed = false;  ///< passed: this step's messages have gone on

  // Of the tree: rank r has the children 2 r + 1 and 2 r + 2. What has come from this rank and its children.
  std::array<std::optional<Contributions>, 3> parts;
  Contributions all;
  const RankExchange::Combine* combine = nullptr;  ///< null: all are kept

  void put(engine::Context&, std::int32_t from, engine::Payload payload) {
    from_each.at(static_cast<std::size_t>(from)) = std::move(payload);
  }

  void begin(engine::Context& context, Bundle mine) {
    held = std::move(mine);
    began = true;
    pass_on(context);
  }
  void pass(engine::Context& context, std::int32_t at_step, Bundle messages) {
    arrived[at_step] = std::move(messages);
    pass_on(context);
  }
  void pass_on(engine::Context& context) {
    const std::int32_t rank = context.rank().value, ranks = context.ranks();
    while (began && std::int64_t{1} << step < ranks) {
      const std::int32_t stride = std::int32_t{1} << step;
      if (!std::exchange(passed, true))
        context.invoke<&Mailbox::pass>(mailbox_of((rank + stride) % ranks), step, held.take([&](int to) {
          return ((to - rank + ranks) % ranks & stride) != 0;
        }));
      const auto here = arrived.find(step);
      if (here == arrived.end()) return;
      held.append(here->second);
      arrived.erase(here);
      passed = false;
      ++step;
    }
    if (!began) return;
    held.open([&](int from, engine::Payload payload) { put(context, from, std::move(payload)); });
    held = {};
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
      .method<&Mailbox::begin>("begin")
      .method<&Mailbox::pass>("pass")
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
    mailbox.step = 0;
    mailbox.began = mailbox.passed = false;
  });
  runtime_.run([&](engine::Context& context) {
    if (to_each.size() != static_cast<std::size_t>(ranks)) {
      throw std::logic_error(engine::text(to_each.size(), " payloads for ", ranks, " ranks"));
    }
    Bundle messages;
    for (int step = 1; step < ranks; ++step) {  // not all to the same rank at first
      const int to = (mine + step) % ranks;
      engine::Payload& payload = to_each[static_cast<std::size_t>(to)];
      // What is not sent is empty where it would have come: the run's end says that nothing comes any more.
      if (payload.size() == 0) continue;
      if (payload.size() < kDirectBytes)
        messages.add(mine, to, std::exchange(payload, {}));
      else
        context.invoke<&Mailbox::put>(mailbox_of(to), mine, std::move(payload));
    }
    if (ranks > 1) context.invoke<&Mailbox::begin>(mailbox_of(mine), std::move(messages));
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
