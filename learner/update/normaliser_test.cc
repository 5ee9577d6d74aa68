#include "learner/update/normaliser.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/random/philox.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::learner {
namespace {

constexpr int64_t kWidth = 3;

// Rows with far apart means and spreads, so that cancellation would show.
std::vector<float> MakeRows(int64_t count, uint64_t seed) {
  std::vector<float> rows(count * kWidth);
  FillNormal({.seed = seed}, absl::MakeSpan(rows));
  for (size_t i = 0; i < rows.size(); ++i) {
    const float scale[] = {1, 1e-3f, 100};
    const float shift[] = {0, 1000, -5};
    rows[i] = shift[i % kWidth] + scale[i % kWidth] * rows[i];
  }
  return rows;
}

Moments MomentsOf(absl::Span<const float> rows) {
  Moments moments(kWidth);
  ComputeMoments(rows, std::vector<uint8_t>(rows.size() / kWidth, 1), moments);
  return moments;
}

// A second way: textbook sums in long double.
void ExpectMoments(const Moments& moments, absl::Span<const float> rows) {
  const size_t count = rows.size() / kWidth;
  ASSERT_EQ(moments.count, count);
  for (int64_t c = 0; c < kWidth; ++c) {
    long double sum = 0, squares = 0;
    for (size_t r = 0; r < count; ++r) sum += rows[r * kWidth + c];
    const long double mean = sum / count;
    for (size_t r = 0; r < count; ++r) {
      const long double d = rows[r * kWidth + c] - mean;
      squares += d * d;
    }
    EXPECT_NEAR(moments.mean[c], static_cast<double>(mean),
                1e-12 * std::abs(static_cast<double>(mean)) + 1e-12);
    EXPECT_NEAR(moments.squares[c] / static_cast<double>(squares), 1, 1e-9);
  }
}

TEST(Normaliser, MomentsEqualTheTextbook) {
  const std::vector<float> rows = MakeRows(1000, 1);
  ExpectMoments(MomentsOf(rows), rows);
}

TEST(Normaliser, MergedMomentsAreThoseOfAllRows) {
  const std::vector<float> rows = MakeRows(1000, 2);
  const absl::Span<const float> all(rows);
  Moments merged(kWidth);

  for (int64_t begin = 0; begin < 1000; begin += 125) {
    MergeMoments(MomentsOf(all.subspan(begin * kWidth, 125 * kWidth)), merged);
  }

  ExpectMoments(merged, rows);
}

TEST(Normaliser, InvalidRowsDoNotCount) {
  std::vector<float> rows = MakeRows(100, 3);
  std::vector<uint8_t> valid(100, 1);
  std::vector<float> kept;
  for (int64_t r = 0; r < 100; ++r) {
    if (r % 7 == 0) {
      valid[r] = 0;
      rows[r * kWidth] = NAN;
    } else {
      kept.insert(kept.end(), &rows[r * kWidth], &rows[r * kWidth] + kWidth);
    }
  }
  Moments moments(kWidth);

  ComputeMoments(rows, valid, moments);

  ExpectMoments(moments, kept);
}

TEST(Normaliser, MergingNothingChangesNothing) {
  const std::vector<float> rows = MakeRows(10, 4);
  Moments moments = MomentsOf(rows);

  MergeMoments(Moments(kWidth), moments);

  ExpectMoments(moments, rows);
}

TEST(Normaliser, WritesWhatMakesRowsStandard) {
  const std::vector<float> rows = MakeRows(5000, 6);
  std::vector<float> mean(kWidth), inverse_std(kWidth);

  WriteNormaliser(MomentsOf(rows), absl::MakeSpan(mean),
                  absl::MakeSpan(inverse_std));

  std::vector<float> standard(rows.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    standard[i] = (rows[i] - mean[i % kWidth]) * inverse_std[i % kWidth];
  }
  const Moments moments = MomentsOf(standard);
  for (int64_t c : {0, 2}) {
    EXPECT_NEAR(moments.mean[c], 0, 1e-5);
    EXPECT_NEAR(moments.squares[c] / 5000, 1, 1e-4);
  }
  // Column 1 has spread 1e-3 (variance 1e-6, against a floor of 1e-8) around
  // 1000, where float32 has steps of 6e-5.
  EXPECT_NEAR(moments.squares[1] / 5000, 1 / 1.01, 0.02);
}

TEST(Normaliser, WithoutRowsIsTheIdentity) {
  std::vector<float> mean(kWidth, 5), inverse_std(kWidth, 5);

  WriteNormaliser(Moments(kWidth), absl::MakeSpan(mean),
                  absl::MakeSpan(inverse_std));

  EXPECT_THAT(mean, ::testing::Each(0.0f));
  EXPECT_THAT(inverse_std, ::testing::Each(1.0f));
}

TEST(Normaliser, InheritedMomentsWriteTheSameNumbers) {
  std::vector<float> mean(kWidth), inverse_std(kWidth);
  WriteNormaliser(MomentsOf(MakeRows(500, 7)), absl::MakeSpan(mean),
                  absl::MakeSpan(inverse_std));
  Moments inherited(kWidth);

  InheritMoments(mean, inverse_std, /*count=*/100, inherited);

  std::vector<float> mean_again(kWidth), inverse_std_again(kWidth);
  WriteNormaliser(inherited, absl::MakeSpan(mean_again),
                  absl::MakeSpan(inverse_std_again));
  EXPECT_EQ(inherited.count, 100);
  EXPECT_EQ(mean_again, mean);
  for (int64_t c = 0; c < kWidth; ++c) {
    EXPECT_NEAR(inverse_std_again[c] / inverse_std[c], 1, 1e-6);
  }
}

TEST(Normaliser, AConstantColumnBecomesZero) {
  const std::vector<float> rows(30, 7.25f);
  std::vector<float> mean(kWidth), inverse_std(kWidth);

  WriteNormaliser(MomentsOf(rows), absl::MakeSpan(mean),
                  absl::MakeSpan(inverse_std));

  EXPECT_THAT(mean, ::testing::Each(7.25f));
  EXPECT_THAT(inverse_std, ::testing::Each(::testing::FloatNear(1e4f, 1)));
}

}  // namespace
}  // namespace sinew::learner
