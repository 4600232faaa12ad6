// What runs take in instances of other sizes than those that were recorded.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "engine/trace/trace.h"
#include "graph/dataflow/dump/graph_dump.h"

namespace weft::graph::replay {

/// The counter by which instances say how large they will be.
inline constexpr const char* kSizeCounter = "tets predicted";

/// Nanoseconds as whole ones; what is too long for any clock stays so without overflow.
engine::TimePoint within_limits(double nanoseconds);

/// One of `of` equal parts of a recorded instance.
struct Part {
  std::uint32_t of;
  std::uint32_t hard_ones;  ///< so many of them have what is hard of the whole
  bool is_hard;             ///< this one has
};

/// Bootstrapped. An instance that is no part of a recorded one takes in a run what one of the same node and
/// round took in a recorded instance drawn at random, times the ratio of the sizes to the power that fits the
/// node's recorded times.
class DurationModel {
 public:
  /// Throws std::invalid_argument for sizes that are none.
  explicit DurationModel(const dataflow::GraphDump& recorded);

  /// Of each recorded instance: its predicted tets; 1 for all where that was not counted.
  const std::vector<double>& sizes() const { return sizes_; }
  /// Where the runs' counters have the size.
  std::size_t size_counter() const { return size_counter_; }
  /// Nanoseconds, in an instance of so many tets.
  engine::TimePoint draw(dataflow::NodeIndex node, std::uint64_t round, double size,
                         std::mt19937_64& random) const;
  /// Nanoseconds, in a part of the instance that this run was recorded in.
  engine::TimePoint of_part(const dataflow::DumpedRun& recorded, const Part& part) const;
  /// Seconds of a node go with this power of the size: fitted within the rounds, pulled to that of a volume
  /// or a surface where the recorded sizes differ too little to tell.
  double exponent(dataflow::NodeIndex node) const { return exponents_.at(node); }

 private:
  struct Sample {
    double size;
    double nanoseconds;
  };
  struct Samples {
    std::vector<Sample> all;
    double usual = 0;  ///< nanoseconds a tet to the node's power: their median
  };
  void add_samples(const dataflow::GraphDump& recorded);
  void fit(dataflow::NodeIndex node, dataflow::NodeKind kind);
  static double usual(const std::vector<Sample>& samples, double exponent);

  std::size_t size_counter_;
  std::vector<double> sizes_;
  std::map<std::pair<dataflow::NodeIndex, std::uint64_t>, Samples> samples_;  ///< node, round
  std::vector<double> exponents_;
};

}  // namespace weft::graph::replay
