#ifndef SINEW_COMMON_MATH_DOUBLE4_H_
#define SINEW_COMMON_MATH_DOUBLE4_H_

#include <cstdint>
#include <numbers>

namespace sinew {

// Four float64 lanes and elementary functions of them, in plain vector
// arithmetic: a number maps to the same bits in any lane, on any machine with
// fused multiply-add, whatever C library is there. (common/policy/vector_math.h
// is the same for float32.)
//
// Thread-safety: pure functions. Ownership: values. Blocking: never. Errors:
// none; NaN gives NaN.
using Double4 = double __attribute__((ext_vector_type(4)));
using Word4 = uint64_t __attribute__((ext_vector_type(4)));

inline Double4 Splat4(double x) { return Double4(x); }

struct SinCos4 {
  Double4 sin, cos;
};

// Sine and cosine of `quarter` quarter turns (a whole number, 0 <= quarter <
// 2^51) more than an angle that has these: exact.
inline SinCos4 AddQuarters(SinCos4 of, Double4 quarter) {
  const Word4 count = __builtin_bit_cast(Word4, quarter + Splat4(0x1p52));
  const auto odd = (count & Word4(1)) != Word4(0);
  const Word4 sin_sign = (count & Word4(2)) << Word4(62);
  const Word4 cos_sign = ((count + Word4(1)) & Word4(2)) << Word4(62);
  const Double4 sin = odd ? of.cos : of.sin;
  const Double4 cos = odd ? of.sin : of.cos;
  return {.sin = __builtin_bit_cast(Double4,
                                    __builtin_bit_cast(Word4, sin) ^ sin_sign),
          .cos = __builtin_bit_cast(Double4,
                                    __builtin_bit_cast(Word4, cos) ^ cos_sign)};
}

// Sine and cosine of x, |x| <= 1e6, off by less than 1e-15: quarter turns are
// taken off, the rest, at most pi / 4, goes through Taylor series up to x^17
// and x^16 (next terms below 1e-17 and 1e-16).
inline SinCos4 SinCos(Double4 x) {
  // pi / 2 in two parts.
  constexpr double kHigh = 0x1.921fb54442d18p+0;
  constexpr double kLow = 0x1.1a62633145c07p-54;
  // Kept positive for AddQuarters by a multiple of a whole turn.
  constexpr double kTurns = 0x1p32;
  const Double4 quarter = __builtin_elementwise_floor(
      __builtin_elementwise_fma(x, Splat4(2 / std::numbers::pi), Splat4(0.5)));
  Double4 r = __builtin_elementwise_fma(quarter, Splat4(-kHigh), x);
  r = __builtin_elementwise_fma(quarter, Splat4(-kLow), r);
  const Double4 z = r * r;
  Double4 sin = Splat4(1.0 / 355687428096000);
  Double4 cos = Splat4(1.0 / 20922789888000);
  constexpr double kSin[] = {
      -1.0 / 1307674368000, 1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880,
      -1.0 / 5040,          1.0 / 120,        -1.0 / 6};
  constexpr double kCos[] = {
      -1.0 / 87178291200, 1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320,
      -1.0 / 720,         1.0 / 24,        -1.0 / 2};
#pragma clang loop unroll(full)
  for (int i = 0; i < 7; ++i) {
    sin = __builtin_elementwise_fma(sin, z, Splat4(kSin[i]));
    cos = __builtin_elementwise_fma(cos, z, Splat4(kCos[i]));
  }
  sin = __builtin_elementwise_fma(sin * z, r, r);
  cos = __builtin_elementwise_fma(cos, z, Splat4(1));
  return AddQuarters({.sin = sin, .cos = cos}, quarter + Splat4(kTurns));
}

// Angle in [0, pi / 2] of the point (x, y), x >= 0, y >= 0, one of them
// positive: atan2(y, x), off by less than 4e-14 of itself. Eighths of a turn
// are taken off; the rest goes through the series of arctan up to t^31, |t| <=
// tan(pi / 8).
inline Double4 AngleOf(Double4 x, Double4 y) {
  constexpr double kTanEighth = 0.41421356237309503;  // of half a right angle
  const auto low = y <= x * kTanEighth;
  const auto high = x <= y * kTanEighth;
  const Double4 numerator = low ? y : (high ? -x : y - x);
  const Double4 denominator = low ? x : (high ? y : y + x);
  const Double4 base = low ? Splat4(0)
                           : (high ? Splat4(std::numbers::pi / 2)
                                   : Splat4(std::numbers::pi / 4));
  const Double4 t = numerator / denominator;
  const Double4 z = t * t;
  Double4 series = Splat4(-1.0 / 31);
#pragma clang loop unroll(full)
  for (int n = 29; n >= 3; n -= 2) {
    series = __builtin_elementwise_fma(series, z,
                                       Splat4((n % 4 == 1 ? 1.0 : -1.0) / n));
  }
  return base + __builtin_elementwise_fma(series * z, t, t);
}

}  // namespace sinew

#endif  // SINEW_COMMON_MATH_DOUBLE4_H_
