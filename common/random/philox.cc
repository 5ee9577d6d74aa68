#include "common/random/philox.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "Random123/philox.h"
#include "absl/types/span.h"
#include "common/check.h"

namespace sinew {
namespace {

constexpr uint64_t kWordsPerBlock = 4;
constexpr double kTwoToMinus53 = 0x1p-53;

using Block = std::array<uint64_t, kWordsPerBlock>;

Block DrawBlock(const RandomKey& key, uint64_t block) {
  const r123::Philox4x64::ctr_type counter = {
      {block, key.step, key.episode, key.environment}};
  const r123::Philox4x64::key_type philox_key = {
      {key.seed, static_cast<uint64_t>(key.purpose)}};
  const auto words = r123::Philox4x64()(counter, philox_key);
  return {words[0], words[1], words[2], words[3]};
}

uint64_t DrawWord(const RandomKey& key, uint64_t index) {
  return DrawBlock(key, index / kWordsPerBlock)[index % kWordsPerBlock];
}

// U[0, 1) on a grid of 2^-53.
double ToUnit(uint64_t word) {
  return static_cast<double>(word >> 11) * kTwoToMinus53;
}

// Natural logarithm of a positive normal number. x = m 2^e with m in
// [sqrt(1/2), sqrt(2)); ln m = 2 artanh(s), s = (m - 1) / (m + 1), |s| < 0.172,
// by its power series up to s^17 (next term below 2e-16).
double Log(double x) {
  constexpr uint64_t kMantissa = (uint64_t{1} << 52) - 1;
  const uint64_t bits = std::bit_cast<uint64_t>(x);
  int exponent = static_cast<int>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & kMantissa) | uint64_t{1023} << 52);
  if (m > std::numbers::sqrt2) {
    m *= 0.5;
    ++exponent;
  }
  const double s = (m - 1) / (m + 1);
  const double z = s * s;
  double series = 1.0 / 17;
  for (int n = 15; n >= 1; n -= 2) series = series * z + 1.0 / n;
  return 2 * s * series + exponent * std::numbers::ln2;
}

struct SinCos {
  double sin;
  double cos;
};

// Sine and cosine of 2 pi `turns`, turns in [0, 1): the nearest quarter turn
// is taken off, the rest, at most pi / 4, goes through Taylor series up to
// x^15 and x^16 (next terms below 5e-17).
SinCos SinCosOfTurns(double turns) {
  const int quarter = static_cast<int>(turns * 4 + 0.5);
  const double x = (turns - 0.25 * quarter) * (2 * std::numbers::pi);
  const double z = x * x;
  double sin = 1;
  for (int n = 15; n >= 3; n -= 2) sin = 1 - sin * z / (n * (n - 1));
  sin *= x;
  double cos = 1;
  for (int n = 16; n >= 2; n -= 2) cos = 1 - cos * z / (n * (n - 1));
  switch (quarter % 4) {
    case 0:
      return {sin, cos};
    case 1:
      return {cos, -sin};
    case 2:
      return {-sin, -cos};
    default:
      return {-cos, sin};
  }
}

// Two independent N(0, 1) numbers from two words (Box and Muller, 1958).
std::array<float, 2> ToNormals(uint64_t radius_word, uint64_t angle_word) {
  // In (0, 1]: the logarithm stays finite.
  const double u = (static_cast<double>(radius_word >> 11) + 1) * kTwoToMinus53;
  const double radius = std::sqrt(-2 * Log(u));
  const SinCos angle = SinCosOfTurns(ToUnit(angle_word));
  return {static_cast<float>(radius * angle.cos),
          static_cast<float>(radius * angle.sin)};
}

}  // namespace

void FillUniform(const RandomKey& key, absl::Span<float> out) {
  constexpr size_t kPerBlock = 2 * kWordsPerBlock;
  for (size_t begin = 0; begin < out.size(); begin += kPerBlock) {
    const Block block = DrawBlock(key, begin / kPerBlock);
    const size_t count = std::min(kPerBlock, out.size() - begin);
    for (size_t i = 0; i < count; ++i) {
      const auto half = static_cast<uint32_t>(block[i / 2] >> (i % 2 * 32));
      out[begin + i] = static_cast<float>(half >> 8) * 0x1p-24f;
    }
  }
}

void FillNormal(const RandomKey& key, absl::Span<float> out) {
  for (size_t begin = 0; begin < out.size(); begin += kWordsPerBlock) {
    const Block block = DrawBlock(key, begin / kWordsPerBlock);
    const std::array<float, 2> low = ToNormals(block[0], block[1]);
    const std::array<float, 2> high = ToNormals(block[2], block[3]);
    const std::array<float, 4> numbers = {low[0], low[1], high[0], high[1]};
    const size_t count = std::min<size_t>(kWordsPerBlock, out.size() - begin);
    std::copy_n(numbers.begin(), count, out.begin() + begin);
  }
}

double Uniform(const RandomKey& key, uint64_t index) {
  return ToUnit(DrawWord(key, index));
}

uint64_t UniformInt(const RandomKey& key, uint64_t bound, uint64_t index) {
  SINEW_DCHECK(bound >= 1) << "bound " << bound;
  __extension__ using Wide = unsigned __int128;
  return static_cast<uint64_t>((Wide{DrawWord(key, index)} * bound) >> 64);
}

}  // namespace sinew
