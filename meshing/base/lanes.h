// Eight numbers at a time, and vectors and tensors of such.
#pragma once

#include <cstring>

namespace weft::meshing {

// GCC's portable vectors: the compiler maps them to what the processor has. Plain loops would not do: sums of
// doubles are only vectorised by compilers that may reorder them.
inline constexpr int kLanes = 8;
typedef double Lanes __attribute__((vector_size(8 * kLanes)));

struct VecLanes {
  Lanes x, y, z;
};
struct TensorLanes {
  Lanes xx, xy, yy, xz, yz, zz;
};

inline Lanes load_lanes(const double* p) {
  Lanes v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
inline void store_lanes(double* p, const Lanes& v) { std::memcpy(p, &v, sizeof v); }
inline VecLanes load_lanes3(const double* p, int stride) {
  return {load_lanes(p), load_lanes(p + stride), load_lanes(p + 2 * stride)};
}
inline TensorLanes load_lanes6(const double* p, int stride) {
  return {load_lanes(p),
          load_lanes(p + stride),
          load_lanes(p + 2 * stride),
          load_lanes(p + 3 * stride),
          load_lanes(p + 4 * stride),
          load_lanes(p + 5 * stride)};
}

}  // namespace weft::meshing
