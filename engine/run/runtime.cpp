// The communication thread's loop.
#include "engine/run/runtime.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <sstream>
#include <thread>

#include "engine/base/text.h"
#include "engine/mpi/mpi_calls.h"
#include "engine/run/awake_clock.h"
#include "engine/run/snapshots.h"
#include "engine/schedule/scheduler.h"
#include "engine/schedule/termination.h"
#include "engine/trace/processor_time.h"

namespace weft::engine {
namespace {

using std::chrono::duration_cast;
using std::chrono::nanoseconds;

constexpr TimePoint kSecond = 1'000'000'000;
constexpr TimePoint kHeartbeatPeriod = kSecond;
constexpr TimePoint kPeerCheckPeriod = kSecond / 4;
// All that was sent has left its senders, and yet has not come: no network takes that long.
constexpr TimePoint kPatienceWithNetwork = 120 * kSecond;
// For the last words when a rank is dead: mpirun kills the others soon.
constexpr TimePoint kLastWords = kSecond / 5;
// The rank that is to report a broken network has so long to confirm that it did.
constexpr TimePoint kReportTime = kSecond;
constexpr std::size_t kWaitsShown = 50;
constexpr int kClockReadings = 5;

/// What the communication thread has worked: while it waits or workers have its core it takes none.
TimePoint communication_time() {
  const VirtualTime* simulated = VirtualTime::of_thread();
  return simulated ? simulated->communicated() : processor_time();
}

/// A millisecond.
void pause() {
  if (VirtualTime* simulated = VirtualTime::of_thread()) return simulated->spend(kSecond / 1000);
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

/// What a rank answers when rank 0 is asked for the time.
struct ClockReading {
  TimePoint asked = 0;
  TimePoint at_root = 0;
};

/// Why the run fails, and what follows.
struct Verdict {
  std::string what;
  Rank reporter;        ///< tells the user
  bool broken = false;  ///< a rank is dead: the network cannot be closed
  template <class Archive>
  void serialize(Archive& archive) {
    archive(what, reporter, broken);
  }
};

/// Of a rank and those below it in the tree. A later one has a higher number: packets may overtake each
/// other.
struct Bulletin {
  std::uint64_t number = 0;
  Payload said;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(number, said);
  }
};

/// A bulletin is joined with others more than once.
Payload copy_of(const Payload& payload) {
  Packer packer;  // leaves what it packs
  packer(payload);
  return unpacked<Payload>(packer.take());
}

}  // namespace

class Runtime::Implementation final : private BalanceActions {
 public:
  Implementation(Transport& transport, const Registry& registry, RuntimeOptions options)
      : options_(std::move(options)),
        transport_(transport),
        registry_(registry),
        exchange_(transport, options_.exchange, registry.fingerprint()),
        trace_(transport.rank(), transport.size(), options_.threads, options_.trace,
               options_.threads > 1 && !transport.virtual_time() ? options_.threads : 0),
        balancer_(options_.balancer(transport.rank(), transport.size())),
        scheduler_(
            {transport.rank(), transport.size(), options_.threads, options_.local,
             balancer_->wants_finished(), options_.name_of, options_.snapshots, transport.virtual_time()},
            registry, exchange_, trace_, [&transport] { transport.wake(); }) {
    if (options_.snapshots == nullptr) return;
    snapshots_.emplace(*options_.snapshots, scheduler_, transport.rank(), transport.size(),
                       [this](Rank to, const SnapshotMessage& message) {
                         exchange_.post(to, FrameKind::snapshot, packed(message));
                       });
  }

  ~Implementation() override {
    scheduler_.stop();
    while (!scheduler_.stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  void run(std::function<bool()> done, std::function<void(Context&)> root);
  void request_stop(const char* reason) noexcept {
    stop_reason_ = reason;
    transport_.wake();
  }
  void set_bulletins(Bulletins bulletins) {
    options_.bulletins = std::move(bulletins);
    bulletins_.clear();
  }
  Scheduler& scheduler() { return scheduler_; }
  void request_state() noexcept {
    state_requested_ = true;
    transport_.wake();
  }
  void visit(const TypeInfo& type, const std::function<void(ObjectId, void*)>& function) {
    scheduler_.visit(type, function);
  }
  RankSummary summary() const;
  std::int64_t clock_offset() const { return clock_offset_; }
  std::optional<RankTimeline> timeline() const {
    if (!trace_.keeps_spans()) return std::nullopt;
    return timeline_of(trace_, registry_.method_names(), clock_offset_);
  }
  using Join = std::function<Payload(Payload mine, Payload more)>;
  Payload gather(const std::function<Payload()>& mine, const Join& join);

  Rank rank() const override { return transport_.rank(); }
  int ranks() const override { return transport_.size(); }

 private:
  // The policy's actions.
  Load load() const override { return scheduler_.load(); }
  std::vector<ReadyObject> ready_objects() const override { return scheduler_.ready_objects(); }
  int ties(ObjectId id, Rank to) const override { return scheduler_.ties(id, to); }
  double load_of(Rank rank) const override { return exchange_.load_of(rank); }
  Rank most_loaded() const override { return exchange_.most_loaded(); }
  std::optional<double> move_seconds() const override { return scheduler_.move_seconds(); }
  void move(ObjectId id, Rank to) override { scheduler_.move(id, to); }
  void tell(Rank to, const BalanceMessage& message) override {
    exchange_.post(to, FrameKind::balance, packed(message));
  }
  void wake_when_ready(bool on) override { scheduler_.wake_when_ready(on); }

  void begin(std::function<bool()> done);
  void loop();
  bool turn(TimePoint time);
  void sleep();
  void receive(Rank from, FrameKind kind, Payload payload, std::size_t wire_bytes);
  void balance(TimePoint time);
  void detect_end();
  std::optional<WaveCount> count_if_passive();
  void watch_peers(TimePoint time);
  void tell_bulletin(TimePoint time);
  void hear_bulletin(Rank from, Bulletin bulletin);
  Payload joined_bulletins() const;
  void show_state(TimePoint time);
  void spread_notice();
  void notice_failures();
  void fail_here(const std::string& what);
  void network_failed(const std::string& what);
  void await_verdict();
  void declare_failure(Verdict verdict);
  void accept_verdict(Rank from, Verdict verdict);
  void tell_verdict();
  // A binary tree of ranks, for what goes to rank 0 and comes from it.
  Rank parent() const { return rank().value > 0 ? Rank((rank().value - 1) / 2) : Rank(); }
  std::vector<Rank> children() const {
    std::vector<Rank> those;
    for (int child = 2 * rank().value + 1; child <= 2 * rank().value + 2 && child < ranks(); ++child)
      those.push_back(Rank(child));
    return those;
  }
  Rank after() const { return Rank((rank().value + 1) % ranks()); }
  Rank before() const { return Rank((rank().value + ranks() - 1) % ranks()); }
  void peer_lost(const LostPeer& lost);
  void tell_waits();
  void receive_waits(std::vector<std::string> lines);
  void wind_down();
  void let_go();
  void await_report();
  RunFailure failure() const {
    return RunFailure(failure_->what, failure_->reporter == rank(), failure_->broken);
  }
  void read_clock();
  void tell_clock(Rank to, ClockReading reading);
  void progress_until(const std::function<bool()>& done);

  RuntimeOptions options_;
  Transport& transport_;
  const Registry& registry_;
  Exchange exchange_;
  Trace trace_;
  std::unique_ptr<Balancer> balancer_;
  Scheduler scheduler_;
  std::optional<Termination> termination_;
  std::optional<Snapshots> snapshots_;
  std::atomic<const char*> stop_reason_{nullptr};
  std::atomic<bool> state_requested_{false};

  // Of the current run.
  std::function<bool()> done_;  ///< of run_until(); empty: nobody knows
  bool ended_ = false;
  std::optional<std::string> failed_here_;  ///< rank 0 has been told, or is told by this
  TimePoint failed_at_ = 0;                 ///< by clock_
  std::optional<Verdict> failure_;
  bool reported_ = false;  ///< the rank that reports the failure has done so
  bool told_waits_ = false;
  bool told_leaving_ = false;
  bool notice_told_ = false;
  int waits_missing_ = 0;
  std::vector<std::string> waits_;
  TimePoint next_heartbeat_ = 0;
  TimePoint next_peer_check_ = 0;
  TimePoint next_bulletin_ = 0;
  TimePoint turn_ = 0;        ///< when the current turn looked at what is due
  TimePoint last_heard_ = 0;  ///< by clock_, from the rank before this one, or the run's begin
  TimePoint awake_since_ = 0;
  TimePoint begin_ = 0;

  // Of all runs, which are numbered alike on all ranks. The rank before this one may still be in one that
  // this rank has left. Outside of runs its silence means nothing.
  std::uint64_t run_ = 0;
  std::uint64_t before_in_ = 0;    ///< the last in which the rank before this one was heard to be
  std::uint64_t before_left_ = 0;  ///< the last that it has left
  AwakeClock clock_;
  TimePoint wall_ = 0;
  TimePoint communication_ = 0;       ///< processor time
  std::map<Rank, Payload> gathered_;  ///< by child
  std::optional<ClockReading> clock_reading_;
  bool clock_known_ = false;  ///< in this gathering: clock_offset_ has been read
  std::vector<std::pair<Rank, ClockReading>> asked_too_early_;
  std::int64_t clock_offset_ = 0;
  std::map<Rank, Bulletin> bulletins_;               ///< the latest of this rank and of each child
  std::uint64_t last_bulletin_ = 0;                  ///< number of the latest of this rank
  bool bulletin_is_due_ = false;                     ///< the parent does not know one of them
  std::vector<std::pair<std::string, long>> calls_;  ///< network calls in the loops
};

// --- The loop

void Runtime::Implementation::run(std::function<bool()> done, std::function<void(Context&)> root) {
  if (failure_) throw std::logic_error("a runtime whose run has failed cannot run again");
  const auto calls_before = transport_.calls();
  const TimePoint begin_time = now();
  begin(std::move(done));
  if (snapshots_) snapshots_->begin_run();
  scheduler_.start(std::move(root));
  loop();
  scheduler_.end_run();
  if (!done_) before_left_ = run_;  // it has ended for all
  transport_.end_phase();
  wall_ += now() - begin_time;
  for (auto [name, count] : transport_.calls()) {
    for (const auto& [known, before] : calls_before) count -= name == known ? before : 0;
    if (count == 0) continue;
    auto sum =
        std::find_if(calls_.begin(), calls_.end(), [&](const auto& entry) { return entry.first == name; });
    if (sum == calls_.end()) sum = calls_.insert(calls_.end(), {name, 0});
    sum->second += count;
  }
  if (failure_) throw failure();
}

void Runtime::Implementation::begin(std::function<bool()> done) {
  done_ = std::move(done);
  exchange_.begin_phase();
  // What the policies of two ranks last told each other may have been lost at the end of the last run.
  balancer_ = options_.balancer(rank(), ranks());
  scheduler_.wake_when_ready(false);
  termination_.emplace(rank(), ranks(), [this](Rank to, const WaveMessage& message) {
    exchange_.post(to, FrameKind::wave, packed(message));
  });
  ended_ = told_waits_ = told_leaving_ = notice_told_ = false;
  failed_here_.reset();
  waits_.clear();
  waits_missing_ = 0;
  last_heard_ = clock_.tick(now());
  ++run_;
  begin_ = next_heartbeat_ = next_peer_check_ = next_bulletin_ = awake_since_ = now();
}

void Runtime::Implementation::loop() {
  const TimePoint before = communication_time();
  while (!ended_ && !failure_) {
    bool busy = false;
    clock_.tick(now());
    try {
      busy = turn(now());
    } catch (const TransportError& error) {
      network_failed(error.what());
    } catch (const std::exception& error) {
      fail_here(text("the communication of rank ", rank().value, ": ", error.what()));
    }
    await_verdict();
    if (!busy && !ended_ && !failure_) sleep();
  }
  if (snapshots_) snapshots_->end_run();
  wind_down();
  communication_ += communication_time() - before;
}

bool Runtime::Implementation::turn(TimePoint time) {
  turn_ = time;
  if (const VirtualTime* simulated = transport_.virtual_time(); simulated && !simulated->communicates())
    return scheduler_.work_virtually();
  bool busy = exchange_.progress([this](Rank from, FrameKind kind, Payload payload, std::size_t wire_bytes) {
    receive(from, kind, std::move(payload), wire_bytes);
  });
  notice_failures();
  watch_peers(time);
  tell_bulletin(time);
  show_state(time);
  spread_notice();
  if (failed_here_) {  // unless the run had ended when a signal came
    ended_ = termination_->ended() && termination_->ended()->waiting == 0;
    return busy;
  }
  if (snapshots_) snapshots_->step();
  balance(time);
  busy |= scheduler_.send_migrants();
  busy |= scheduler_.work_virtually();
  detect_end();
  return busy;
}

/// Until something happens or is due.
void Runtime::Implementation::sleep() {
  const TimePoint time = now();
  TimePoint until = ranks() == 1 ? time + kPeerCheckPeriod : std::min(next_heartbeat_, next_peer_check_);
  if (options_.bulletins.period.count() > 0) until = std::min(until, next_bulletin_);
  for (const auto& next :
       {termination_->next_step(), balancer_->next_step(), scheduler_.next_virtual_step()}) {
    if (next && *next > turn_) until = std::min(until, *next);
  }
  trace_.communication_lane().span({awake_since_, time, {}, Span::kNoName, Activity::communicate, 0});
  transport_.wait(nanoseconds(std::max<TimePoint>(until - time, 0)));
  awake_since_ = now();
}

void Runtime::Implementation::receive(Rank from, FrameKind kind, Payload payload, std::size_t wire_bytes) {
  if (from == before()) last_heard_ = clock_.time();
  switch (kind) {
    case FrameKind::task:
      return scheduler_.receive_task(from, std::move(payload), wire_bytes);
    case FrameKind::object:
      return scheduler_.receive_object(from, std::move(payload), wire_bytes);
    case FrameKind::location:
      return scheduler_.receive_location(std::move(payload));
    case FrameKind::wave:
      return termination_->receive(from, unpacked<WaveMessage>(std::move(payload)));
    case FrameKind::balance:
      return balancer_->told(from, unpacked<BalanceMessage>(std::move(payload)), *this);
    case FrameKind::failure:
      if (ended_ && !done_) return;  // a signal came to a rank that had not heard yet
      return declare_failure({unpacked<std::string>(std::move(payload)), Rank(0), false});
    case FrameKind::stop:
    case FrameKind::broken:
      return accept_verdict(from, unpacked<Verdict>(std::move(payload)));
    case FrameKind::waits:
      return receive_waits(unpacked<std::vector<std::string>>(std::move(payload)));
    case FrameKind::heartbeat:
      before_in_ = std::max(before_in_, unpacked<std::uint64_t>(std::move(payload)));
      return;
    case FrameKind::leaving:
      before_left_ = std::max(before_left_, unpacked<std::uint64_t>(std::move(payload)));
      return;
    case FrameKind::bulletin:
      return hear_bulletin(from, unpacked<Bulletin>(std::move(payload)));
    case FrameKind::snapshot:
      if (!snapshots_) throw std::runtime_error("a rank takes snapshots, and this one does not");
      return snapshots_->receive(from, unpacked<SnapshotMessage>(std::move(payload)));
    case FrameKind::notice:
      if (options_.notice) options_.notice->store(true);  // and this rank passes it on
      return;
    case FrameKind::clock: {
      const auto reading = unpacked<ClockReading>(std::move(payload));
      if (from == parent()) {
        clock_reading_ = reading;
      } else if (clock_known_) {
        tell_clock(from, reading);
      } else {
        asked_too_early_.emplace_back(from, reading);
      }
      return;
    }
    case FrameKind::report:
      gathered_[from] = std::move(payload);
      return;
  }
  throw TransportError("a frame of an unknown kind has come");
}

void Runtime::Implementation::balance(TimePoint time) {
  exchange_.set_load(scheduler_.load().queued_seconds);
  if (balancer_->wants_finished()) {
    const std::vector<ObjectId> finished = scheduler_.take_finished();
    if (!finished.empty()) balancer_->finished(finished, *this);
  }
  // Who is idle between the messages of an exchange would ask all that it knows, in vain, each time.
  if (!done_) balancer_->step(*this, time);
}

// --- Looking on

/// Like all frames of the engine's own these are not counted: a run may end while one is on its way.
void Runtime::Implementation::tell_bulletin(TimePoint time) {
  const Bulletins& bulletins = options_.bulletins;
  if (bulletins.period.count() == 0 || time < next_bulletin_) return;
  next_bulletin_ = time + duration_cast<nanoseconds>(bulletins.period).count();
  const std::uint64_t number = ++last_bulletin_;
  if (Payload mine = bulletins.write(); mine.size() > 0) hear_bulletin(rank(), {number, std::move(mine)});
  if (!parent().valid()) return bulletins.read(joined_bulletins());
  if (std::exchange(bulletin_is_due_, false))
    exchange_.post(parent(), FrameKind::bulletin, packed(Bulletin{number, joined_bulletins()}));
}

void Runtime::Implementation::hear_bulletin(Rank from, Bulletin bulletin) {
  Bulletin& latest = bulletins_[from];
  if (bulletin.number <= latest.number) return;
  latest = std::move(bulletin);
  bulletin_is_due_ = true;
}

Payload Runtime::Implementation::joined_bulletins() const {
  Payload all;
  for (const auto& [from, bulletin] : bulletins_) {
    Payload said = copy_of(bulletin.said);
    all = all.size() == 0 ? std::move(said) : options_.bulletins.join(std::move(all), std::move(said));
  }
  return all;
}

void Runtime::Implementation::show_state(TimePoint time) {
  if (!state_requested_.exchange(false)) return;
  const TimePoint tenths = (time - begin_) / (kSecond / 10);
  std::string lines = text("state of rank ", rank().value, " of ", ranks(), ", ",
                           static_cast<double>(tenths) / 10, " s into the run\n");
  const Exchange::Traffic traffic = exchange_.traffic();
  lines += text("  messages: ", traffic.unsent, " bytes to be sent, ", traffic.unhandled,
                " received and not handled");
  for (const auto& [peer, bytes] : traffic.unconfirmed)
    lines += text(", ", bytes, " sent to rank ", peer.value, " and not confirmed");
  for (const std::string& line : scheduler_.state()) lines += "\n  " + line;
  options_.on_state(lines + "\n");
}

/// Told anew in each run: what was told at the end of one may have been dropped.
void Runtime::Implementation::spread_notice() {
  if (notice_told_ || !options_.notice || !options_.notice->load()) return;
  notice_told_ = true;
  if (parent().valid()) exchange_.post(parent(), FrameKind::notice, {});
  for (const Rank child : children()) exchange_.post(child, FrameKind::notice, {});
}

// --- The end

/// A rank whose messages have not all left is not passive: a large one may take long, and waves would be in
/// vain.
std::optional<WaveCount> Runtime::Implementation::count_if_passive() {
  if (!exchange_.idle()) return std::nullopt;
  const std::optional<WaveCount> count = scheduler_.passive_count();
  return count && (!done_ || done_()) ? count : std::nullopt;
}

void Runtime::Implementation::detect_end() {
  if (done_) {  // others may wait for what comes to them, but no more for this rank
    if (!count_if_passive()) return;
    ended_ = ranks() == 1 || std::exchange(told_leaving_, true);
    if (!ended_) exchange_.post(after(), FrameKind::leaving, packed(run_));
    return;
  }
  for (; termination_->due(turn_); turn_ = now()) {
    const std::optional<WaveCount> count = count_if_passive();
    if (!count) return;
    termination_->step(count, turn_);
  }
  // A simulated network loses nothing, and may be as slow as its user likes.
  if (!transport_.virtual_time() && termination_->futile_for() > kPatienceWithNetwork) {
    const WaveCount& sums = termination_->last_sums();
    fail_here(text("the network has lost messages: ", sums.sent, " were sent, ", sums.received, " received"));
  }
  if (!termination_->ended()) return;
  if (termination_->ended()->waiting == 0) {
    ended_ = true;
  } else if (!told_waits_) {
    tell_waits();
  }
}

/// Nothing runs, nothing flies, and objects wait: they will for ever. Rank 0 collects who waits for whom.
void Runtime::Implementation::tell_waits() {
  told_waits_ = true;
  std::vector<std::string> lines = scheduler_.waits();
  if (rank().value > 0) {
    exchange_.post(Rank(0), FrameKind::waits, packed(std::move(lines)));
  } else {
    waits_missing_ += ranks();
    receive_waits(std::move(lines));
  }
}

void Runtime::Implementation::receive_waits(std::vector<std::string> lines) {
  waits_.insert(waits_.end(), lines.begin(), lines.end());
  if (--waits_missing_ != 0) return;
  std::ostringstream what;
  what << "the run has stalled: no handler runs and no message is under way, but";
  for (std::size_t i = 0; i < std::min(waits_.size(), kWaitsShown); ++i) what << "\n  " << waits_[i];
  if (waits_.size() > kWaitsShown) what << "\n  and " << waits_.size() - kWaitsShown << " more";
  declare_failure({what.str(), Rank(0), false});
}

/// Lets the last frames out and the last handlers end.
void Runtime::Implementation::wind_down() {
  const TimePoint grace = duration_cast<nanoseconds>(options_.grace).count();
  const TimePoint begin_time = clock_.tick(now());
  while (!scheduler_.stopped() || !(failure_ ? exchange_.urgent_idle() : exchange_.idle())) {
    let_go();
    if (!failure_) continue;
    scheduler_.stop();
    const TimePoint patience = failure_->broken ? std::min(grace, kLastWords) : grace;
    if (clock_.tick(now()) - begin_time <= patience) continue;
    failure_->broken = true;
    break;
  }
  if (failure_ && failure_->broken) await_report();
  // A handler that does not stop cannot be unwound.
  if (!scheduler_.stopped()) transport_.abandon();
}

/// Receives and sends once more; what comes is of interest only if the run has not failed.
void Runtime::Implementation::let_go() {
  const auto receive_or_drop = [this](Rank from, FrameKind kind, Payload payload, std::size_t wire_bytes) {
    if (!failure_ || kind == FrameKind::stop || kind == FrameKind::broken)
      receive(from, kind, std::move(payload), wire_bytes);
  };
  try {
    if (!exchange_.progress(receive_or_drop)) transport_.wait(std::chrono::milliseconds(1));
  } catch (const TransportError& error) {
    network_failed(error.what());
    failure_->broken = true;
    pause();                               // it may fail at once, every time
  } catch (const std::exception& error) {  // something cannot be read; of interest only if all was well
    if (!failure_) network_failed(error.what());
  }
}

/// Whoever abandons the network may end all ranks: not before one has said why. If the one that is to does
/// not confirm (it may be dead, too, or do something else) this rank reports.
void Runtime::Implementation::await_report() {
  const TimePoint begin_time = clock_.tick(now());
  while (!reported_ && clock_.tick(now()) - begin_time < kReportTime) let_go();
  if (reported_) return;
  failure_->reporter = rank();
  if (options_.on_failure) options_.on_failure(failure_->what);
}

// --- Failure

void Runtime::Implementation::notice_failures() {
  if (const auto failure = scheduler_.failure()) fail_here(*failure);
  if (const char* reason = stop_reason_) {
    // When a rank dies, mpirun stops the others by a signal: the cause is the better message.
    if (const auto lost = transport_.lost_peer()) return peer_lost(*lost);
    fail_here(reason);
  }
}

/// Rank 0 decides which of several failures it was.
void Runtime::Implementation::fail_here(const std::string& what) {
  if (failed_here_) return;
  failed_here_ = what;
  failed_at_ = clock_.time();
  scheduler_.stop();
  if (rank().value == 0) {
    declare_failure({what, Rank(0), false});
  } else {
    exchange_.post(Rank(0), FrameKind::failure, packed(what));
    exchange_.hear_later_failures();
  }
}

/// Nothing may come through any more, so this rank does not wait for rank 0 to decide.
void Runtime::Implementation::network_failed(const std::string& what) {
  declare_failure({text("the network fails on rank ", rank().value, ": ", what), rank(), true});
}

/// Rank 0 may be in no run, or what it says does not get here.
void Runtime::Implementation::await_verdict() {
  if (!failed_here_ || failure_ || ended_) return;
  if (clock_.time() - failed_at_ > duration_cast<nanoseconds>(options_.grace).count())
    declare_failure({*failed_here_, rank(), true});
}

void Runtime::Implementation::declare_failure(Verdict verdict) {
  if (failure_) return;
  accept_verdict(rank(), std::move(verdict));
  if (failure_->reporter != rank() || !failure_->broken) tell_verdict();
}

void Runtime::Implementation::accept_verdict(Rank from, Verdict verdict) {
  reported_ = reported_ || from == (failure_ ? failure_->reporter : verdict.reporter);
  if (failure_) return;
  failure_ = std::move(verdict);
  scheduler_.stop();  // at once: no handler may begin after run() has thrown
  // Others may wait in this run for what this rank has not sent, and never come to the one that has failed.
  if (exchange_.later_phase_failed()) tell_verdict();
  if (failure_->reporter != rank()) return;
  if (options_.on_failure) options_.on_failure(failure_->what);
  if (failure_->broken) tell_verdict();  // which confirms that it is reported
}

void Runtime::Implementation::tell_verdict() {
  const FrameKind kind = failure_->broken ? FrameKind::broken : FrameKind::stop;
  for (int r = 0; r < ranks(); ++r) {
    if (r != rank().value) exchange_.post(Rank(r), kind, packed(*failure_));
  }
}

void Runtime::Implementation::watch_peers(TimePoint time) {
  if (ranks() == 1 || time < std::min(next_heartbeat_, next_peer_check_)) return;
  if (time >= next_heartbeat_) {
    exchange_.post(after(), FrameKind::heartbeat, packed(run_));
    next_heartbeat_ = time + kHeartbeatPeriod;
  }
  next_peer_check_ = time + kPeerCheckPeriod;
  if (const auto lost = transport_.lost_peer()) return peer_lost(*lost);
  const TimePoint silence = duration_cast<nanoseconds>(options_.silence).count();
  const bool expected = before_in_ > before_left_;
  if (expected && clock_.time() - last_heard_ > silence && !transport_.watches(before())) {
    peer_lost({before(), "died: it has been silent for too long"});
  }
}

/// Rank 0 may be the one: whoever notices tells all.
void Runtime::Implementation::peer_lost(const LostPeer& lost) {
  declare_failure(
      {text("rank ", lost.rank.value, " ", lost.how), Rank(lost.rank.value == 0 ? 1 : 0), !lost.will_close});
}

// --- After the loop

RankSummary Runtime::Implementation::summary() const {
  RunFacts facts;
  facts.wall = static_cast<double>(wall_) * 1e-9;
  facts.communication = static_cast<double>(communication_) * 1e-9;
  facts.method_names = registry_.method_names();
  facts.network_calls = calls_;
  for (const auto& [name, count] : calls_) facts.collective_calls += is_collective(name) ? count : 0;
  facts.counters["packets_sent"] = static_cast<double>(exchange_.packets_sent());
  facts.counters["objects_in"] = static_cast<double>(scheduler_.moved_in());
  facts.counters["objects_out"] = static_cast<double>(scheduler_.moved_out());
  facts.counters["snapshot_seconds"] = static_cast<double>(scheduler_.copying()) * 1e-9;
  if (transport_.virtual_time() != nullptr)
    facts.counters["core_wait_seconds"] = static_cast<double>(scheduler_.waited_for_cores()) * 1e-9;
  facts.counters["handlers"] = static_cast<double>(scheduler_.handled());
  return summarize(trace_, facts);
}

/// Up the tree: each rank joins what its children have gathered to its own. Empty but on rank 0.
Payload Runtime::Implementation::gather(const std::function<Payload()>& mine, const Join& join) {
  exchange_.begin_phase();
  gathered_.clear();
  clock_known_ = false;
  read_clock();
  const std::vector<Rank> below = children();
  progress_until([&] { return gathered_.size() == below.size(); });
  Payload all = mine();
  for (const Rank child : below) all = join(std::move(all), std::move(gathered_.at(child)));
  if (parent().valid()) {
    exchange_.post(parent(), FrameKind::report, std::exchange(all, {}));
    progress_until([this] { return exchange_.idle(); });
  }
  transport_.end_phase();
  return all;
}

/// How far rank 0's clock is ahead of this one, as the parent knows it: the answer that came soonest is the
/// most exact.
void Runtime::Implementation::read_clock() {
  TimePoint shortest = kSecond;
  for (int i = 0; i < kClockReadings && parent().valid(); ++i) {
    clock_reading_.reset();
    exchange_.post(parent(), FrameKind::clock, packed(ClockReading{now(), 0}));
    progress_until([this] { return clock_reading_.has_value(); });
    const TimePoint time = now();
    if (time - clock_reading_->asked >= shortest) continue;
    shortest = time - clock_reading_->asked;
    clock_offset_ = clock_reading_->at_root - (clock_reading_->asked + shortest / 2);
  }
  clock_known_ = true;
  for (const auto& [child, reading] : std::exchange(asked_too_early_, {})) tell_clock(child, reading);
}

void Runtime::Implementation::tell_clock(Rank to, ClockReading reading) {
  reading.at_root = now() + clock_offset_;
  exchange_.post(to, FrameKind::clock, packed(reading));
}

void Runtime::Implementation::progress_until(const std::function<bool()>& done) {
  const auto keep = [this](Rank from, FrameKind kind, Payload payload, std::size_t wire_bytes) {
    receive(from, kind, std::move(payload), wire_bytes);
  };
  for (TimePoint next_check = now() + kPeerCheckPeriod; !done();) {
    try {
      if (!exchange_.progress(keep) && !done()) transport_.wait(std::chrono::milliseconds(1));
      if (!failure_ && now() < next_check) continue;
      next_check = now() + kPeerCheckPeriod;
      if (const auto lost = transport_.lost_peer()) peer_lost(*lost);
      if (const char* reason = stop_reason_) declare_failure({reason, rank(), false});
    } catch (const TransportError& error) {
      network_failed(error.what());
    }
    if (!failure_) continue;
    wind_down();
    throw failure();
  }
}

// --- The public face

Runtime::Runtime(Transport& transport, const Registry& registry, RuntimeOptions options)
    : registry_(registry),
      implementation_(std::make_unique<Implementation>(transport, registry, std::move(options))) {}

Runtime::~Runtime() = default;

Rank Runtime::rank() const { return implementation_->rank(); }
int Runtime::ranks() const { return implementation_->ranks(); }
void Runtime::run(std::function<void(Context&)> root) { implementation_->run({}, std::move(root)); }
void Runtime::run_until(std::function<bool()> done, std::function<void(Context&)> root) {
  implementation_->run(std::move(done), std::move(root));
}
void Runtime::set_bulletins(Bulletins bulletins) { implementation_->set_bulletins(std::move(bulletins)); }
void Runtime::request_stop(const char* reason) noexcept { implementation_->request_stop(reason); }
void Runtime::request_state() noexcept { implementation_->request_state(); }
void Runtime::restore_location(ObjectId id, Rank at) {
  implementation_->scheduler().restore_location(id, at);
}
void Runtime::restore_object(Payload copy) { implementation_->scheduler().restore_object(std::move(copy)); }
void Runtime::restore_message(Payload copy) { implementation_->scheduler().restore_message(std::move(copy)); }
RankSummary Runtime::summary() const { return implementation_->summary(); }
std::int64_t Runtime::clock_offset() const { return implementation_->clock_offset(); }
std::optional<RankTimeline> Runtime::timeline() const { return implementation_->timeline(); }

void Runtime::visit(const TypeInfo& type, const std::function<void(ObjectId, void*)>& function) {
  implementation_->visit(type, function);
}

namespace {

/// Payloads of several ranks as one.
Payload append(Payload mine, Payload more) {
  auto all = unpacked<std::vector<Payload>>(std::move(mine));
  for (Payload& one : unpacked<std::vector<Payload>>(std::move(more))) all.push_back(std::move(one));
  return packed(std::move(all));
}

/// Of one or none.
template <class T>
Payload list_of(std::optional<T> one) {
  std::vector<Payload> list;
  if (one) list.push_back(packed(*std::move(one)));
  return packed(std::move(list));
}

/// By rank.
template <class T>
std::vector<T> opened(Payload list) {
  std::vector<T> all;
  if (list.size() == 0) return all;
  for (Payload& one : unpacked<std::vector<Payload>>(std::move(list)))
    all.push_back(unpacked<T>(std::move(one)));
  std::ranges::sort(all, {}, &T::rank);
  return all;
}

}  // namespace

std::vector<RankSummary> Runtime::gather_summaries() {
  return opened<RankSummary>(
      implementation_->gather([this] { return list_of(std::optional(summary())); }, append));
}

std::vector<RankTimeline> Runtime::gather_timelines() {
  return opened<RankTimeline>(implementation_->gather([this] { return list_of(timeline()); }, append));
}

RunSummary Runtime::gather_sums() {
  Payload sums = implementation_->gather(
      [this] { return packed(run_of(summary(), false)); },
      [](Payload mine, Payload more) {
        return packed(join(unpacked<RunSummary>(std::move(mine)), unpacked<RunSummary>(std::move(more))));
      });
  return sums.size() == 0 ? RunSummary{} : unpacked<RunSummary>(std::move(sums));
}

void print_failure(const std::string& what) {
  std::fprintf(stderr, "error: %s\n", what.c_str());
  std::fflush(stderr);
}

void print_state(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace weft::engine
