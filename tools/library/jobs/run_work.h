// The predicted shares of a run's time: what the percentage of `weft adapt` is made of.
#pragma once

#include <cstdint>

namespace weft::tools {

class RunWork {
 public:
  /// Of a mesh of `tets` that is to have `wanted` in the end. `has_fields`: fields are carried along.
  RunWork(double tets, double wanted, bool has_fields);

  /// The result has `tets`.
  void adapted(double tets);

  // The share of the run that is done when a step begins.
  double at_metric() const { return (before_ - metric_ - measure_) / sum(); }
  /// In the middle of it: nothing is told while it lasts.
  double at_measures_before() const { return (before_ - 0.5 * measure_) / sum(); }
  /// `share` of the adaptation is done.
  double at_adaptation(double share) const { return (before_ + share * adapt_) / sum(); }
  double at_fields() const { return (before_ + adapt_ + measure_after_) / sum(); }
  double at_writing() const { return (before_ + adapt_ + measure_after_ + fields_) / sum(); }

 private:
  double sum() const { return before_ + adapt_ + measure_after_ + fields_ + write_; }
  void predict_after(double tets);

  bool has_fields_;
  double metric_ = 0, measure_ = 0, before_ = 0, adapt_ = 0;
  double measure_after_ = 0, fields_ = 0, write_ = 0;
};

}  // namespace weft::tools
