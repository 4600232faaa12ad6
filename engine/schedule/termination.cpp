// The waves.
#include "engine/schedule/termination.h"

#include <algorithm>
#include <utility>

namespace weft::engine {
namespace {

// A message in flight ends a wave in vain; the next should not come before it can have arrived, nor much
// later.
constexpr TimePoint kShortestBackoff = 50'000;
constexpr TimePoint kLongestBackoff = 5'000'000;
constexpr TimePoint kMostOfOneWave = 1'000'000'000;

WaveCount operator+(const WaveCount& a, const WaveCount& b) {
  return {a.sent + b.sent, a.received + b.received, a.waiting + b.waiting};
}

}  // namespace

Termination::Termination(Rank rank, int ranks, Send send)
    : rank_(rank), ranks_(ranks), send_(std::move(send)), backoff_(kShortestBackoff) {
  if (rank_.value == 0) next_wave_ = 0;
}

template <class Visit>
void Termination::each_child(Visit visit) const {
  for (int child = 2 * rank_.value + 1; child <= 2 * rank_.value + 2 && child < ranks_; ++child)
    visit(Rank(child));
}

void Termination::start_wave() {
  probed_ = true;
  sums_ = {};
  reports_missing_ = 0;
  each_child([&](Rank child) {
    ++reports_missing_;
    send_(child, {WaveMessage::Kind::probe, wave_, {}});
  });
}

void Termination::receive(Rank, const WaveMessage& message) {
  switch (message.kind) {
    case WaveMessage::Kind::probe:
      wave_ = message.wave;
      start_wave();
      break;
    case WaveMessage::Kind::report:
      --reports_missing_;
      sums_ = sums_ + message.count;
      break;
    case WaveMessage::Kind::ended:
      end(message.count);
      break;
  }
}

void Termination::step(const std::optional<WaveCount>& count, TimePoint time) {
  if (ended_ || !count) return;
  if (next_wave_ && time >= *next_wave_) {
    next_wave_.reset();
    ++wave_;
    start_wave();
  }
  if (!probed_ || reports_missing_ > 0) return;
  probed_ = false;
  sums_ = sums_ + *count;
  if (rank_.value > 0) {
    send_(Rank((rank_.value - 1) / 2), {WaveMessage::Kind::report, wave_, sums_});
  } else {
    finish_wave(time);
  }
}

void Termination::finish_wave(TimePoint time) {
  const bool ended = has_previous_ && sums_.sent == previous_.received;
  const bool same = has_previous_ && sums_.sent == previous_.sent && sums_.received == previous_.received;
  futile_for_ = same && !ended ? futile_for_ + std::min(time - last_back_, kMostOfOneWave) : 0;
  last_back_ = time;
  previous_ = sums_;
  has_previous_ = true;
  if (ended) return end(sums_);
  // All that was sent has arrived: probably the end, and the next wave proves it. Otherwise let it arrive
  // first.
  const bool wait = sums_.sent != sums_.received;
  backoff_ = same ? std::min(2 * backoff_, kLongestBackoff) : kShortestBackoff;
  next_wave_ = wait ? time + backoff_ : time;
}

void Termination::end(const WaveCount& sums) {
  ended_ = sums;
  each_child([&](Rank child) { send_(child, {WaveMessage::Kind::ended, wave_, sums}); });
}

}  // namespace weft::engine
