// The policies that need no thought, and the names of all.
#include "engine/balance/balancer.h"

#include <random>
#include <stdexcept>
#include <string>

namespace weft::engine {
namespace {

class NoBalancing final : public Balancer {
 public:
  void step(BalanceActions&, TimePoint) override {}
  void told(Rank, const BalanceMessage&, BalanceActions&) override {}
};

class Rotate final : public Balancer {
 public:
  Rotate(Rank rank, int ranks, double share, std::uint64_t seed)
      : rank_(rank),
        ranks_(ranks),
        share_(share),
        random_(seed * 1000003 + static_cast<std::uint64_t>(rank.value)) {}

  void step(BalanceActions&, TimePoint) override {}
  void told(Rank, const BalanceMessage&, BalanceActions&) override {}
  bool wants_finished() const override { return ranks_ > 1; }

  void finished(const std::vector<ObjectId>& objects, BalanceActions& actions) override {
    for (const ObjectId id : objects) {
      if (std::uniform_real_distribution<double>(0, 1)(random_) >= share_) continue;
      const int step = std::uniform_int_distribution<int>(1, ranks_ - 1)(random_);
      actions.move(id, Rank((rank_.value + step) % ranks_));
    }
  }

 private:
  Rank rank_;
  int ranks_;
  double share_;
  std::mt19937_64 random_;
};

}  // namespace

BalancerFactory no_balancing() {
  return [](Rank, int) { return std::make_unique<NoBalancing>(); };
}

BalancerFactory rotate(double share, std::uint64_t seed) {
  return [=](Rank rank, int ranks) { return std::make_unique<Rotate>(rank, ranks, share, seed); };
}

BalancerFactory balancer_by_name(std::string_view name) {
  if (name == "none") return no_balancing();
  if (name == "stealing") return work_stealing();
  if (name == "diffusion") return diffusion();
  if (name == "rotate") return rotate();
  throw std::invalid_argument("there is no balancing policy '" + std::string(name) +
                              "'; there are none, stealing, diffusion and rotate");
}

}  // namespace weft::engine
