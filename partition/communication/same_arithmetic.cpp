// Elementary functions on inputs that the compiler does not know.
#include "partition/communication/same_arithmetic.h"

#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "meshing/base/error.h"
#include "meshing/metric/metric.h"

namespace weft::partition {
namespace {

class BitHash {
 public:
  void add(double value) {
    hash_ = (hash_ ^ std::bit_cast<std::uint64_t>(value)) * 0x9E3779B97F4A7C15ull;
    hash_ ^= hash_ >> 29;
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0x243F6A8885A308D3ull;
};

void add_functions_at(double x, BitHash& hash) {
  hash.add(std::exp(x));
  hash.add(std::log(x));
  hash.add(std::cbrt(x));
  hash.add(std::sqrt(x));
  hash.add(std::pow(x, 2.0 / 3));
}

void add_metrics_at(double x, BitHash& hash) {
  const meshing::LogMetric log_metric{x, 0.3 * x, 1 - x, 0.1 + x, -0.7 * x, 2 - 0.5 * x};
  const meshing::Metric metric = meshing::exp_fast(log_metric);
  const meshing::Vec edge{1 / (1 + x), x, 0.25};
  hash.add(squared_length(metric, edge));
  hash.add(meshing::edge_length_fast(edge, metric, meshing::exp_fast(0.5 * log_metric)));
}

}  // namespace

std::uint64_t arithmetic_fingerprint() {
  constexpr int kInputs = 2000;  // libraries differ in the last bit of a few results in a thousand
  BitHash hash;
  volatile double step = 1.0137;  // read at run time: nothing is computed by the compiler's library
  double x = 1e-3;
  for (int i = 0; i < kInputs; ++i) {
    add_functions_at(x, hash);
    if (x < 8) add_metrics_at(x, hash);
    x = x < 300 ? x * step : 1e-3 * step + 1e-6 * i;
  }
#ifdef __AVX512F__  // wider lanes add in another order
  hash.add(8);
#endif
  return hash.value();
}

void check_same_arithmetic(Peers& peers, std::uint64_t mine) {
  const auto all = allgather(peers, std::vector<std::uint64_t>{mine});
  for (std::size_t r = 1; r < all.size(); ++r)
    if (all[r] != all[0])
      throw meshing::InputError("", "",
                                "rank " + std::to_string(r) +
                                    " computes exp, log, cbrt, sqrt or pow with other last bits than rank 0: "
                                    "all ranks need the same program, C library and kind of processor");
}

}  // namespace weft::partition
