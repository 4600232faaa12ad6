// One mailbox a rank, one run an exchange.
#include "graph/dataflow/rank_exchange.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "engine/base/text.h"

namespace weft::graph::dataflow {
namespace {

struct Mailbox;
engine::MobilePtr<Mailbox> mailbox_of(int rank) { return {{engine::Rank(rank), 1}}; }

/// What one or several ranks have given, one after the other: on its way nothing is done for each.
struct Contributions {
  std::vector<std::int32_t> ranks;
  std::vector<std::uint64_t> sizes;
  RankExchange::Bytes bytes;

  void append(const Contributions& more) {
    ranks.insert(ranks.end(), more.ranks.begin(), more.ranks.end());
    sizes.insert(sizes.end(), more.sizes.begin(), more.sizes.end());
    bytes.insert(bytes.end(), more.bytes.begin(), more.bytes.end());
  }
  /// Calls visit(rank, bytes) for each, in no order.
  template <class Visit>
  void each(const Visit& visit) const {
    std::span<const std::byte> rest(bytes);
    for (std::size_t i = 0; i < ranks.size(); ++i) {
      visit(static_cast<std::size_t>(ranks[i]), rest.first(sizes[i]));
      rest = rest.subspan(sizes[i]);
    }
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(ranks, sizes, bytes);
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
  /// Calls deliver(from, payload) for each, empty ones too.
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

/// Whom a rank meets until it knows what all have given: ranks from the largest power of two on tell one of
/// the others at first and hear from it at last; those meet in pairs, 1, 2, 4, ... ranks apart, and each
/// tells the other all that it knows (recursive doubling; Thakur et al., 2005).
class GatherSteps {
 public:
  struct Step {
    std::int32_t partner = 0;
    bool tells = false, hears = false;
  };

  GatherSteps(std::int32_t rank, std::int32_t ranks)
      : rank_(rank),
        ranks_(ranks),
        paired_(static_cast<std::int32_t>(std::bit_floor(static_cast<std::uint32_t>(ranks)))) {}

  std::int32_t count() const { return std::countr_zero(static_cast<std::uint32_t>(paired_)) + 2; }
  Step operator[](std::int32_t step) const {
    const bool first = step == 0, last = step + 1 == count();
    if (!first && !last) {
      const bool meets = rank_ < paired_;
      return {rank_ ^ std::int32_t{1} << (step - 1), meets, meets};
    }
    if (rank_ >= paired_) return {rank_ - paired_, first, last};
    const bool has_other = rank_ + paired_ < ranks_;
    return {rank_ + paired_, has_other && last, has_other && first};
  }

 private:
  std::int32_t rank_, ranks_, paired_;
};

/// Where this rank is on a way in steps, in each of which something may come; other ranks may be steps ahead.
template <class T>
class StepByStep {
 public:
  void restart() { *this = {}; }
  void begin() { began_ = true; }
  bool began() const { return began_; }
  std::int32_t step() const { return step_; }
  /// True once a step.
  bool is_to_send() { return !std::exchange(sent_, true); }
  void arrive(std::int32_t at_step, T something) { arrived_[at_step] = std::move(something); }
  /// Of this step; nothing if it has not come.
  std::optional<T> take() {
    auto here = arrived_.extract(step_);
    if (here.empty()) return {};
    return std::move(here.mapped());
  }
  void next() {
    ++step_;
    sent_ = false;
  }

 private:
  std::int32_t step_ = 0;
  bool began_ = false, sent_ = false;
  std::map<std::int32_t, T> arrived_;
};

/// Without serialize(): it never moves.
struct Mailbox {
  std::vector<engine::Payload> from_each;

  // Of small payloads, on their way through this rank: after so many steps those are here whose way from
  // here, upwards and round, is a multiple of 2^steps ranks.
  Bundle held;
  StepByStep<Bundle> passing;
  bool opened = false;             ///< all steps are over
  std::int64_t large_missing = 0;  ///< announced by empty ones, less those that have come

  // Of what all ranks give (GatherSteps): what is known of it here.
  Contributions known;
  StepByStep<Contributions> meeting;
  bool gathered = false;
  const RankExchange::Combine* combine = nullptr;  ///< null: all are kept

  /// A large one.
  void put(engine::Context&, std::int32_t from, engine::Payload payload) {
    from_each.at(static_cast<std::size_t>(from)) = std::move(payload);
    --large_missing;
  }
  bool exchanged() const { return opened && large_missing == 0; }

  void begin(engine::Context& context, Bundle mine) {
    held = std::move(mine);
    passing.begin();
    pass_on(context);
  }
  void pass(engine::Context& context, std::int32_t at_step, Bundle messages) {
    passing.arrive(at_step, std::move(messages));
    pass_on(context);
  }
  void pass_on(engine::Context& context) {
    if (!passing.began()) return;
    const std::int32_t rank = context.rank().value, ranks = context.ranks();
    for (; std::int64_t{1} << passing.step() < ranks; passing.next()) {
      const std::int32_t stride = std::int32_t{1} << passing.step();
      if (passing.is_to_send())
        context.invoke<&Mailbox::pass>(
            mailbox_of((rank + stride) % ranks), passing.step(),
            held.take([&](int to) { return ((to - rank + ranks) % ranks & stride) != 0; }));
      const std::optional<Bundle> here = passing.take();
      if (!here) return;
      held.append(*here);
    }
    held.open([&](int from, engine::Payload payload) {
      if (payload.size() == 0)
        ++large_missing;
      else
        from_each.at(static_cast<std::size_t>(from)) = std::move(payload);
    });
    held = {};
    opened = true;
  }

  void give(engine::Context& context, Contributions mine) {
    known = std::move(mine);
    meeting.begin();
    meet_on(context);
  }
  void meet(engine::Context& context, std::int32_t at_step, Contributions theirs) {
    meeting.arrive(at_step, std::move(theirs));
    meet_on(context);
  }
  void meet_on(engine::Context& context) {
    if (!meeting.began()) return;
    const GatherSteps steps(context.rank().value, context.ranks());
    for (; meeting.step() < steps.count(); meeting.next()) {
      const auto [partner, tells, hears] = steps[meeting.step()];
      if (tells && meeting.is_to_send())
        context.invoke<&Mailbox::meet>(mailbox_of(partner), meeting.step(), known);
      if (!hears) continue;
      std::optional<Contributions> here = meeting.take();
      if (!here) return;
      if (meeting.step() + 1 == steps.count())
        known = std::move(*here);
      else
        join(std::move(*here), partner < context.rank().value);
    }
    gathered = true;
  }
  /// Lower ranks' first, so that all ranks get the same bits.
  void join(Contributions theirs, bool are_first) {
    if (are_first) std::swap(known, theirs);
    if (combine != nullptr)
      (*combine)(known.bytes, theirs.bytes);
    else
      known.append(theirs);
  }
};

/// Of this rank. It stays where it is.
Mailbox& mailbox_here(engine::Runtime& runtime) {
  Mailbox* here = nullptr;
  runtime.visit<Mailbox>([&](engine::MobilePtr<Mailbox>, Mailbox& mailbox) { here = &mailbox; });
  return *here;
}

/// What all ranks give.
Contributions gather(engine::Runtime& runtime, RankExchange::Bytes mine,
                     const RankExchange::Combine* combine) {
  Mailbox& mailbox = mailbox_here(runtime);
  mailbox.meeting.restart();
  mailbox.gathered = false;
  mailbox.combine = combine;
  runtime.run_until([&] { return mailbox.gathered; },
                    [&](engine::Context& context) {
                      const std::int32_t rank = context.rank().value;
                      Contributions part{{rank}, {mine.size()}, std::move(mine)};
                      context.invoke<&Mailbox::give>(mailbox_of(rank), std::move(part));
                    });
  return std::exchange(mailbox.known, {});
}

}  // namespace

void RankExchange::register_types(engine::Registry& registry) {
  registry.type<Mailbox>("RankExchange")
      .method<&Mailbox::put>("put")
      .method<&Mailbox::begin>("begin")
      .method<&Mailbox::pass>("pass")
      .method<&Mailbox::give>("give")
      .method<&Mailbox::meet>("meet");
}

RankExchange::RankExchange(engine::Runtime& runtime) : runtime_(runtime) {
  bool exists = false;
  runtime_.visit<Mailbox>([&](engine::MobilePtr<Mailbox>, Mailbox&) { exists = true; });
  const auto all_have_come = [] { return true; };  // nothing is sent
  runtime_.run_until(all_have_come, [&](engine::Context& context) {
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
  Mailbox& mailbox = mailbox_here(runtime_);
  mailbox.from_each.clear();
  mailbox.from_each.resize(static_cast<std::size_t>(ranks));
  mailbox.passing.restart();
  mailbox.large_missing = 0;
  mailbox.opened = ranks == 1;
  const auto root = [&](engine::Context& context) {
    if (to_each.size() != static_cast<std::size_t>(ranks)) {
      throw std::logic_error(engine::text(to_each.size(), " payloads for ", ranks, " ranks"));
    }
    Bundle messages;
    for (int step = 1; step < ranks; ++step) {  // not all to the same rank at first
      const int to = (mine + step) % ranks;
      engine::Payload& payload = to_each[static_cast<std::size_t>(to)];
      // What is not sent is empty where it would have come.
      if (payload.size() == 0) continue;
      if (payload.size() < kDirectBytes) {
        messages.add(mine, to, std::exchange(payload, {}));
      } else {
        messages.add(mine, to, {});  // says that it comes
        context.invoke<&Mailbox::put>(mailbox_of(to), mine, std::move(payload));
      }
    }
    if (ranks > 1) context.invoke<&Mailbox::begin>(mailbox_of(mine), std::move(messages));
  };
  runtime_.run_until([&] { return mailbox.exchanged(); }, root);
  std::vector<engine::Payload> received = std::move(mailbox.from_each);
  received[static_cast<std::size_t>(mine)] = std::move(to_each[static_cast<std::size_t>(mine)]);
  return received;
}

std::vector<RankExchange::Bytes> RankExchange::allgather(Bytes mine) {
  std::vector<Bytes> result(static_cast<std::size_t>(runtime_.ranks()));
  gather(runtime_, std::move(mine), nullptr).each([&](std::size_t rank, std::span<const std::byte> bytes) {
    result.at(rank).assign(bytes.begin(), bytes.end());
  });
  return result;
}

RankExchange::Bytes RankExchange::allgather_joined(Bytes mine) {
  const Contributions all = gather(runtime_, std::move(mine), nullptr);
  std::vector<std::span<const std::byte>> by_rank(static_cast<std::size_t>(runtime_.ranks()));
  all.each([&](std::size_t rank, std::span<const std::byte> bytes) { by_rank.at(rank) = bytes; });
  Bytes joined;
  joined.reserve(all.bytes.size());
  for (const auto& bytes : by_rank) joined.insert(joined.end(), bytes.begin(), bytes.end());
  return joined;
}

RankExchange::Bytes RankExchange::reduce(Bytes mine, const Combine& combine) {
  return std::move(gather(runtime_, std::move(mine), &combine).bytes);
}

}  // namespace weft::graph::dataflow
