// Eight numbers at a time, and vectors and tensors of such.
#pragma once

#include <cstdint>
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

typedef float FloatLanes __attribute__((vector_size(4 * kLanes)));
typedef std::int32_t IntLanes __attribute__((vector_size(4 * kLanes)));

inline VecLanes operator*(const Lanes& s, const VecLanes& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Lanes dot(const VecLanes& a, const VecLanes& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lanes absolute(const Lanes& a) { return a < 0 ? -a : a; }
inline VecLanes apply(const TensorLanes& m, const VecLanes& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
inline Lanes sum_squared_lengths(const TensorLanes& m, const VecLanes& e1, const VecLanes& e2,
                                 const VecLanes& e3) {
  const VecLanes m1 = apply(m, e1), m2 = apply(m, e2), m3 = apply(m, e3);
  return 3 * (dot(e1, m1) + dot(e2, m2) + dot(e3, m3)) - 2 * (dot(e2, m1) + dot(e3, m1) + dot(e3, m2));
}

/// Of numbers not negative, those below 1e-36 taken for that, within 1e-13. The first guess is from single
/// precision: integer division by three has no vector form, a multiplication has.
inline Lanes cube_root(Lanes x) {
  x = x > 1e-36 ? x : Lanes{} + 1e-36;
  FloatLanes f = __builtin_convertvector(x, FloatLanes);
  IntLanes bits;
  std::memcpy(&bits, &f, sizeof bits);
  bits =
      __builtin_convertvector(__builtin_convertvector(bits, FloatLanes) * (1.0f / 3), IntLanes) + 709921077;
  std::memcpy(&f, &bits, sizeof f);
  Lanes y = __builtin_convertvector(f, Lanes);
  for (int i = 0; i < 2; ++i) {
    const Lanes y3 = y * y * y;
    y *= (y3 + 2 * x) / (2 * y3 + x);
  }
  return y;
}

}  // namespace weft::meshing
