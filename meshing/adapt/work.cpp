// The measured costs of a tet, put together.
#include "meshing/adapt/work.h"

#include <algorithm>
#include <cmath>

namespace weft::meshing {

PredictedWork predict_work(double tets, double wanted) {
  constexpr double kImport = 0.2, kOutput = 0.2, kMark = 0.3, kRemove = 1.2;
  // A coarse collapse leaves more than is wanted; reconnection removes the rest.
  constexpr double kLeftByCollapse = 1.9;
  PredictedWork work;
  work.import = kImport * tets;
  work.collapse = kMark * tets + kRemove * std::max(0.0, tets - kLeftByCollapse * wanted);
  const double refined = std::max(wanted, std::min(tets, kLeftByCollapse * wanted));
  const double created = std::max(0.0, 1 - tets / std::max(wanted, 1.0));
  constexpr double kFewCreated = 0.05, kMostRounds = 2.8;
  if (created > kFewCreated) work.create = work::kRound * std::min(kMostRounds, 1 + 2.4 * created) * wanted;
  work.reconnect = work::reconnection(0, refined);
  work.improve = work::kImprove * refined;
  work.output = kOutput * wanted;
  return work;
}

namespace work {

double rounds_after(std::uint64_t splits, double tets) {
  constexpr double kFewSplits = 50, kRatio = 3.3;
  const double excess = kFewSplits * static_cast<double>(splits) / std::max(tets, 1.0);
  return excess > 1 ? std::log(excess) / std::log(kRatio) : 0;
}

double reconnection(std::size_t first, double tets) {
  double work = 0;
  for (std::size_t round = first; round < kReconnect.size(); ++round) work += kReconnect[round] * tets;
  return work;
}

}  // namespace work

void WorkMeter::spend(double work) {
  done_ += work;
  left_ = std::max(0.0, left_ - work);
}

double WorkMeter::share(double ahead) {
  if (done_ + left_ > 0) share_ = std::max(share_, (done_ + std::min(ahead, left_)) / (done_ + left_));
  return share_;
}

}  // namespace weft::meshing
