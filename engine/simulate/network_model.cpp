// Words to numbers; links one after the other.
#include "engine/simulate/network_model.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "engine/base/text.h"

namespace weft::engine {
namespace {

constexpr double kTaper = 2;
constexpr int kMostSwitchRanks = 100'000;

struct Unit {
  std::string_view name;
  double value;
};

/// What a network may be: slower ones would let a rank's clock leave what it can count.
struct Range {
  double least, most;  ///< in the unit of value 1
  std::string_view words;
};

double number_with_unit(std::string_view word, std::initializer_list<Unit> units, const Range& range) {
  std::string_view rest = word;
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  if (rest.starts_with('+')) rest.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  for (const Unit& unit : units)
    if (rest == unit.name && error == std::errc() && number > 0 && std::isfinite(number)) {
      if (number * unit.value >= range.least && number * unit.value <= range.most) return number * unit.value;
      throw std::invalid_argument(text("'", word, "' is not between ", range.words));
    }
  throw std::invalid_argument(text("'", word, "' is not a positive number with one of the units ",
                                   std::data(units)[1].name, " to ",
                                   std::data(units)[units.size() - 1].name));
}

struct NamedTopology {
  std::string_view name;
  Topology topology;
  std::string_view of;  ///< what has N ranks
};
constexpr NamedTopology kTopologies[] = {{"tree", Topology::tree, "switch"},
                                         {"fat-tree", Topology::fat_tree, "switch"},
                                         {"dragonfly", Topology::dragonfly, "router"}};

void read_topology(std::string_view word, NetworkModel& network) {
  if (word == "flat") return;
  const std::size_t colon = std::min(word.find(':'), word.size());
  for (const NamedTopology& known : kTopologies) {
    if (word.substr(0, colon) != known.name || colon == word.size()) continue;
    const auto [end, error] =
        std::from_chars(word.data() + colon + 1, word.data() + word.size(), network.switch_ranks);
    if (error != std::errc() || end != word.data() + word.size() || network.switch_ranks <= 0) break;
    if (network.switch_ranks > kMostSwitchRanks)
      throw std::invalid_argument(
          text("'", word, "' has more than ", kMostSwitchRanks, " ranks a ", known.of));
    network.topology = known.topology;
    return;
  }
  throw std::invalid_argument(
      text("'", word,
           "' is no topology: flat, tree:N or fat-tree:N for N ranks a switch, dragonfly:N for N "
           "ranks a router"));
}

std::int64_t whole_nanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::llround(1e9 * seconds));
}

/// Passes a packet through a link that is free from `free` on.
std::int64_t pass(std::int64_t& free, std::int64_t time, std::int64_t takes) {
  return free = std::max(free, time) + takes;
}

}  // namespace

NetworkModel parse_network(std::string_view text_) {
  std::vector<std::string_view> words;
  for (std::size_t begin = 0; begin <= text_.size();) {
    const std::size_t end = std::min(text_.find(',', begin), text_.size());
    words.push_back(text_.substr(begin, end - begin));
    begin = end + 1;
  }
  if (words.size() < 2 || words.size() > 3)
    throw std::invalid_argument(text(
        "'", text_, "' is not LATENCY,BANDWIDTH[,flat|tree:N|fat-tree:N|dragonfly:N], as in 2us,10GB/s"));
  NetworkModel network;
  network.latency = number_with_unit(words[0], {{"", 1}, {"ns", 1e-9}, {"us", 1e-6}, {"ms", 1e-3}, {"s", 1}},
                                     {1e-12, 10, "1e-12 and 10 s"});
  network.bandwidth =
      number_with_unit(words[1], {{"", 1}, {"B/s", 1}, {"MB/s", 1e6}, {"GB/s", 1e9}, {"Gbit/s", 1.25e8}},
                       {1e3, 1e15, "1000 and 1e15 B/s"});
  if (words.size() == 3) read_topology(words[2], network);
  return network;
}

std::string text_of(const NetworkModel& network) {
  std::string words = text(network.latency * 1e6, " us, ", network.bandwidth * 1e-9, " GB/s");
  if (network.topology == Topology::tree)
    words += text(", ", network.switch_ranks, " ranks a switch, uplinks of half");
  for (const NamedTopology& known : kTopologies)
    if (has_flows(known.topology) && known.topology == network.topology)
      words += text(", ", known.name, " of SimGrid, ", network.switch_ranks, " ranks a ", known.of);
  return words;
}

NetworkLinks::NetworkLinks(const NetworkModel& network, int ranks)
    : network_(network), ports_(static_cast<std::size_t>(ranks)) {
  if (network.topology == Topology::tree)
    uplinks_.resize(static_cast<std::size_t>((ranks + network.switch_ranks - 1) / network.switch_ranks));
}

/// Cut-through: the first byte goes on while the last one is still coming, so a packet's length counts once
/// where all links are free.
std::int64_t NetworkLinks::send(Rank from, Rank to, std::size_t bytes, std::int64_t time) {
  if (from == to) return time;
  const std::int64_t length = whole_nanoseconds(static_cast<double>(bytes) / network_.bandwidth);
  const std::int64_t on_port = whole_nanoseconds(network_.gap) + length;
  const std::int64_t latency = whole_nanoseconds(network_.latency);
  std::int64_t last = pass(ports_[from.index()].out, time, on_port);  // the last byte has left
  const auto switch_index = [&](Rank rank) {
    return rank.index() / static_cast<std::size_t>(network_.switch_ranks);
  };
  if (network_.topology == Topology::tree && switch_index(from) != switch_index(to)) {
    const double uplink = network_.bandwidth * network_.switch_ranks / kTaper;
    const std::int64_t on_uplink = whole_nanoseconds(static_cast<double>(bytes) / uplink);
    last = std::max(last, pass(uplinks_[switch_index(from)].out, last - on_uplink, on_uplink));
    last = std::max(last, pass(uplinks_[switch_index(to)].in, last - on_uplink, on_uplink)) + latency;
  }
  return std::max(last + latency, pass(ports_[to.index()].in, last + latency - on_port, on_port));
}

}  // namespace weft::engine
