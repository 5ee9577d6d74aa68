#ifndef SINEW_COMMON_POLICY_VECTOR_MATH_H_
#define SINEW_COMMON_POLICY_VECTOR_MATH_H_

#include <cstdint>
#include <cstring>

namespace sinew::policy::internal {

// Eight float32 lanes and the elementary functions that policies use, in plain
// vector arithmetic: every lane is computed by the same operations, so a number
// maps to the same bits in any lane, on any machine with fused multiply-add.
// NaN gives NaN. Errors are against the exact value; vector_math_test.cc
// measures them.
using Float8 = float __attribute__((ext_vector_type(8)));
using Int8 = int32_t __attribute__((ext_vector_type(8)));
using UInt8 = uint32_t __attribute__((ext_vector_type(8)));

inline constexpr int kLanes = 8;

inline Float8 Load(const float* p) {
  Float8 v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}

inline void Store(float* p, Float8 v) { std::memcpy(p, &v, sizeof(v)); }

inline Float8 Splat(float x) { return Float8(x); }

// a * b + c, rounded once.
inline Float8 Fma(Float8 a, Float8 b, Float8 c) {
  return __builtin_elementwise_fma(a, b, c);
}

// The first `count` lanes of v, `fill` in the others.
inline Float8 Keep(Float8 v, int64_t count, float fill) {
  constexpr Int8 kIndex = {0, 1, 2, 3, 4, 5, 6, 7};
  return kIndex < Int8(static_cast<int32_t>(count)) ? v : Splat(fill);
}

// Sum of the lanes, in one fixed order.
inline float Sum(Float8 v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

// Largest lane; unspecified if one is NaN.
inline float Max(Float8 v) {
  float most = v[0];
  for (int i = 1; i < kLanes; ++i) most = v[i] > most ? v[i] : most;
  return most;
}

// x limited to [low, high]; NaN stays.
inline Float8 Clamp(Float8 x, float low, float high) {
  const Float8 below = x < Splat(low) ? Splat(low) : x;
  return below > Splat(high) ? Splat(high) : below;
}

// x = n ln 2 + r with |r| <= ln 2 / 2, for |x| < 2^20.
struct Reduced {
  Float8 r;
  UInt8 n;  // two's complement
};

inline Reduced ReduceByLn2(Float8 x) {
  // Adding 1.5 * 2^23 leaves the nearest integer in the low bits.
  constexpr float kMagic = 12582912.0f;
  constexpr float kLog2E = 1.44269504f;
  // ln 2 in two parts; n times the first is exact.
  constexpr float kLn2High = 0.693145752f;
  constexpr float kLn2Low = 1.42860677e-6f;
  const Float8 shifted = Fma(x, Splat(kLog2E), Splat(kMagic));
  const Float8 n = shifted - Splat(kMagic);
  Float8 r = Fma(n, Splat(-kLn2High), x);
  r = Fma(n, Splat(-kLn2Low), r);
  return {.r = r,
          .n = __builtin_bit_cast(UInt8, shifted) -
               __builtin_bit_cast(UInt8, Splat(kMagic))};
}

// 2^n for -126 <= n <= 127.
inline Float8 PowerOfTwo(UInt8 n) {
  return __builtin_bit_cast(Float8, (n + UInt8(127u)) << UInt8(23u));
}

// exp(r) - 1 for |r| <= ln 2 / 2: the Taylor series to r^7 / 7!; the rest is
// below 6e-9 of exp(r).
inline Float8 SmallExpm1(Float8 r) {
  Float8 p = Splat(1.0f / 5040);
  p = Fma(p, r, Splat(1.0f / 720));
  p = Fma(p, r, Splat(1.0f / 120));
  p = Fma(p, r, Splat(1.0f / 24));
  p = Fma(p, r, Splat(1.0f / 6));
  p = Fma(p, r, Splat(0.5f));
  return Fma(p, r * r, r);
}

// exp(x) within 1.5 units in the last place; 0 and infinity beyond the range.
inline Float8 Exp(Float8 x) {
  const Reduced reduced = ReduceByLn2(Clamp(x, -104.0f, 89.0f));
  // Two factors, since n reaches -150 and 128.
  const UInt8 half =
      __builtin_bit_cast(UInt8, __builtin_bit_cast(Int8, reduced.n) >> Int8(1));
  const Float8 e = SmallExpm1(reduced.r) + Splat(1.0f);
  return e * PowerOfTwo(half) * PowerOfTwo(reduced.n - half);
}

// exp(x) - 1 within 2 units in the last place, for x <= 80; -1 below -30.
inline Float8 Expm1(Float8 x) {
  const Reduced reduced = ReduceByLn2(Clamp(x, -30.0f, 80.0f));
  const Float8 scale = PowerOfTwo(reduced.n);
  return Fma(SmallExpm1(reduced.r), scale, scale - Splat(1.0f));
}

// 1 / (1 + exp(-x)) within 3 units in the last place where it is normal.
inline Float8 Sigmoid(Float8 x) {
  return Splat(1.0f) / (Splat(1.0f) + Exp(-x));
}

// x / (1 + exp(-x)) within 3 units in the last place where it is normal.
inline Float8 Silu(Float8 x) { return x / (Splat(1.0f) + Exp(-x)); }

// x > 0 ? x : exp(x) - 1, within 2 units in the last place.
inline Float8 Elu(Float8 x) {
  const Float8 negative = x > Splat(0.0f) ? Splat(0.0f) : x;
  return x > Splat(0.0f) ? x : Expm1(negative);
}

// tanh(x) = e / (e + 2) with e = exp(2 |x|) - 1, sign restored; within 4 units
// in the last place.
inline Float8 Tanh(Float8 x) {
  const Float8 magnitude = __builtin_elementwise_abs(x);
  // 1 to float32 from 9.02 on.
  const Float8 e = Expm1(Splat(2.0f) * Clamp(magnitude, 0.0f, 10.0f));
  return __builtin_elementwise_copysign(e / (e + Splat(2.0f)), x);
}

}  // namespace sinew::policy::internal

#endif  // SINEW_COMMON_POLICY_VECTOR_MATH_H_
