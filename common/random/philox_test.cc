#include "common/random/philox.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "absl/types/span.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::testing::ElementsAreArray;
using ::testing::Not;

RandomKey MakeKey() {
  return {.seed = 1,
          .environment = 2,
          .episode = 3,
          .step = 4,
          .purpose = RandomPurpose::kAction};
}

std::vector<float> Uniforms(const RandomKey& key, int count) {
  std::vector<float> out(count);
  FillUniform(key, absl::MakeSpan(out));
  return out;
}

std::vector<float> Normals(const RandomKey& key, int count) {
  std::vector<float> out(count);
  FillNormal(key, absl::MakeSpan(out));
  return out;
}

// Philox4x64-10 written down a second time, from the paper's description:
// ten rounds of two 64 x 64 -> 128 bit products, the key raised between them.
std::array<uint64_t, 4> PlainPhilox(std::array<uint64_t, 4> c, uint64_t k0,
                                    uint64_t k1) {
  __extension__ using Wide = unsigned __int128;
  for (int round = 0; round < 10; ++round) {
    const Wide a = Wide{0xD2E7470EE14C6C93} * c[0];
    const Wide b = Wide{0xCA5A826395121157} * c[2];
    c = {static_cast<uint64_t>(b >> 64) ^ c[1] ^ k0, static_cast<uint64_t>(b),
         static_cast<uint64_t>(a >> 64) ^ c[3] ^ k1, static_cast<uint64_t>(a)};
    k0 += 0x9E3779B97F4A7C15;
    k1 += 0xBB67AE8584CAA73B;
  }
  return c;
}

// Words 0 .. 4 * blocks - 1 of the stream of a key.
std::vector<uint64_t> PlainWords(const RandomKey& key, int blocks) {
  std::vector<uint64_t> words;
  for (int block = 0; block < blocks; ++block) {
    const auto c = PlainPhilox(
        {static_cast<uint64_t>(block), key.step, key.episode, key.environment},
        key.seed, static_cast<uint64_t>(key.purpose));
    words.insert(words.end(), c.begin(), c.end());
  }
  return words;
}

TEST(Philox, PlainFormGivesThePublishedKnownAnswer) {
  // Random123's known-answer file, philox4x64 10, counter and key zero.
  EXPECT_THAT(
      PlainPhilox({0, 0, 0, 0}, 0, 0),
      ElementsAreArray<uint64_t>({0x16554d9eca36314c, 0xdb20fe9d672d0fdc,
                                  0xd7e772cee186176b, 0x7e68b68aec7ba23b}));
}

TEST(FillUniform, EqualsThePlainForm) {
  const std::vector<uint64_t> words = PlainWords(MakeKey(), 3);

  const std::vector<float> out = Uniforms(MakeKey(), 24);

  for (int i = 0; i < 24; ++i) {
    const uint64_t half = (words[i / 2] >> (i % 2 * 32)) & 0xffffffff;
    EXPECT_EQ(out[i], static_cast<double>(half >> 8) / 16777216.0) << i;
  }
}

TEST(Uniform, EqualsThePlainForm) {
  const std::vector<uint64_t> words = PlainWords(MakeKey(), 3);

  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(Uniform(MakeKey(), i),
              static_cast<double>(words[i] >> 11) / 9007199254740992.0);
  }
}

TEST(FillNormal, EqualsBoxMullerInTheCLibrary) {
  const int blocks = 5000;
  const std::vector<uint64_t> words = PlainWords(MakeKey(), blocks);

  const std::vector<float> out = Normals(MakeKey(), 4 * blocks);

  for (int i = 0; i < 4 * blocks; i += 2) {
    const double u = ((words[i] >> 11) + 1.0) / 9007199254740992.0;
    const double v = (words[i + 1] >> 11) / 9007199254740992.0;
    const double r = std::sqrt(-2 * std::log(u));
    const double a = 2 * std::numbers::pi * v;
    // Rounding to float: 2^-24 of a number below 8.
    EXPECT_NEAR(out[i], r * std::cos(a), 5e-7);
    EXPECT_NEAR(out[i + 1], r * std::sin(a), 5e-7);
  }
}

TEST(FillNormal, KeepsItsBits) {
  // Golden: what a run with a given seed draws must not change unnoticed.
  EXPECT_THAT(Normals(MakeKey(), 5),
              ElementsAreArray({0x1.782f5ep+0f, 0x1.0a9deap+1f, 0x1.de8462p+1f,
                                0x1.7d9e28p-1f, -0x1.6c776ap-3f}));
}

TEST(FillUniform, DoesNotDependOnHowManyAreDrawn) {
  const std::vector<float> all = Uniforms(MakeKey(), 37);

  for (int count = 0; count < 37; ++count) {
    EXPECT_THAT(Uniforms(MakeKey(), count),
                ElementsAreArray(all.begin(), all.begin() + count));
  }
}

TEST(FillNormal, DoesNotDependOnHowManyAreDrawn) {
  const std::vector<float> all = Normals(MakeKey(), 21);

  for (int count = 0; count < 21; ++count) {
    EXPECT_THAT(Normals(MakeKey(), count),
                ElementsAreArray(all.begin(), all.begin() + count));
  }
}

TEST(Philox, EveryPartOfTheKeyChangesTheNumbers) {
  const std::vector<float> base = Uniforms(MakeKey(), 4);
  std::vector<RandomKey> keys(5, MakeKey());
  keys[0].seed += uint64_t{1} << 63;
  keys[1].environment += uint64_t{1} << 40;
  keys[2].episode += uint64_t{1} << 40;
  keys[3].step += uint64_t{1} << 40;
  keys[4].purpose = RandomPurpose::kShuffle;

  for (const RandomKey& key : keys) {
    EXPECT_THAT(Uniforms(key, 4), Not(ElementsAreArray(base)));
  }
}

TEST(FillUniform, HasTheMomentsOfAUniform) {
  const int n = 200000;
  double sum = 0;
  double squares = 0;
  for (const float u : Uniforms(MakeKey(), n)) {
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    sum += u;
    squares += u * u;
  }

  // Five standard errors: 5 * 0.289 / sqrt(n) = 0.0032; 5 * 0.298 / sqrt(n).
  EXPECT_NEAR(sum / n, 0.5, 0.0033);
  EXPECT_NEAR(squares / n, 1.0 / 3, 0.0034);
}

TEST(FillNormal, HasTheMomentsOfANormal) {
  const int n = 200000;
  std::array<double, 5> moment = {};
  for (const float x : Normals(MakeKey(), n)) {
    for (int k = 1; k <= 4; ++k) moment[k] += std::pow(x, k) / n;
  }

  // Five standard errors: 5 sqrt((E x^2k - (E x^k)^2) / n).
  EXPECT_NEAR(moment[1], 0, 0.012);
  EXPECT_NEAR(moment[2], 1, 0.016);
  EXPECT_NEAR(moment[3], 0, 0.044);
  EXPECT_NEAR(moment[4], 3, 0.11);
}

TEST(UniformInt, ReachesEveryValueAboutEquallyOften) {
  std::array<int, 7> counts = {};
  for (int i = 0; i < 70000; ++i) ++counts.at(UniformInt(MakeKey(), 7, i));

  // Five standard deviations of a count of mean 10000: 5 * 92.6.
  for (const int count : counts) EXPECT_NEAR(count, 10000, 463);
}

TEST(UniformInt, IsZeroForABoundOfOne) {
  EXPECT_EQ(UniformInt(MakeKey(), 1, 5), 0u);
}

}  // namespace
}  // namespace sinew
