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
  for (auto& [key, samples] : samples_) samples.uneven = unevenness(samples.all, exponents_[key.first]);
}

void DurationModel::add_samples(const GraphDump& recorded) {
  for (const DumpedRun& run : recorded.runs)
    samples_[{run.node, run.round}].all.push_back(
        {sizes_[run.instance], std::max(1.0, static_cast<double>(run.end - run.begin))});
}

/// Of the times, once the sizes are taken out of them.
double DurationModel::unevenness(const std::vector<Sample>& samples, double exponent) {
  double sum = 0, squares = 0;
  for (const Sample& s : samples) {
    const double time = s.nanoseconds / std::pow(s.size, exponent);
    sum += time, squares += time * time;
  }
  return std::max(0.0, 1 - sum * sum / (squares * static_cast<double>(samples.size())));
}

/// Least squares with a normal prior of the slope. What an instance does by itself goes over all that it has;
/// what it does when values of its neighbours have come, over what lies along the surface between them.
void DurationModel::fit(NodeIndex node, dataflow::NodeKind kind) {
  constexpr double kDeviation = 0.1;
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
  const double variance = std::max(1e-9, (yy - slope * xy) / std::max(1.0, degrees - 1));
  const double precision = 1 / (kDeviation * kDeviation);
  exponents_[node] = (xy / variance + prior * precision) / (xx / variance + precision);
}

/// What makes one instance take longer than another lies on surfaces (of the boundary, where the metric turns
/// or jumps, of what was too coarse): 1/n of a volume meets such a surface with a probability that is n^(1/3)
/// times 1/n of what would fill it, so that the mean square of its times, divided by the square of the mean,
/// grows by n^(1/3) as far as it is uneven. The factor is log-normal, of mean 1; no part takes longer than
/// the whole, which makes the mean a little less.
engine::TimePoint DurationModel::draw(NodeIndex node, std::uint64_t round, const Drawn& instance,
                                      std::mt19937_64& random) const {
  const Samples& samples = samples_.at({node, round});
  const Sample& drawn = samples.all[random() % samples.all.size()];
  const double mean = drawn.nanoseconds * std::pow(instance.size / drawn.size, exponent(node));
  if (!(instance.size < drawn.size)) return within_limits(mean);
  const double variance = std::log1p((std::cbrt(drawn.size / instance.size) - 1) * samples.uneven);
  const double factor = std::exp(std::sqrt(variance) * instance.difficulty - variance / 2);
  return within_limits(std::min(drawn.nanoseconds, mean * factor));
}

}  // namespace weft::graph::replay
