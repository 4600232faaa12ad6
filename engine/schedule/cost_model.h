// Predicts what a handler will take from what the application expects and what was measured so far.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/objects/experience.h"

namespace weft::engine {

/// Per method: seconds = exp(a) * expected^b, fitted to measurements; and per object how much it was off
/// lately. The communication thread and the workers of a rank share one model under the rank's lock, so calls
/// are short: a fit is done at sample numbers that grow geometrically, on a bounded number of the latest
/// samples.
class CostModel {
 public:
  /// Methods are 0 to `methods` - 1; what is asked of others throws std::out_of_range.
  explicit CostModel(std::size_t methods);

  /// Seconds that `method` is likely to take on `object`: finite, > 0, and no less for a larger expectation.
  /// `expected` is what the application says, in seconds; 0: it says nothing, and the mean of what was
  /// measured counts (of this object, else of the method, else 1e-4 s). Negative numbers and NaN count as 0.
  double predict(std::uint32_t method, const Experiences& object, double expected) const;

  /// `method` took `seconds` on `object`, where the application had expected `expected`. Ignored when
  /// `seconds` is negative or not finite.
  void measured(std::uint32_t method, Experiences& object, double expected, double seconds);

  /// log(seconds) = intercept + slope * log(expected)
  struct Curve {
    double intercept = 0;
    double slope = 1;
  };
  /// Until there are enough samples to fit: seconds = expected.
  Curve curve(std::uint32_t method) const { return methods_.at(method).curve; }

 private:
  struct Sample {
    double log_expected;
    double log_seconds;
  };
  /// Logs of what one method took on all objects.
  struct Method {
    Curve curve;
    bool fitted = false;
    std::uint64_t measured = 0;  // all, with an expectation or without
    double mean_seconds = 0;
    std::uint64_t samples = 0;   // with an expectation
    std::vector<Sample> latest;  // of these, the last kWindow, as a ring
  };
  static void add_sample(Method& method, Sample sample);

  std::vector<Method> methods_;
};

}  // namespace weft::engine
