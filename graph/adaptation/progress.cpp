// The latest news, and estimates that say what they do not know.
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

}  // namespace

void ProgressBoard::post(const SubdomainProgress& news) {
  const std::lock_guard lock(mutex_);
  latest_[news.subdomain] = news;
}

std::vector<SubdomainProgress> ProgressBoard::take() {
  const std::lock_guard lock(mutex_);
  std::vector<SubdomainProgress> news;
  news.reserve(latest_.size());
  for (const auto& [subdomain, latest] : latest_) news.push_back(latest);
  latest_.clear();
  return news;
}

ProgressTable::ProgressTable(std::uint32_t subdomains, std::uint32_t most_shifts, engine::TimePoint begin)
    : subdomains_(subdomains), most_shifts_(most_shifts), begin_(begin) {}

void ProgressTable::hear(const std::vector<SubdomainProgress>& news) {
  for (const SubdomainProgress& n : news) {
    const auto [known, first] = known_.try_emplace(n.subdomain, n);
    if (!first && n.number > known->second.number) known->second = n;
  }
}

/// Those that nobody has heard of have not begun. Never less than it was: one that rests may be woken for a
/// round that others are already through.
std::uint32_t ProgressTable::slowest_step() const {
  if (known_.size() < subdomains_) return 0;
  std::optional<std::uint32_t> slowest;
  for (const auto& [subdomain, news] : known_)
    if (!news.rests) slowest = std::min(slowest.value_or(news.step), news.step);
  return std::max(step_, slowest.value_or(step_));
}

double ProgressTable::share_of(std::uint32_t step) const {
  double all = 0, done = 0;
  for (const auto& [subdomain, news] : known_) {
    all += news.predicted_tets;
    if (news.rests || news.step > step)
      done += news.predicted_tets;
    else if (news.step == step)
      done += static_cast<double>(news.done) * news.predicted_tets;
  }
  if (known_.empty() || all == 0) return 0;
  const double of_those_unheard = static_cast<double>(subdomains_) / static_cast<double>(known_.size());
  return done / (all * of_those_unheard);
}

/// The mean of what has been seen and of what is usual, which counts as one more.
double ProgressTable::usual_ratio() const {
  if (shifts_.empty()) return kUsualRatio;
  const double product = kUsualRatio * shifts_.back() / shifts_.front();
  return std::min(1.0, std::pow(product, 1 / static_cast<double>(shifts_.size())));
}

double ProgressTable::slowest_ratio() const {
  if (shifts_.size() < 2) return 1;
  double slowest = kLeastBound;
  for (std::size_t i = 1; i < shifts_.size(); ++i) slowest = std::max(slowest, shifts_[i] / shifts_[i - 1]);
  return std::min(1.0, slowest);
}

void ProgressTable::estimate(RunProgress& progress) const {
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

RunProgress ProgressTable::at(engine::TimePoint time) {
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
  for (const auto& [subdomain, news] : known_) {
    progress.done += news.rests || news.step > step_ || (news.step == step_ && news.done >= 1);
    progress.at_rest += news.rests;
    progress.adapted += news.rests || news.step > 0 || news.done >= 1;
    progress.left += news.left;
  }
  progress.share = share_of(step_);
  estimate(progress);
  return progress;
}

}  // namespace weft::graph::adaptation
