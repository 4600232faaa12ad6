// Snapshots while objects work, send and move: nothing is in them twice, nothing is missing, and a run on
// other ranks goes on from them.
#include "engine/schedule/snapshot.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>

#include "engine/objects/cell.h"
#include "engine/run/runtime.h"
#include "engine/simulate/simulation.h"
#include "tests/support/ranks.h"

namespace weft::engine::snapshot_test {
namespace {

using namespace std::chrono_literals;
using weft::testing::delayed;
using weft::testing::on_ranks;

constexpr int kAccounts = 12, kChains = 30, kHops = 600 / weft::testing::kSlowness + 20;
constexpr long kMoney = 1000;

/// Passes on what it gets, and some of its own, until the chain has made its hops.
struct Account {
  std::vector<ObjectId> all;
  long money = 0, handled = 0;
  std::vector<double> ballast;  // so that it has segments

  template <class Archive>
  void serialize(Archive& archive) {
    archive(all, money, handled, ballast);
  }

  void open(Context&, const std::vector<ObjectId>& accounts) {
    all = accounts;
    money = kMoney;
    ballast.assign(3000, 1.5);
  }

  void give(Context& context, long amount, int hops_left) {
    money += amount;
    ++handled;
    if (hops_left == 0) return;
    const long next = money / 3;
    money -= next;
    const auto to = static_cast<std::size_t>(31 * handled + 7 * hops_left) % all.size();
    context.invoke<&Account::give>(MobilePtr<Account>{all[to]}, next, hops_left - 1);
  }
};

Registry accounts() {
  Registry registry;
  registry.type<Account>("Account").method<&Account::open>("open").method<&Account::give>("give");
  return registry;
}

/// What has been copied, of all ranks: those of a test are threads of this process.
struct Copies {
  std::vector<Payload> objects, messages;
};
class Archive {
 public:
  std::mutex mutex;
  std::map<std::uint64_t, Copies> epochs;
  std::set<std::uint64_t> whole;
};

class MemorySink : public SnapshotSink {
 public:
  explicit MemorySink(Archive& archive) : archive_(archive) {}
  bool wanted() override { return !std::exchange(pending_, true); }
  void object(std::uint64_t epoch, Payload copy) override {
    const std::lock_guard lock(archive_.mutex);
    archive_.epochs[epoch].objects.push_back(std::move(copy));
  }
  void message(std::uint64_t epoch, Payload copy) override {
    const std::lock_guard lock(archive_.mutex);
    archive_.epochs[epoch].messages.push_back(std::move(copy));
  }
  void close(std::uint64_t) override {}
  std::optional<bool> stored(std::uint64_t) override { return true; }
  void finish(std::uint64_t epoch, bool whole) override {
    const std::lock_guard lock(archive_.mutex);
    if (whole) archive_.whole.insert(epoch);
    pending_ = false;
  }
  void give_up() override { pending_ = false; }

 private:
  Archive& archive_;
  bool pending_ = false;
};

RuntimeOptions options_of(SnapshotSink& sink, int threads) {
  RuntimeOptions options;
  options.threads = threads;
  options.balancer = rotate();
  options.snapshots = &sink;
  return options;
}

/// Money and handled messages of all accounts that are here.
void add_up(Runtime& runtime, std::atomic<long>& money, std::atomic<long>& handled) {
  runtime.visit<Account>([&](MobilePtr<Account>, Account& account) {
    money += account.money;
    handled += account.handled;
  });
}

void start(Context& context) {
  if (context.rank() != Rank(0)) return;
  std::vector<ObjectId> all;
  for (int i = 0; i < kAccounts; ++i) all.push_back(context.create<Account>().id);
  for (const ObjectId id : all) context.invoke<&Account::open>(MobilePtr<Account>{id}, all);
  for (int c = 0; c < kChains; ++c)
    context.invoke<&Account::give>(MobilePtr<Account>{all[static_cast<std::size_t>(c) % all.size()]}, 0L,
                                   kHops);
}

void run_once(int ranks, int threads, Archive& archive) {
  std::atomic<long> money = 0, handled = 0;
  on_ranks(ranks, [&](Transport& network) {
    const auto transport = delayed(network, 300us, 7);
    const Registry registry = accounts();
    MemorySink sink(archive);
    Runtime runtime(*transport, registry, options_of(sink, threads));
    runtime.run(start);
    add_up(runtime, money, handled);
  });
  EXPECT_EQ(money, kAccounts * kMoney);
  EXPECT_EQ(handled, kChains * (kHops + 1));
}

/// A run of some milliseconds on a busy machine may be over before its first snapshot is.
void run_with_snapshots(int ranks, int threads, Archive& archive) {
  for (int attempts = 0; attempts < 50 && archive.whole.empty(); ++attempts) {
    archive.epochs.clear();
    run_once(ranks, threads, archive);
  }
  ASSERT_FALSE(archive.whole.empty());
}

Payload copy_of(const Payload& payload) {
  Packer packer;
  packer(const_cast<Payload&>(payload));
  Unpacker unpacker(packer.take());
  Payload copy;
  unpacker(copy);
  return copy;
}

long money_of(Task task) {
  if (task.payload.bytes.size() != sizeof(long) + sizeof(int)) return 0;  // it opens the account
  Unpacker unpacker(std::move(task.payload));
  long amount = 0;
  int hops = 0;
  unpacker(amount, hops);
  return amount;
}

/// What the accounts have, what waits for them, and what was on its way.
long money_in(const Copies& copies) {
  long sum = 0;
  for (const Payload& payload : copies.objects) {
    auto cell = unpacked<PackedCell>(copy_of(payload));
    sum += unpacked<Account>(std::move(cell.object)).money;
    for (Task& task : cell.mailbox) sum += money_of(std::move(task));
    for (auto& [sender, inbound] : cell.inbound)
      for (auto& [sequence, task] : inbound.held) sum += money_of(std::move(task));
  }
  for (const Payload& payload : copies.messages) sum += money_of(unpacked<Task>(copy_of(payload)));
  return sum;
}

bool is_open(const Copies& copies) {
  for (const Payload& payload : copies.objects)
    if (unpacked<Account>(std::move(unpacked<PackedCell>(copy_of(payload)).object)).all.empty()) return false;
  return true;
}

class SnapshotsOnRanks : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    if (weft::testing::is_distributed()) GTEST_SKIP() << "the copies of all ranks are looked at together";
  }
};
INSTANTIATE_TEST_SUITE_P(Ranks, SnapshotsOnRanks, ::testing::Values(1, 2, 3, 8),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

TEST_P(SnapshotsOnRanks, EachHasAllObjectsOnceAndAllMoney) {
  Archive archive;
  run_with_snapshots(GetParam(), 2, archive);
  for (const std::uint64_t epoch : archive.whole) {
    const Copies& copies = archive.epochs[epoch];
    EXPECT_EQ(copies.objects.size(), kAccounts);
    if (!is_open(copies)) continue;
    EXPECT_EQ(money_in(copies), kAccounts * kMoney) << "epoch " << epoch;
  }
}

/// From the middle one, on each other number of ranks; snapshots are taken there again.
TEST_P(SnapshotsOnRanks, ARunOnOtherRanksGoesOnFromThem) {
  Archive archive;
  run_with_snapshots(GetParam(), 1, archive);
  if (HasFatalFailure()) return;
  const Copies& copies = archive.epochs[*std::next(archive.whole.begin(), archive.whole.size() / 2)];
  for (const int ranks : {1, 2, 5}) {
    std::atomic<long> money = 0, handled = 0;
    Archive again;
    on_ranks(ranks, [&](Transport& transport) {
      const Registry registry = accounts();
      MemorySink sink(again);
      Runtime runtime(transport, registry, options_of(sink, 1));
      const auto place_of = [&](ObjectId id) { return Rank(static_cast<int>(id.number) % ranks); };
      const auto id_of = [](const Payload& p) {
        ObjectId id;
        std::memcpy(&id, p.bytes.data(), sizeof id);
        return id;
      };
      for (const Payload& p : copies.objects) runtime.restore_location(id_of(p), place_of(id_of(p)));
      for (const Payload& p : copies.objects)
        if (place_of(id_of(p)) == transport.rank()) runtime.restore_object(copy_of(p));
      for (const Payload& p : copies.messages)
        if (place_of(id_of(p)) == transport.rank()) runtime.restore_message(copy_of(p));
      runtime.run();
      runtime.run([&](Context& context) {  // whose root is none of the run that the accounts come from
        for (const Payload& p : copies.objects)
          if (context.rank() == Rank(0)) context.invoke<&Account::give>(MobilePtr<Account>{id_of(p)}, 0L, 0);
      });
      add_up(runtime, money, handled);
    });
    EXPECT_EQ(money, kAccounts * kMoney) << ranks;
    EXPECT_EQ(handled, kChains * (kHops + 1) + kAccounts) << ranks;
    for (const std::uint64_t epoch : again.whole) EXPECT_EQ(again.epochs[epoch].objects.size(), kAccounts);
  }
}

/// Wishes on rank 0 alone; never stores anything before it is told to.
class SlowSink final : public MemorySink {
 public:
  SlowSink(Archive& archive, Rank rank) : MemorySink(archive), rank_(rank) {}
  bool wanted() override { return rank_ == Rank(0) && MemorySink::wanted(); }
  std::optional<bool> stored(std::uint64_t epoch) override {
    if (!stores) return {};
    return MemorySink::stored(epoch);
  }

  bool stores = false;

 private:
  const Rank rank_;
};

/// The other ranks have stored their parts of a snapshot when the run ends, the last one has not.
TEST_P(SnapshotsOnRanks, ARunTakesThemThoughTheOneBeforeDidNotFinishIts) {
  Archive archive;
  on_ranks(GetParam(), [&](Transport& transport) {
    const Registry registry = accounts();
    SlowSink sink(archive, transport.rank());
    sink.stores = transport.rank().value < GetParam() - 1;
    Runtime runtime(transport, registry, options_of(sink, 1));
    runtime.run(start);
    sink.stores = true;
    for (int attempt = 0; attempt < 50; ++attempt) {  // each may be over before its first snapshot is
      runtime.run([](Context& context) {
        for (std::uint32_t a = 1; context.rank() == Rank(0) && a <= kAccounts; ++a)
          context.invoke<&Account::give>(MobilePtr<Account>{{Rank(0), a}}, 0L, kHops);
      });
    }
  });
  EXPECT_FALSE(archive.whole.empty());
}

TEST(Snapshots, AreRefusedOnSimulatedRanks) {
  Archive archive;
  MemorySink sink(archive);
  SimulationOptions simulation;
  simulation.ranks = 1;
  const auto run_with_them = [&](Transport& transport) {
    const Registry registry = accounts();
    Runtime(transport, registry, options_of(sink, 1)).run(start);
  };
  EXPECT_THROW(simulate(simulation, run_with_them), std::logic_error);
}

/// Gives away whatever seems to wait for a worker, half of the time: more often and later than any policy
/// would.
class Generous final : public Balancer {
 public:
  explicit Generous(Rank rank) : random_(static_cast<unsigned>(rank.value) + 1) {}
  void step(BalanceActions& actions, TimePoint) override {
    for (const ReadyObject& object : actions.ready_objects())
      if (random_() % 2 == 0) actions.move(object.id, Rank((actions.rank().value + 1) % actions.ranks()));
  }
  void told(Rank, const BalanceMessage&, BalanceActions&) override {}

 private:
  std::minstd_rand random_;
};

/// Those that are only to be copied have nothing to do: the run may have ended when they come.
TEST_P(SnapshotsOnRanks, NoObjectMovesBecauseItIsToBeCopied) {
  for (int attempt = 0; attempt < 30; ++attempt) {
    Archive archive;
    std::atomic<long> objects = 0;
    on_ranks(GetParam(), [&](Transport& network) {
      const auto transport = delayed(network, 300us, static_cast<unsigned>(attempt));
      const Registry registry = accounts();
      MemorySink sink(archive);
      RuntimeOptions options = options_of(sink, 1);
      options.balancer = [](Rank rank, int) { return std::make_unique<Generous>(rank); };
      Runtime runtime(*transport, registry, options);
      runtime.run([](Context& context) {
        for (int i = 0; context.rank() == Rank(0) && i < kAccounts; ++i)
          context.invoke<&Account::open>(context.create<Account>(), std::vector<ObjectId>());
      });
      runtime.run();  // with an object too few it would not end
      runtime.visit<Account>([&](MobilePtr<Account>, Account&) { ++objects; });
    });
    EXPECT_EQ(objects, kAccounts);
  }
}

}  // namespace
}  // namespace weft::engine::snapshot_test
