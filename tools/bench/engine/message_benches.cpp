// Benchmarks of single messages and moves.
#include <cstdint>
#include <vector>

#include "engine/json/json.h"
#include "engine/run/runtime.h"
#include "tools/bench/engine/benches.h"
#include "tools/bench/engine/measures.h"

namespace weft::bench {
namespace {

using engine::Context;
using engine::MobilePtr;
using engine::Rank;
using engine::Registry;
using engine::Runtime;
using engine::Transport;
using Bytes = std::vector<std::uint8_t>;

constexpr int kWarmUp = 200;

/// Two of them play; the one that serves notes when the ball comes back.
struct Player {
  MobilePtr<Player> other;
  int rounds = 0;
  std::vector<double> times;

  void serve(Context& context, MobilePtr<Player> opponent, std::uint64_t size, int count) {
    other = opponent;
    rounds = count + kWarmUp;
    times.push_back(wall_clock());
    context.invoke<&Player::back>(other, MobilePtr<Player>{context.self()}, Bytes(size, 1));
  }
  void back(Context& context, MobilePtr<Player> from, Bytes ball) {
    context.invoke<&Player::take>(from, std::move(ball));
  }
  void take(Context& context, Bytes ball) {
    times.push_back(wall_clock());
    if (--rounds > 0)
      context.invoke<&Player::back>(other, MobilePtr<Player>{context.self()}, std::move(ball));
  }
};

/// Differences of successive times in microseconds, without the first ones.
std::vector<double> microseconds_between(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = kWarmUp + 1; i < times.size(); ++i) steps.push_back((times[i] - times[i - 1]) * 1e6);
  return steps;
}

/// Ball of `size` bytes between an object of rank 0 and one of rank `there`.
ordered_json play(Transport& transport, Rank there, std::uint64_t size, int rounds) {
  Registry registry;
  registry.type<Player>("Player")
      .method<&Player::serve>("serve")
      .method<&Player::back>("back")
      .method<&Player::take>("take");
  Runtime runtime(transport, registry, {.balancer = engine::no_balancing()});
  runtime.run([](Context& context) {
    for (int i = 0; i < 2; ++i) context.create<Player>();
  });
  runtime.run([&](Context& context) {
    if (context.rank() != Rank(0)) return;
    context.invoke<&Player::serve>(MobilePtr<Player>{{Rank(0), 1}}, MobilePtr<Player>{{there, 2}}, size,
                                   rounds);
  });
  std::vector<double> times;
  runtime.visit<Player>([&](MobilePtr<Player>, Player& player) {
    if (!player.times.empty()) times = player.times;
  });
  if (transport.rank() != Rank(0)) return {};
  const std::vector<double> trips = microseconds_between(times);
  return {{"bytes", size},
          {"rounds", rounds},
          {"median_us", quantile(trips, 0.5) / 2},
          {"quantile_90_us", quantile(trips, 0.9) / 2}};
}

// --- Floods

constexpr int kSinks = 64;

/// Object 1 of each rank sends to the others, the sinks, of some rank.
struct Flooder {
  double begin = 0;
  double end = 0;

  void flood(Context& context, Rank to, int messages) {
    begin = wall_clock();
    for (int i = 0; i < messages; ++i) {
      const auto sink = static_cast<std::uint32_t>(2 + i % kSinks);
      context.invoke<&Flooder::drop>(MobilePtr<Flooder>{{to, sink}}, i);
    }
  }
  void drop(Context&, int) { end = wall_clock(); }
};

/// Handlers a second and rank when every rank floods the rank `distance` further.
ordered_json flood(Transport& transport, int distance, int messages) {
  Registry registry;
  registry.type<Flooder>("Flooder").method<&Flooder::flood>("flood").method<&Flooder::drop>("drop");
  Runtime runtime(transport, registry, {.balancer = engine::no_balancing()});
  runtime.run([](Context& context) {
    for (int i = 0; i < kSinks + 1; ++i) context.create<Flooder>();
  });
  runtime.run([&](Context& context) {
    const Rank to((context.rank().value + distance) % context.ranks());
    context.invoke<&Flooder::flood>(MobilePtr<Flooder>{{context.rank(), 1}}, to, messages);
  });
  double begin = 1e300, end = 0;
  runtime.visit<Flooder>([&](MobilePtr<Flooder>, Flooder& flooder) {
    if (flooder.begin > 0) begin = flooder.begin;
    end = std::max(end, flooder.end);
  });
  double first = begin, last = end;
  for (const auto& times : gather(transport, {begin, end})) {
    first = std::min(first, times[0]);
    last = std::max(last, times[1]);
  }
  return {{"messages_per_rank", messages}, {"handlers_per_s_per_rank", messages / (last - first)}};
}

// --- Moves

/// Goes to the other rank and back, with all it has.
struct Mover {
  Bytes state;
  int left = 0;
  std::vector<double> times;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(state, left, times);
  }
  void go(Context& context, std::uint64_t size, int moves) {
    state.assign(size, 1);
    left = moves + kWarmUp;
    arrive(context);
  }
  void arrive(Context& context) {
    times.push_back(wall_clock());
    if (left-- == 0) return;
    const MobilePtr<Mover> self{context.self()};
    context.migrate(self, Rank(1 - context.rank().value));
    context.invoke<&Mover::arrive>(self);
  }
};

ordered_json move(Transport& transport, std::uint64_t size, int moves) {
  Registry registry;
  registry.type<Mover>("Mover").method<&Mover::go>("go").method<&Mover::arrive>("arrive");
  Runtime runtime(transport, registry, {.balancer = engine::no_balancing()});
  runtime.run([&](Context& context) {
    if (context.rank() == Rank(0)) context.invoke<&Mover::go>(context.create<Mover>(), size, moves);
  });
  std::vector<double> times;
  runtime.visit<Mover>([&](MobilePtr<Mover>, Mover& mover) { times = mover.times; });
  const engine::TimeSummary seconds = runtime.summary().times;
  // An even number of moves brings it back to rank 0.
  const auto all = gather(transport, {seconds.pack, seconds.unpack});
  if (transport.rank() != Rank(0)) return {};
  const double megabytes = static_cast<double>(size) * 1e-6;
  const double per_move = 1.0 / (moves + kWarmUp) / megabytes;
  const std::vector<double> steps = microseconds_between(times);
  return {{"bytes", size},
          {"moves", moves},
          {"median_us", median(steps)},
          {"s_per_mb", median(steps) * 1e-6 / megabytes},
          {"pack_s_per_mb", (all[0][0] + all[1][0]) * per_move},
          {"unpack_s_per_mb", (all[0][1] + all[1][1]) * per_move}};
}

}  // namespace

ordered_json latency(Transport& transport) {
  ordered_json result;
  for (const std::uint64_t size : {8, 1 << 10, 16 << 10}) {
    result["remote"].push_back(play(transport, Rank(1), size, 4000));
    result["local"].push_back(play(transport, Rank(0), size, 20000));
  }
  return result;
}

ordered_json rate(Transport& transport) {
  ordered_json result;
  for (int repeat = 0; repeat < 5; ++repeat) {
    result["local"].push_back(flood(transport, 0, 200'000));
    result["remote"].push_back(flood(transport, 1, 200'000));
  }
  return result;
}

ordered_json migration(Transport& transport) {
  ordered_json result;
  result.push_back(move(transport, 1'000, 2000));
  result.push_back(move(transport, 1'000'000, 200));
  result.push_back(move(transport, 64'000'000, 10));
  return result;
}

}  // namespace weft::bench
