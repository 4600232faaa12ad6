// Runs one after the other, which ranks leave together or one by one, with failures anywhere in them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "engine/run/runtime.h"
#include "tests/support/ranks.h"

namespace weft::engine::run_sequence_test {
namespace {

using ::testing::HasSubstr;
using weft::testing::on_ranks;

/// Counts what comes in each run, and what comes in the wrong one.
struct Letterbox {
  int run = 0, arrived = 0, misdelivered = 0;
  template <class Archive>
  void serialize(Archive& archive) {
    archive(run, arrived, misdelivered);
  }
  void take(Context&, int of_run) { ++(of_run == run ? arrived : misdelivered); }
};

enum class Kind { nothing, to_next, to_all, reports, agreed };

struct Sequence {
  std::vector<Kind> runs;
  std::vector<int> failing;  ///< by rank: the run in which it fails; -1: none
  unsigned seed = 0;

  bool fails() const {
    return std::ranges::any_of(failing, [](int run) { return run >= 0; });
  }
};

/// One that ends, or fails, alike on all ranks. The last run is one that all leave together: who has left the
/// last of all hears of nothing any more.
Sequence random_sequence(std::minstd_rand& random, int ranks) {
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  Sequence sequence;
  for (int run = 1 + below(6); run > 0; --run) sequence.runs.push_back(static_cast<Kind>(below(5)));
  sequence.runs.push_back(Kind::agreed);
  sequence.failing.assign(static_cast<std::size_t>(ranks), -1);
  for (int failures = below(4); failures > 0; --failures)
    sequence.failing[static_cast<std::size_t>(below(ranks))] = below(static_cast<int>(sequence.runs.size()));
  sequence.seed = static_cast<unsigned>(random());
  return sequence;
}

/// Of this rank, in a runtime of its own.
void carry_out(const Sequence& sequence, Transport& transport) {
  const int rank = transport.rank().value, ranks = transport.size();
  const int failing = sequence.failing[static_cast<std::size_t>(rank)];
  std::minstd_rand random(sequence.seed + static_cast<unsigned>(rank));
  Registry registry;
  registry.type<Letterbox>("Letterbox").method<&Letterbox::take>("take");
  Runtime runtime(transport, registry,
                  {.balancer = no_balancing(), .grace = std::chrono::seconds(10), .on_failure = {}});
  runtime.run([](Context& context) { context.create<Letterbox>(); });
  Letterbox* box = nullptr;
  runtime.visit<Letterbox>([&](MobilePtr<Letterbox>, Letterbox& here) { box = &here; });
  const auto perform = [&](int run) {
    const Kind kind = sequence.runs[static_cast<std::size_t>(run)];
    if (kind == Kind::reports) {
      if (run == failing) runtime.request_stop("no input");
      runtime.gather_sums();
      return;
    }
    const int receivers = kind == Kind::nothing ? 0 : kind == Kind::to_next ? 1 : ranks - 1;
    box->run = run;
    box->arrived = 0;
    const auto pause = std::chrono::microseconds(random() % 4 == 0 ? random() % 3000 : 0);
    const auto root = [&, pause, run](Context& context) {
      std::this_thread::sleep_for(pause);
      if (run == failing) throw std::runtime_error("no input");
      for (int step = 1; step <= receivers; ++step)
        context.invoke<&Letterbox::take>(MobilePtr<Letterbox>{{Rank((rank + step) % ranks), 1}}, run);
    };
    if (kind == Kind::agreed)
      runtime.run(root);
    else
      runtime.run_until([&] { return box->arrived == receivers; }, root);
    EXPECT_EQ(box->arrived, receivers);
  };
  std::string what;
  try {
    for (int run = 0; run < static_cast<int>(sequence.runs.size()); ++run) perform(run);
  } catch (const RunFailure& failure) {
    what = failure.what();
    EXPECT_FALSE(failure.network_broken());
  }
  EXPECT_EQ(box->misdelivered, 0);
  if (sequence.fails())
    EXPECT_THAT(what, HasSubstr("no input"));
  else
    EXPECT_EQ(what, "");
}

class RunSequence : public weft::testing::OnRanks {};
INSTANTIATE_TEST_SUITE_P(Ranks, RunSequence, ::testing::ValuesIn(weft::testing::rank_counts()),
                         [](const auto& ranks) { return std::to_string(ranks.param); });

TEST_P(RunSequence, EndsOrFailsAlikeOnAllRanksAndLetsTheNextBegin) {
  on_ranks(GetParam(), [&](Transport& transport) {
    std::minstd_rand random(7);
    for (unsigned i = 0; i < 60u / weft::testing::kSlowness; ++i) {
      const Sequence sequence = random_sequence(random, GetParam());
      const auto late = weft::testing::delayed(transport, std::chrono::microseconds(2000), i);
      carry_out(sequence, i % 2 == 0 ? transport : *late);
    }
  });
}

}  // namespace
}  // namespace weft::engine::run_sequence_test
