#include "common/random/philox.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "Random123/philox.h"
#include "absl/types/span.h"
#include "common/check.h"
#include "common/math/double4.h"

namespace sinew {
namespace {

constexpr uint64_t kWordsPerBlock = 4;
constexpr double kTwoToMinus53 = 0x1p-53;
// Bits of 1 and of 2^52, whose last places are 2^-52 and 1.
constexpr uint64_t kBitsOfOne = uint64_t{1023} << 52;
constexpr uint64_t kBitsOfTwoTo52 = uint64_t{1075} << 52;

using Float4 = float __attribute__((ext_vector_type(4)));
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

// The words' upper 53 bits as whole numbers.
Double4 UpperBits(Word4 words) {
  return __builtin_convertvector(words >> Word4(11), Double4);
}

// Natural logarithm of positive normal numbers. x = m 2^e with m in
// [sqrt(1/2), sqrt(2)); ln m = 2 artanh(s), s = (m - 1) / (m + 1), |s| < 0.172,
// by its power series up to s^17 (next term below 2e-16).
Double4 Log(Double4 x) {
  constexpr uint64_t kMantissa = (uint64_t{1} << 52) - 1;
  const Word4 bits = __builtin_bit_cast(Word4, x);
  Double4 exponent =
      __builtin_bit_cast(Double4, (bits >> Word4(52)) | Word4(kBitsOfTwoTo52));
  exponent -= 0x1p52 + 1023;
  Double4 m = __builtin_bit_cast(Double4,
                                 (bits & Word4(kMantissa)) | Word4(kBitsOfOne));
  const auto large = m > Splat4(std::numbers::sqrt2);
  m = large ? m * 0.5 : m;
  exponent = large ? exponent + 1 : exponent;
  const Double4 s = (m - 1) / (m + 1);
  const Double4 z = s * s;
  Double4 series = Splat4(1.0 / 17);
#pragma clang loop unroll(full)
  for (int n = 15; n >= 1; n -= 2) {
    series = __builtin_elementwise_fma(series, z, Splat4(1.0 / n));
  }
  return __builtin_elementwise_fma(2 * s, series, exponent * std::numbers::ln2);
}

// Sine and cosine of 2 pi `turns`, turns in [0, 1): the nearest quarter turn
// is taken off, the rest, at most pi / 4, goes through Taylor series up to
// x^15 and x^16 (next terms below 5e-17). Divides where it could multiply:
// draws keep their bits.
SinCos4 SinCosOfTurns(Double4 turns) {
  const Double4 quarter = __builtin_elementwise_floor(turns * 4 + 0.5);
  const Double4 x = (turns - 0.25 * quarter) * (2 * std::numbers::pi);
  const Double4 z = x * x;
  Double4 sin = Splat4(1);
  Double4 cos = Splat4(1);
#pragma clang loop unroll(full)
  for (int n = 15; n >= 3; n -= 2) {
    sin = 1 - sin * z / static_cast<double>(n * (n - 1));
  }
#pragma clang loop unroll(full)
  for (int n = 16; n >= 2; n -= 2) {
    cos = 1 - cos * z / static_cast<double>(n * (n - 1));
  }
  return AddQuarters({.sin = sin * x, .cos = cos}, quarter);
}

// Eight independent N(0, 1) numbers from two blocks; numbers 2 i and 2 i + 1
// come from words 2 i and 2 i + 1 (Box and Muller, 1958).
std::array<float, 2 * kWordsPerBlock> ToNormals(const Block& first,
                                                const Block& second) {
  const Word4 radius_words = {first[0], first[2], second[0], second[2]};
  const Word4 angle_words = {first[1], first[3], second[1], second[3]};
  // In (0, 1]: the logarithm stays finite.
  const Double4 u = (UpperBits(radius_words) + 1) * kTwoToMinus53;
  const Double4 radius = __builtin_elementwise_sqrt(-2 * Log(u));
  const SinCos4 angle = SinCosOfTurns(UpperBits(angle_words) * kTwoToMinus53);
  const Float4 even = __builtin_convertvector(radius * angle.cos, Float4);
  const Float4 odd = __builtin_convertvector(radius * angle.sin, Float4);
  return {even[0], odd[0], even[1], odd[1], even[2], odd[2], even[3], odd[3]};
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
  constexpr size_t kAtOnce = 2 * kWordsPerBlock;
  for (size_t begin = 0; begin < out.size(); begin += kAtOnce) {
    const size_t count = std::min(kAtOnce, out.size() - begin);
    const uint64_t block = begin / kWordsPerBlock;
    const Block first = DrawBlock(key, block);
    const std::array<float, kAtOnce> numbers = ToNormals(
        first, count > kWordsPerBlock ? DrawBlock(key, block + 1) : first);
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
