// What the methods of an object took so far.
#pragma once

#include <cstdint>
#include <vector>

namespace weft::engine {

/// What one method took on one object; kept by the cost model.
struct Experience {
  std::uint32_t method = 0;
  std::uint32_t measured = 0;
  double mean_seconds = 0;
  double log_bias = 0;  ///< log(seconds) less the method's curve, smoothed
};

/// Of one object, which meets few methods. It does not travel: the next rank may be another machine.
using Experiences = std::vector<Experience>;

}  // namespace weft::engine
