// A line through the logs of sizes and times, by node.
#include "graph/replay/duration_model.h"

#include <algorithm>
#include <cmath>

namespace weft::graph::replay {

using dataflow::DumpedRun;
using dataflow::GraphDump;
using dataflow::NodeIndex;

namespace {

/// By instance, the largest value that its runs have counted: a coarse phase may predict less than the last.
std::vector<double> sizes_of(const GraphDump& dump) {
  std::vector<double> sizes(dump.instances.size(), 0);
  const auto name = std::find(dump.counter_names.begin(), dump.counter_names.end(), kSizeCounter);
  const auto place = static_cast<std::size_t>(name - dump.counter_names.begin());
  for (const DumpedRun& run : dump.runs)
    if (place < run.counters.size()) sizes[run.instance] = std::max(sizes[run.instance], run.counters[place]);
  for (double& size : sizes) size = std::max(size, 1.0);
  return sizes;
}

}  // namespace

DurationModel::DurationModel(const GraphDump& recorded)
    : sizes_(sizes_of(recorded)), exponents_(recorded.description.nodes.size()) {
  add_samples(recorded);
  for (NodeIndex node = 0; node < exponents_.size(); ++node) fit(node, recorded.description.nodes[node].kind);
}

void DurationModel::add_samples(const GraphDump& recorded) {
  for (const DumpedRun& run : recorded.runs)
    samples_[{run.node, run.round}].push_back(
        {sizes_[run.instance], std::max(1.0, static_cast<double>(run.end - run.begin))});
}

/// Least squares with a normal prior of the slope. What an instance does by itself goes over all that it has;
/// what it does when values of its neighbours have come, over what lies along the surface between them.
void DurationModel::fit(NodeIndex node, dataflow::NodeKind kind) {
  constexpr double kDeviation = 0.25;
  const double prior = kind == dataflow::NodeKind::start ? 1 : 2.0 / 3;
  double xx = 0, xy = 0, yy = 0, degrees = 0;
  for (auto at = samples_.lower_bound({node, 0}); at != samples_.end() && at->first.first == node; ++at) {
    const std::vector<Sample>& samples = at->second;
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

engine::TimePoint DurationModel::draw(NodeIndex node, std::uint64_t round, double size,
                                      std::mt19937_64& random) const {
  const std::vector<Sample>& samples = samples_.at({node, round});
  const Sample& drawn = samples[random() % samples.size()];
  return static_cast<engine::TimePoint>(drawn.nanoseconds * std::pow(size / drawn.size, exponent(node)));
}

}  // namespace weft::graph::replay
