// A line through the logs of sizes and times, by node.
#include "graph/replay/duration_model.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/base/text.h"

namespace weft::graph::replay {

using dataflow::DumpedRun;
using dataflow::GraphDump;
using dataflow::NodeIndex;
using engine::TimePoint;

namespace {

std::size_t place_of_sizes(const GraphDump& dump) {
  const auto name = std::find(dump.counter_names.begin(), dump.counter_names.end(), kSizeCounter);
  return static_cast<std::size_t>(name - dump.counter_names.begin());
}

/// By instance, the largest value that its runs have counted: a coarse phase may predict less than the last.
std::vector<double> sizes_of(const GraphDump& dump, std::size_t place) {
  constexpr double kMostTets = 1e15;
  std::vector<double> sizes(dump.instances.size(), 0);
  for (std::size_t r = 0; r < dump.runs.size(); ++r) {
    const DumpedRun& run = dump.runs[r];
    if (place >= run.counters.size()) continue;
    const double size = run.counters[place];
    if (!(size >= 0 && size <= kMostTets))
      throw std::invalid_argument(engine::text("runs.counters[\"", kSizeCounter, "\"][", r, "] is ", size,
                                               ": it is not between 0 and ", kMostTets));
    sizes[run.instance] = std::max(sizes[run.instance], size);
  }
  for (double& size : sizes) size = std::max(size, 1.0);
  return sizes;
}

}  // namespace

TimePoint within_limits(double nanoseconds) {
  constexpr double kMost = 1e18;
  return static_cast<TimePoint>(std::min(nanoseconds, kMost));
}

DurationModel::DurationModel(const GraphDump& recorded)
    : size_counter_(place_of_sizes(recorded)),
      sizes_(sizes_of(recorded, size_counter_)),
      exponents_(recorded.description.nodes.size()) {
  add_samples(recorded);
  for (NodeIndex node = 0; node < exponents_.size(); ++node) fit(node, recorded.description.nodes[node].kind);
  for (auto& [key, samples] : samples_) samples.usual = usual(samples.all, exponents_[key.first]);
}

void DurationModel::add_samples(const GraphDump& recorded) {
  for (const DumpedRun& run : recorded.runs)
    samples_[{run.node, run.round}].all.push_back(
        {sizes_[run.instance], std::max(1.0, static_cast<double>(run.end - run.begin))});
}

double DurationModel::usual(const std::vector<Sample>& samples, double exponent) {
  std::vector<double> times;
  for (const Sample& s : samples) times.push_back(s.nanoseconds / std::pow(s.size, exponent));
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

/// Least squares with a normal prior of the slope. What an instance does by itself goes over all that it has;
/// what it does when values of its neighbours have come, over what lies along the surface between them. Times
/// differ for other reasons than size, which may go with it in all instances (what lies where the mesh is far
/// from its metric is both harder and a little larger): that much more uncertain is the slope, however many
/// there are. Subdomains that differ by a few per cent, as a good decomposition's, say nothing of powers.
void DurationModel::fit(NodeIndex node, dataflow::NodeKind kind) {
  constexpr double kDeviation = 0.1, kCorrelation = 0.3;  // of the prior; of those reasons with the size
  const double prior = kind == dataflow::NodeKind::start ? 1 : 2.0 / 3;
  double xx = 0, xy = 0, yy = 0, degrees = 0;
  for (auto at = samples_.lower_bound({node, 0}); at != samples_.end() && at->first.first == node; ++at) {
    const std::vector<Sample>& samples = at->second.all;
    const auto count = static_cast<double>(samples.size());
    double x_mean = 0, y_mean = 0;
    for (const Sample& s : samples)
      x_mean += std::log(s.size) / count, y_mean += std::log(s.nanoseconds) / count;
    for (const Sample& s : samples) {
      const double x = std::log(s.size) - x_mean, y = std::log(s.nanoseconds) - y_mean;
      xx += x * x, xy += x * y, yy += y * y;
    }
    degrees += count - 1;
  }
  const double slope = xx > 0 ? xy / xx : prior;
  const double of_one = std::max(1e-9, (yy - slope * xy) / std::max(1.0, degrees - 1));
  const double variance = of_one * (1 + kCorrelation * kCorrelation * degrees);
  const double precision = 1 / (kDeviation * kDeviation);
  exponents_[node] = (xy / variance + prior * precision) / (xx / variance + precision);
}

TimePoint DurationModel::draw(NodeIndex node, std::uint64_t round, double size,
                              std::mt19937_64& random) const {
  const std::vector<Sample>& samples = samples_.at({node, round}).all;
  const Sample& drawn = samples[random() % samples.size()];
  return within_limits(drawn.nanoseconds * std::pow(size / drawn.size, exponent(node)));
}

/// Up to some times what is usual, what an instance takes is spread over it, and each part has its share.
/// What is beyond comes from a few places that are hard (where the metric turns and the mesh is far from it):
/// few parts have it, and each of these much of it, but never more than the whole.
TimePoint DurationModel::of_part(const DumpedRun& recorded, const Part& part) const {
  constexpr double kHard = 3;  // times what is usual; see tests/experiments/2026-11-29-finer.md
  const double all = std::max(1.0, static_cast<double>(recorded.end - recorded.begin));
  const double usual = samples_.at({recorded.node, recorded.round}).usual *
                       std::pow(sizes_[recorded.instance], exponent(recorded.node));
  const double spread = std::min(all, kHard * usual);
  const double share = std::pow(1.0 / part.of, exponent(recorded.node));
  const double share_of_hard = part.is_hard ? std::min(1.0, share * part.of / part.hard_ones) : 0;
  return within_limits(spread * share + (all - spread) * share_of_hard);
}

}  // namespace weft::graph::replay
