// Lanes: counting, and keeping of spans.
#include "engine/trace/trace.h"

namespace weft::engine {
namespace {

/// The place of a method in a lane's tables; kNoName + 1 wraps to 0.
std::size_t place_of(std::uint32_t name) { return static_cast<std::uint32_t>(name + 1); }
static_assert(Span::kNoName + 1 == 0);

/// Entry `place`, made if need be.
template <class Table>
typename Table::value_type& grown(Table& table, std::size_t place) {
  if (place >= table.size()) table.resize(place + 1);
  return table[place];
}

/// Entry `place`, or an empty one.
template <class Table>
typename Table::value_type entry(const Table& table, std::size_t place) {
  return place < table.size() ? table[place] : typename Table::value_type{};
}

}  // namespace

const char* name_of(Activity activity) {
  static constexpr std::array<const char*, kActivities> kNames = {"compute", "unpack", "pack", "communicate",
                                                                  "help"};
  return kNames[static_cast<std::size_t>(activity)];
}

const char* name_of(Traffic traffic) {
  static constexpr std::array<const char*, kTraffics> kNames = {"invoke", "signal", "migrate", "forward"};
  return kNames[static_cast<std::size_t>(traffic)];
}

Lane::Lane(int ranks, TraceOptions options)
    : keeps_spans_(options.spans),
      volume_by_peer_(static_cast<std::size_t>(ranks)),
      spans_(options.max_spans_per_lane),
      departures_(options.max_spans_per_lane) {}

void Lane::span(const Span& span) {
  const std::int64_t nanoseconds = std::max<std::int64_t>(span.end - span.begin, 0);
  time_[static_cast<std::size_t>(span.activity)].add(nanoseconds);
  if (span.activity == Activity::compute) grown(compute_by_method_, place_of(span.name)).add(nanoseconds);
  if (keeps_spans_) spans_.add(span);
}

void Lane::departure(Departure departure) {
  if (keeps_spans_) departures_.add(departure);
}

void Lane::sent(Traffic traffic, std::uint32_t name, Rank peer, std::uint64_t bytes) {
  count_message(&Volume::sent, traffic, name, peer, bytes);
}

void Lane::received(Traffic traffic, std::uint32_t name, Rank peer, std::uint64_t bytes) {
  count_message(&Volume::received, traffic, name, peer, bytes);
}

void Lane::count_message(MessageCount Volume::*direction, Traffic traffic, std::uint32_t name, Rank peer,
                         std::uint64_t bytes) {
  (volume_[static_cast<std::size_t>(traffic)].*direction).add(bytes);
  (grown(volume_by_method_, place_of(name)).*direction).add(bytes);
  if (peer.valid() && peer.index() < volume_by_peer_.size())
    (volume_by_peer_[peer.index()].*direction).add(bytes);  // no rank: in the totals only
}

TimeCount Lane::compute_time(std::uint32_t name) const { return entry(compute_by_method_, place_of(name)); }
Volume Lane::volume(std::uint32_t name) const { return entry(volume_by_method_, place_of(name)); }
Volume Lane::volume(Rank peer) const {
  const Volume* volume = peer.valid() ? volume_by_peer_.find(peer.index()) : nullptr;
  return volume == nullptr ? Volume{} : *volume;
}

std::uint32_t Lane::num_methods() const {
  const std::size_t places = std::max(compute_by_method_.size(), volume_by_method_.size());
  return places == 0 ? 0 : static_cast<std::uint32_t>(places - 1);
}

Trace::Trace(Rank rank, int ranks, int workers, TraceOptions options, int helpers)
    : rank_(rank), ranks_(ranks), workers_(workers), keeps_spans_(engine::keeps_spans(rank, ranks, options)) {
  options.spans = keeps_spans_;
  const int lanes = 1 + workers + helpers;
  lanes_.reserve(static_cast<std::size_t>(lanes));
  for (int i = 0; i < lanes; ++i) lanes_.emplace_back(ranks, options);
}

}  // namespace weft::engine
