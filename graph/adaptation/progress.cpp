// Sums of the latest reports, and estimates that say what they do not know.
#include "graph/adaptation/progress.h"

#include <algorithm>
#include <cmath>

namespace weft::graph::adaptation {
namespace {

// Before so much has been seen of a step its pace means nothing.
constexpr double kLeastSeconds = 2, kLeastShare = 0.1;

// A shift's seconds by those of the one before: 0.35 to 0.9 in the runs of README.md.
constexpr double kUsualRatio = 0.55, kLeastBound = 0.75;

/// Of `more` shifts, each `ratio` times as long as the one before, in units of that before them all.
double shifts_after(std::uint32_t more, double ratio) {
  double sum = 0, length = 1;
  for (std::uint32_t i = 0; i < more; ++i) sum += length *= ratio;
  return sum;
}

/// Adds the report, or takes it away.
void count(ProgressSums& sums, const SubdomainProgress& report, int sign) {
  if (sums.steps.size() <= report.step) sums.steps.resize(report.step + 1);
  const bool through = report.rests || report.done >= 1;
  const double tets = sign * report.predicted_tets;
  sums.steps[report.step] += {sign,
                              through ? sign : 0,
                              report.rests ? sign : 0,
                              tets,
                              through ? tets : tets * static_cast<double>(report.done),
                              report.rests ? tets : 0};
}

std::uint64_t at_least_0(std::uint64_t modulo) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, static_cast<std::int64_t>(modulo)));
}

meshing::Nonconforming at_least_0(const meshing::Nonconforming& n) {
  return {at_least_0(n.tets), at_least_0(n.poor_tets), at_least_0(n.long_edges), at_least_0(n.short_edges)};
}

}  // namespace

ProgressSums::Step& ProgressSums::Step::operator+=(const Step& other) {
  subdomains += other.subdomains;
  done += other.done;
  at_rest += other.at_rest;
  tets += other.tets;
  tets_done += other.tets_done;
  tets_at_rest += other.tets_at_rest;
  return *this;
}

void ProgressSums::replace(const std::optional<SubdomainProgress>& before, const SubdomainProgress& now) {
  if (before) {
    count(*this, *before, -1);
    left -= before->left;
  }
  count(*this, now, 1);
  left += now.left;
}

ProgressSums& ProgressSums::operator+=(const ProgressSums& other) {
  if (steps.size() < other.steps.size()) steps.resize(other.steps.size());
  for (std::size_t s = 0; s < other.steps.size(); ++s) steps[s] += other.steps[s];
  left += other.left;
  return *this;
}

void ProgressBoard::post(const std::optional<SubdomainProgress>& before, const SubdomainProgress& now) {
  const std::lock_guard lock(mutex_);
  sums_.replace(before, now);
  is_new_ = true;
}

std::optional<ProgressSums> ProgressBoard::take() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(is_new_, false)) return {};
  return sums_;
}

ProgressEstimator::ProgressEstimator(std::uint32_t subdomains, std::uint32_t most_shifts,
                                     engine::TimePoint begin)
    : subdomains_(subdomains), most_shifts_(most_shifts), begin_(begin) {}

/// Those that are through a step, or were at rest before; `subdomains` and `tets`: all.
ProgressSums::Step ProgressEstimator::through(std::uint32_t step) const {
  ProgressSums::Step sum;
  for (std::uint32_t s = 0; s < sums_.steps.size(); ++s) {
    const ProgressSums::Step& those = sums_.steps[s];
    sum.subdomains += those.subdomains;
    sum.tets += those.tets;
    sum.done += s > step ? those.subdomains : s == step ? those.done : those.at_rest;
    sum.tets_done += s > step ? those.tets : s == step ? those.tets_done : those.tets_at_rest;
    sum.at_rest += those.at_rest;
  }
  return sum;
}

/// Those that nobody has heard of have not begun. Never less than it was: one that rests may be woken for a
/// round that others are already through.
std::uint32_t ProgressEstimator::slowest_step() const {
  std::int64_t rest = 0, later = 0;  // of the steps up to one; beyond it
  for (const ProgressSums::Step& those : sums_.steps) later += those.subdomains;
  if (through(step_).at_rest >= subdomains_) return step_;
  for (std::uint32_t s = 0; s < sums_.steps.size(); ++s) {
    rest += sums_.steps[s].at_rest;
    later -= sums_.steps[s].subdomains;
    if (rest + later < subdomains_) return std::max(step_, s);
  }
  return step_;
}

double ProgressEstimator::share_of(std::uint32_t step) const {
  const ProgressSums::Step sum = through(step);
  if (sum.subdomains <= 0 || sum.tets <= 0) return 0;
  const double of_those_unheard = static_cast<double>(subdomains_) / static_cast<double>(sum.subdomains);
  return std::clamp(sum.tets_done / (sum.tets * of_those_unheard), 0.0, 1.0);
}

/// The mean of what has been seen and of what is usual, which counts as one more.
double ProgressEstimator::usual_ratio() const {
  if (shifts_.empty()) return kUsualRatio;
  const double product = kUsualRatio * shifts_.back() / shifts_.front();
  return std::min(1.0, std::pow(product, 1 / static_cast<double>(shifts_.size())));
}

double ProgressEstimator::slowest_ratio() const {
  if (shifts_.size() < 2) return 1;
  double slowest = kLeastBound;
  for (std::size_t i = 1; i < shifts_.size(); ++i) slowest = std::max(slowest, shifts_[i] / shifts_[i - 1]);
  return std::min(1.0, slowest);
}

void ProgressEstimator::estimate(RunProgress& progress) const {
  const double spent = progress.seconds - step_began_, gained = progress.share - share_at_begin_;
  double length = 0, most = 0;  // of this step
  if (spent >= kLeastSeconds && gained >= kLeastShare) {
    length = most = spent + spent * (1 - progress.share) / gained;
  } else if (!shifts_.empty()) {
    length = usual_ratio() * shifts_.back();
    most = shifts_.back();
  } else {
    return;
  }
  progress.step_left = std::max(0.0, length - spent);
  if (step_ == 0) return;
  const std::uint32_t more = most_shifts_ > step_ ? most_shifts_ - step_ : 0;
  progress.all_left = *progress.step_left + length * shifts_after(more, usual_ratio());
  progress.most_left = std::max(0.0, most - spent) + most * shifts_after(more, slowest_ratio());
}

RunProgress ProgressEstimator::at(engine::TimePoint time) {
  RunProgress progress;
  progress.subdomains = subdomains_;
  progress.most_shifts = most_shifts_;
  progress.seconds = 1e-9 * static_cast<double>(time - begin_);
  if (const std::uint32_t step = slowest_step(); step > step_) {
    // Several that were over at once have shared the time.
    const double each = std::max(1e-3, (progress.seconds - step_began_) / (step - step_));
    for (std::uint32_t s = std::max(step_, 1u); s < step; ++s) shifts_.push_back(each);
    step_ = step;
    step_began_ = progress.seconds;
    share_at_begin_ = share_of(step);
  }
  progress.step = step_;
  const auto number = [&](std::int64_t count) {
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(count, 0, subdomains_));
  };
  const ProgressSums::Step sum = through(step_);
  progress.done = number(sum.done);
  progress.at_rest = number(sum.at_rest);
  progress.adapted = number(through(0).done);
  progress.left = at_least_0(sums_.left);
  progress.share = share_of(step_);
  estimate(progress);
  return progress;
}

}  // namespace weft::graph::adaptation
