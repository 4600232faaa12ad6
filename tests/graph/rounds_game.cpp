#include "tests/graph/rounds_game.h"

#include <algorithm>
#include <utility>

namespace weft::testing {

using namespace graph::dataflow;

namespace {

std::uint64_t mix(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

std::uint64_t mix(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  return mix(mix(mix(a + 0x9E3779B97F4A7C15u) ^ b) ^ c);
}

bool may_sleep(const GameRules& rules, std::uint32_t player, std::uint64_t round) {
  return mix(player, round, rules.seed + 77) % 3 == 0;
}

std::uint64_t first_value(std::uint32_t player) { return mix(player, 1, 2); }

std::uint64_t next_value(std::uint64_t value, std::uint64_t received) { return mix(value, received, 3); }

}  // namespace

Ref<Player> GameRules::player(std::uint32_t i) const {
  return {{engine::Rank(static_cast<std::int32_t>(i % ranks)), i / ranks + first_number}};
}

std::vector<std::uint32_t> GameRules::neighbours(std::uint32_t player, std::uint64_t round) const {
  std::vector<std::uint32_t> all;
  for (std::uint32_t other = 0; other < players; ++other) {
    if (other == player) continue;
    const std::uint32_t apart = (other + players - player) % players;
    const bool in_ring = apart == 1 || apart == players - 1;
    if (in_ring || mix(std::min(player, other), std::max(player, other), round) % 5 == 0)
      all.push_back(other);
  }
  std::sort(all.begin(), all.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mix(player, round + seed, a) < mix(player, round + seed, b);
  });
  return all;
}

bool GameRules::sleeps(std::uint32_t player, std::uint64_t round) const {
  if (!dormancy || !may_sleep(*this, player, round)) return false;
  const auto others = neighbours(player, round);
  return std::any_of(others.begin(), others.end(),
                     [&](std::uint32_t i) { return !may_sleep(*this, i, round); });
}

// --- Nodes

std::optional<Nothing> Player::enter(NodeContext& context) {
  const std::uint64_t round = context.round();
  if (round == rules.rounds) return std::nullopt;
  if (calls.erase(round) == 0 && rules.sleeps(index, round)) {
    asleep_before = round;
    return std::nullopt;
  }
  return Nothing{};
}

std::optional<Nothing> Player::woken(NodeContext&, std::uint64_t round) {
  if (!woken_in.insert(round).second) ++faults;
  if (asleep_before != round) {
    calls.insert(round);
    return std::nullopt;
  }
  asleep_before.reset();
  return Nothing{};
}

void Player::propose(NodeContext& context) {
  const std::uint64_t round = context.round();
  std::vector<Ref<Player>> others;
  for (const std::uint32_t i : rules.neighbours(index, round)) {
    others.push_back(rules.player(i));
    context.send<&Player::gather>(others.back(), round, packed_value(i, round));
  }
  context.expect<&Player::gather>(round, others);
}

void Player::gather(NodeContext& context, std::uint64_t round, Values values) {
  take(round, values);
  context.count("values", static_cast<double>(values.size()));
  context.count("values", 1);
  context.count("rounds", 1);
  std::vector<Ref<Player>> others;
  for (const auto& arrival : values) {
    others.push_back({arrival.from});
    context.send<&Player::scatter>(others.back(), round, GameValue{value, {}});
  }
  context.expect<&Player::scatter>(round, others);
}

void Player::scatter(NodeContext&, std::uint64_t round, Values values) {
  take(round, values);
  calls.erase(round);
  ++rounds_played;
}

/// A value whose ballast says to whom it goes.
GameValue Player::packed_value(std::uint32_t to, std::uint64_t round) const {
  GameValue packed{value, {}};
  for (std::uint32_t i = 0; i < rules.ballast; ++i) packed.ballast.push_back(mix(to, round, i));
  return packed;
}

void Player::take(std::uint64_t round, const Values& values) {
  const auto expected = rules.neighbours(index, round);
  if (round != rounds_played || values.size() != expected.size()) {
    ++faults;
    return;
  }
  std::uint64_t received = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i].from != rules.player(expected[i]).id) ++faults;
    received = mix(received, values[i].value.value, i);
    const auto& ballast = values[i].value.ballast;
    if (!ballast.empty() && ballast != packed_value(index, round).ballast) ++faults;
  }
  value = next_value(value, received);
}

Blueprint<Player> Player::blueprint() {
  Blueprint<Player> g("player");
  const auto enter = g.start<&Player::enter>("enter");
  const auto propose = g.node<&Player::propose>("propose");
  const auto gather = g.event<&Player::gather>("gather");
  const auto scatter = g.event<&Player::scatter>("scatter");
  const auto woken = g.wakes<&Player::woken>(gather, "woken");
  g.local(enter, propose);
  g.local(woken, propose);
  g.remote<GameValue>(propose, gather);
  g.remote<GameValue>(gather, scatter);
  g.local(scatter, enter, RoundStep::next);
  return g;
}

// --- The whole game

std::vector<std::uint64_t> play_by_hand(const GameRules& rules) {
  std::vector<std::uint64_t> values;
  for (std::uint32_t i = 0; i < rules.players; ++i) values.push_back(first_value(i));
  for (std::uint32_t step = 0; step < 2 * rules.rounds; ++step) {
    const std::vector<std::uint64_t> old = values;
    for (std::uint32_t i = 0; i < rules.players; ++i) {
      std::uint64_t received = 0;
      std::uint64_t place = 0;
      for (const std::uint32_t other : rules.neighbours(i, step / 2)) {
        received = mix(received, old[other], place++);
      }
      values[i] = next_value(old[i], received);
    }
  }
  return values;
}

void start_game(Recording recording, engine::Context& context, GameRules rules) {
  rules.ranks = static_cast<std::uint32_t>(context.ranks());
  for (auto i = static_cast<std::uint32_t>(context.rank().value); i < rules.players; i += rules.ranks) {
    Player player;
    player.rules = rules;
    player.index = i;
    player.value = first_value(i);
    start<&Player::enter>(context, create(context, std::move(player), recording));
  }
}

}  // namespace weft::testing
