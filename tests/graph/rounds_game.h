// A protocol of many rounds between instances whose neighbours change from round to round, and what it must
// come to.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "graph/dataflow/blueprint.h"

namespace weft::testing {

/// What all players know. Who plays with whom in which round, in which order a player names its neighbours,
/// and who sleeps until it is called up are functions of it.
struct GameRules {
  std::uint32_t players = 0;
  std::uint32_t ranks = 1;
  std::uint32_t rounds = 0;
  std::uint32_t ballast = 0;       ///< numbers sent beside each value
  std::uint32_t first_number = 1;  ///< of a rank's first player
  bool dormancy = false;
  std::uint64_t seed = 0;

  graph::dataflow::Ref<struct Player> player(std::uint32_t index) const;
  /// Symmetric; at least the two next in the ring (if there are others at all).
  std::vector<std::uint32_t> neighbours(std::uint32_t player, std::uint64_t round) const;
  /// It does not start the round by itself, but some neighbour does.
  bool sleeps(std::uint32_t player, std::uint64_t round) const;
};

/// What travels between players.
struct GameValue {
  std::uint64_t value = 0;
  std::vector<std::uint64_t> ballast;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(value, ballast);
  }
};

/// propose -> gather of all neighbours -> scatter of all neighbours -> propose of the next round.
struct Player {
  using Values = std::vector<graph::dataflow::Arrival<GameValue>>;

  GameRules rules;
  std::uint32_t index = 0;
  std::uint64_t value = 0;
  std::uint64_t faults = 0;  ///< arrivals out of order, corrupted or in the wrong round; woken twice
  std::uint64_t rounds_played = 0;
  std::set<std::uint64_t> woken_in;            ///< rounds
  std::optional<std::uint64_t> asleep_before;  ///< the round it sleeps until it is called up
  std::set<std::uint64_t> calls;               ///< rounds that others have begun

  template <class Archive>
  void serialize(Archive& archive) {
    archive(rules, index, value, faults, rounds_played, woken_in, asleep_before, calls);
  }

  std::optional<graph::dataflow::Nothing> enter(graph::dataflow::NodeContext& context);
  std::optional<graph::dataflow::Nothing> woken(graph::dataflow::NodeContext& context, std::uint64_t round);
  void propose(graph::dataflow::NodeContext& context);
  void gather(graph::dataflow::NodeContext& context, std::uint64_t round, Values values);
  void scatter(graph::dataflow::NodeContext& context, std::uint64_t round, Values values);

  static graph::dataflow::Blueprint<Player> blueprint();

 private:
  GameValue packed_value(std::uint32_t to, std::uint64_t round) const;
  void take(std::uint64_t round, const Values& values);
};

/// The players' values at the end, by a loop over the rounds.
std::vector<std::uint64_t> play_by_hand(const GameRules& rules);

/// Makes this rank's players and sets them going; to be called in a run on every rank.
void start_game(graph::dataflow::Recording recording, engine::Context& context, GameRules rules);

}  // namespace weft::testing
