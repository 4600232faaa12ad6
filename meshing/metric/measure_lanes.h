// Mean ratios of tets and lengths of edges, eight at a time: what measures.cpp sums.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "meshing/base/lanes.h"
#include "meshing/base/point.h"
#include "meshing/metric/metric.h"

namespace weft::meshing {

/// Natural logarithms of positive, finite, normal numbers, within 2e-16 of the larger of 1 and the value.
Lanes log_of_lanes(const Lanes& x);

/// log10 as histograms file values: far below any interval for a number that is not positive.
Lanes log10_for_bins(const Lanes& x);

/// exp X of symmetric tensors without trace and with a norm up to kMaxExpNorm, by scaling and squaring; the
/// error is about 1e-14 times the largest eigenvalue of the result.
inline constexpr double kMaxExpNorm = 10;
TensorLanes exp_of_traceless(const TensorLanes& x);

/// mean_ratio() of the tets first to first + kLanes - 1, of the last one where there are fewer, within 1e-8;
/// by mean_ratio() itself where the anisotropy is beyond exp_of_traceless. What a tet gets does not depend on
/// those beside it.
Lanes mean_ratios(std::span<const std::array<std::uint32_t, 4>> tets, std::size_t first,
                  std::span<const Point> points, std::span<const LogMetric> log_metrics);

/// Tets in the log-Euclidean mean of the metrics of each one's corners.
struct TetLanes {
  Lanes ratios;                          ///< mean_ratios()
  Lanes volumes;                         ///< complexities, that is
  std::array<Lanes, 6> squared_lengths;  ///< of the edges
};
/// Of the tets that mean_ratios() takes.
TetLanes measure_tets(std::span<const std::array<std::uint32_t, 4>> tets, std::size_t first,
                      std::span<const Point> points, std::span<const LogMetric> log_metrics);

/// Up to kLanes edges and the metrics of their ends.
class EdgeBatch {
 public:
  void add(const Vec& edge, const Metric& a, const Metric& b);
  int size() const { return size_; }
  /// edge_length() of each; the batch is empty then.
  Lanes take_lengths();

 private:
  int size_ = 0;
  std::array<std::array<double, kLanes>, 3> edges_{};
  std::array<std::array<double, kLanes>, 6> a_{}, b_{};
};

}  // namespace weft::meshing
