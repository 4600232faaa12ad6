// libFuzzer target: the check of options. Any numbers and words are either good or an OptionError.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "weft/weft.h"

namespace {

/// Values out of the input, as long as there are bytes; then zeros.
class Values {
 public:
  Values(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  template <class T>
  T take() {
    T value{};
    if (size_ < sizeof value) return value;
    std::memcpy(&value, data_, sizeof value);
    data_ += sizeof value;
    size_ -= sizeof value;
    return value;
  }
  std::string text() {
    std::string text;
    for (std::size_t n = take<std::uint8_t>() % 32; n > 0; --n) text += take<char>();
    return text;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Values values(data, size);
  weft::Options o;
  for (double* number :
       {&o.geometry.ridge_angle, &o.geometry.hausd, &o.metric.norm, &o.metric.curvature, &o.metric.sagitta,
        &o.metric.complexity, &o.metric.hmin, &o.metric.hmax, &o.metric.aspect, &o.metric.hgrad,
        &o.run.time_limit, &o.run.max_memory, &o.checkpoint.every})
    *number = values.take<double>();
  o.run.threads = values.take<int>();
  o.distributed.subdomains = values.take<std::uint32_t>();
  if (values.take<std::uint8_t>() % 2 == 1) o.distributed.layers = values.take<int>();
  o.metric.function = values.text();
  o.distributed.partitioner = values.text();
  o.distributed.balancer = values.text();
  try {
    weft::validate(o);
  } catch (const weft::OptionError&) {
  }
  return 0;
}
