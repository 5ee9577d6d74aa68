#include "learner/curriculum/start_rule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/config/recipe.h"
#include "common/random/philox.h"
#include "learner/curriculum/bin_sums.h"

namespace sinew::learner {
namespace {

// Clips of 3, 1 and 2 bins; the second is left out where `left_out`.
v1::CurriculumTable MakeTable(bool left_out = false) {
  v1::CurriculumTable table;
  table.set_bin_frames(10);
  const std::vector<std::vector<int>> clips = {{10, 10, 5}, {10}, {10, 4}};
  for (int c = 0; c < 3; ++c) {
    auto& clip = *table.add_clips();
    clip.set_left_out(left_out && c == 1);
    if (clip.left_out()) continue;
    int first = 0;
    for (const int frames : clips[c]) {
      auto& bin = *table.add_bins();
      bin.set_clip(c);
      bin.set_first_frame(first);
      bin.set_num_frames(frames);
      first += frames;
    }
  }
  return table;
}

void SetEvaluations(v1::CurriculumTable& table, int clip, int failed,
                    bool failed_latest) {
  table.mutable_clips(clip)->set_evaluations(10);
  table.mutable_clips(clip)->set_failed_evaluations(failed);
  table.mutable_clips(clip)->set_failed_latest(failed_latest);
}

std::vector<double> Shares(const StartRule& rule, v1::CurriculumTable& table) {
  rule.Weigh(table);
  return ShareByClip(table);
}

TEST(PhcRules, AreUniformOverClipsWhileNoneFailed) {
  for (const auto& rule : {MakePhcSoftRule(), MakePhcHardRule()}) {
    v1::CurriculumTable table = MakeTable();
    for (const double share : Shares(*rule, table)) {
      EXPECT_NEAR(share, 1.0 / 3, 1e-12);
    }
    // Within the first clip uniform over its 25 frames.
    EXPECT_NEAR(table.bins(2).probability(), 5.0 / 25 / 3, 1e-12);
    EXPECT_EQ(rule->FloorShare(table), 0);
  }
}

TEST(PhcSoftRule, GivesClipsTheirShareOfFailedEvaluations) {
  v1::CurriculumTable table = MakeTable();
  SetEvaluations(table, 0, 1, true);
  SetEvaluations(table, 1, 0, false);
  SetEvaluations(table, 2, 3, false);

  const std::vector<double> shares = Shares(*MakePhcSoftRule(), table);

  EXPECT_NEAR(shares[0], 0.25, 1e-12);
  EXPECT_EQ(shares[1], 0);
  EXPECT_NEAR(shares[2], 0.75, 1e-12);
  EXPECT_NEAR(table.bins(4).probability(), 0.75 * 10 / 14, 1e-12);
}

TEST(PhcSoftRule, IsUniformAgainOnceNoneFailedItsLatestEvaluation) {
  v1::CurriculumTable table = MakeTable();
  SetEvaluations(table, 0, 5, false);

  EXPECT_NEAR(Shares(*MakePhcSoftRule(), table)[0], 1.0 / 3, 1e-12);
}

TEST(PhcHardRule, IsUniformOverClipsThatFailedTheirLatestEvaluation) {
  v1::CurriculumTable table = MakeTable();
  SetEvaluations(table, 0, 9, true);
  SetEvaluations(table, 1, 1, true);
  SetEvaluations(table, 2, 8, false);

  const std::vector<double> shares = Shares(*MakePhcHardRule(), table);

  EXPECT_NEAR(shares[0], 0.5, 1e-12);
  EXPECT_NEAR(shares[1], 0.5, 1e-12);
  EXPECT_EQ(shares[2], 0);
}

TEST(PhcRules, PassOverAFailedClipThatIsLeftOut) {
  for (const auto& rule : {MakePhcSoftRule(), MakePhcHardRule()}) {
    v1::CurriculumTable table = MakeTable(/*left_out=*/true);
    SetEvaluations(table, 1, 4, true);

    const std::vector<double> shares = Shares(*rule, table);

    EXPECT_NEAR(shares[0], 0.5, 1e-12);
    EXPECT_EQ(shares[1], 0);
    EXPECT_NEAR(shares[2], 0.5, 1e-12);
  }
}

v1::AdaptiveBins Defaults() { return WithDefaults(v1::AdaptiveBins()); }

TEST(AdaptiveBinsRule, IsUniformOverFramesWhereNothingWasSeen) {
  v1::AdaptiveBins adaptive = Defaults();
  adaptive.set_clip_floor(0);
  v1::CurriculumTable table = MakeTable();

  MakeAdaptiveBinsRule(adaptive)->Weigh(table);

  for (const auto& bin : table.bins()) {
    EXPECT_NEAR(bin.probability(), bin.num_frames() / 49.0, 1e-12);
  }
}

TEST(AdaptiveBinsRule, FollowsRecentFailuresAboveTheFloor) {
  v1::AdaptiveBins adaptive = Defaults();
  adaptive.set_clip_floor(0);
  adaptive.set_clip_cap(1);
  v1::CurriculumTable table = MakeTable();
  for (auto& bin : *table.mutable_bins()) bin.set_recent_passages(98);
  table.mutable_bins(1)->set_recent_failures(49);  // rate 50 / 100

  const auto rule = MakeAdaptiveBinsRule(adaptive);
  rule->Weigh(table);

  // Weights 10 * 0.5 and 39 * 0.01; floors are a tenth of all.
  EXPECT_NEAR(table.bins(1).probability(), 0.1 * 10 / 49 + 0.9 * 5 / (5 + 0.39),
              1e-12);
  EXPECT_NEAR(table.bins(0).probability(),
              0.1 * 10 / 49 + 0.9 * 0.1 / (5 + 0.39), 1e-12);
  EXPECT_NEAR(rule->FloorShare(table), 0.1, 1e-12);
}

v1::AdaptiveBins ByEvaluations() {
  v1::AdaptiveBins adaptive = Defaults();
  adaptive.set_bin_floor(0);
  adaptive.set_clip_floor(0.3);
  adaptive.set_clip_cap(1);
  adaptive.set_clip_weight(v1::AdaptiveBins::CLIP_WEIGHT_EVALUATIONS);
  return adaptive;
}

TEST(AdaptiveBinsRule, GivesClipsThatAreNotWonAlikeAndOthersTheirFloor) {
  v1::CurriculumTable table = MakeTable();
  SetEvaluations(table, 0, 1, true);
  SetEvaluations(table, 1, 9, false);  // the third was never evaluated
  for (auto& bin : *table.mutable_bins()) bin.set_recent_passages(98);
  table.mutable_bins(2)->set_recent_failures(49);

  const std::vector<double> shares =
      Shares(*MakeAdaptiveBinsRule(ByEvaluations()), table);

  EXPECT_NEAR(shares[0], 0.45, 1e-6);
  EXPECT_NEAR(shares[1], 0.1, 1e-6);
  EXPECT_NEAR(shares[2], 0.45, 1e-6);
  // Within a clip its bins' failures decide: weights 0.1, 0.1 and 2.5.
  EXPECT_NEAR(table.bins(2).probability(), 0.1 * 5 / 25 + 0.35 * 2.5 / 2.7,
              1e-6);
}

TEST(AdaptiveBinsRule, FollowsFailuresOnceAllClipsAreWon) {
  v1::CurriculumTable table = MakeTable();
  for (int c = 0; c < 3; ++c) SetEvaluations(table, c, 1, false);
  for (auto& bin : *table.mutable_bins()) bin.set_recent_passages(98);
  // Of the clip of one bin; however long the others are.
  table.mutable_bins(3)->set_recent_failures(5);

  const std::vector<double> shares =
      Shares(*MakeAdaptiveBinsRule(ByEvaluations()), table);

  EXPECT_NEAR(shares[0], 0.1 + 0.7 * 1 / 8, 1e-9);
  EXPECT_NEAR(shares[1], 0.1 + 0.7 * 6 / 8, 1e-9);
  EXPECT_NEAR(shares[2], 0.1 + 0.7 * 1 / 8, 1e-9);
}

TEST(AdaptiveBinsRule, GivesWonClipsWhatACapCutsOff) {
  v1::CurriculumTable table = MakeTable();
  SetEvaluations(table, 0, 1, true);
  SetEvaluations(table, 1, 1, false);
  SetEvaluations(table, 2, 1, false);
  v1::AdaptiveBins adaptive = ByEvaluations();
  adaptive.set_clip_cap(0.1);  // lifted to 2 / 3

  const std::vector<double> shares =
      Shares(*MakeAdaptiveBinsRule(adaptive), table);

  EXPECT_NEAR(shares[0], 2.0 / 3, 1e-9);
  EXPECT_NEAR(shares[1], 1.0 / 6, 1e-9);
  EXPECT_NEAR(shares[2], 1.0 / 6, 1e-9);
}

// A table of `clips` clips with random bins, some of them left out, and random
// statistics.
v1::CurriculumTable RandomTable(uint64_t seed) {
  const RandomKey key{.seed = seed};
  v1::CurriculumTable table;
  table.set_bin_frames(30);
  const auto clips = static_cast<int>(1 + UniformInt(key, 30));
  uint64_t draw = 1;
  for (int c = 0; c < clips; ++c) {
    auto& clip = *table.add_clips();
    clip.set_left_out(c > 0 && Uniform(key, draw++) < 0.2);
    clip.set_evaluations(5);
    clip.set_failed_evaluations(
        static_cast<int64_t>(UniformInt(key, 6, draw++)));
    clip.set_failed_latest(clip.failed_evaluations() > 2);
    if (clip.left_out()) continue;
    const auto bins = static_cast<int>(1 + UniformInt(key, 12, draw++));
    for (int b = 0; b < bins; ++b) {
      auto& bin = *table.add_bins();
      bin.set_clip(c);
      bin.set_first_frame(30 * b);
      bin.set_num_frames(static_cast<int32_t>(1 + UniformInt(key, 30, draw++)));
      bin.set_visits(static_cast<int64_t>(UniformInt(key, 500, draw++)));
      bin.set_failures(static_cast<int64_t>(UniformInt(key, 500, draw++)));
      bin.set_recent_passages(100 * Uniform(key, draw++));
      // Most bins fail seldom.
      const double u = Uniform(key, draw++);
      bin.set_recent_failures(bin.recent_passages() * u * u);
    }
  }
  return table;
}

v1::Start MakeStart(v1::Start::Rule rule, uint64_t seed) {
  const RandomKey key{.seed = seed, .environment = 1};
  v1::Start start;
  start.set_rule(rule);
  start.set_uniform_share(Uniform(key, 0));
  auto& adaptive = *start.mutable_adaptive();
  adaptive.set_bin_floor(Uniform(key, 1));
  adaptive.set_clip_floor(Uniform(key, 2));
  adaptive.set_clip_cap(0.02 + 0.9 * Uniform(key, 3));
  adaptive.set_clip_weight(seed % 2 == 0
                               ? v1::AdaptiveBins::CLIP_WEIGHT_BINS
                               : v1::AdaptiveBins::CLIP_WEIGHT_EVALUATIONS);
  return start;
}

class EveryRule : public ::testing::TestWithParam<v1::Start::Rule> {};

TEST_P(EveryRule, GivesProbabilitiesThatSumToOne) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    v1::CurriculumTable table = RandomTable(seed);
    const auto rule = MakeStartRule(MakeStart(GetParam(), seed));

    rule->Weigh(table);

    double sum = 0;
    for (const auto& bin : table.bins()) {
      EXPECT_GE(bin.probability(), 0);
      sum += bin.probability();
    }
    EXPECT_NEAR(sum, 1, 1e-12) << seed;
    EXPECT_GE(rule->FloorShare(table), 0);
    EXPECT_LE(rule->FloorShare(table), 1 + 1e-12);
  }
}

TEST_P(EveryRule, IsAFunctionOfTheStatistics) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const auto rule = MakeStartRule(MakeStart(GetParam(), seed));
    v1::CurriculumTable once = RandomTable(seed), again = RandomTable(seed);

    rule->Weigh(once);
    rule->Weigh(again);
    rule->Weigh(again);  // the probabilities before do not matter

    EXPECT_EQ(once.SerializeAsString(), again.SerializeAsString());
  }
}

std::string RuleName(const ::testing::TestParamInfo<v1::Start::Rule>& info) {
  std::string name = v1::Start::Rule_Name(info.param);
  name.erase(std::remove(name.begin(), name.end(), '_'), name.end());
  return name;
}

INSTANTIATE_TEST_SUITE_P(Rules, EveryRule,
                         ::testing::Values(v1::Start::RULE_UNIFORM,
                                           v1::Start::RULE_BINS,
                                           v1::Start::RULE_PHC_SOFT,
                                           v1::Start::RULE_PHC_HARD,
                                           v1::Start::RULE_ADAPTIVE_BINS),
                         RuleName);

TEST(AdaptiveBinsRule, KeepsFloorsOfBinsAndClipsAndTheCap) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    v1::CurriculumTable table = RandomTable(seed);
    v1::Start start = MakeStart(v1::Start::RULE_ADAPTIVE_BINS, seed);
    v1::AdaptiveBins& adaptive = *start.mutable_adaptive();
    // Together at most 1, so that neither is scaled.
    adaptive.set_clip_floor(adaptive.clip_floor() * (1 - adaptive.bin_floor()));

    MakeStartRule(start)->Weigh(table);

    const std::vector<double> shares = ShareByClip(table);
    const std::vector<double> frames = FramesByClip(table);
    const double all_frames = TotalFrames(table);
    const auto clips = static_cast<double>(std::count_if(
        frames.begin(), frames.end(), [](double n) { return n > 0; }));
    for (const auto& bin : table.bins()) {
      EXPECT_GE(bin.probability(),
                adaptive.bin_floor() * bin.num_frames() / all_frames - 1e-12);
    }
    for (size_t c = 0; c < shares.size(); ++c) {
      if (frames[c] == 0) continue;
      const double floor =
          std::max(adaptive.clip_floor() / clips,
                   adaptive.bin_floor() * frames[c] / all_frames);
      EXPECT_GE(shares[c], floor - 1e-12);
      EXPECT_LE(shares[c], std::max({adaptive.clip_cap(),
                                     std::min(1.0, 2 / clips), floor}) +
                               1e-12);
    }
  }
}

TEST(AdaptiveBinsRule, NeverLowersABinWhoseFailuresRise) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const auto rule =
        MakeStartRule(MakeStart(v1::Start::RULE_ADAPTIVE_BINS, seed));
    v1::CurriculumTable table = RandomTable(seed);
    const RandomKey key{.seed = seed, .environment = 2};
    const auto index = static_cast<int>(
        UniformInt(key, static_cast<uint64_t>(table.bins_size())));
    double before = 0;
    for (int step = 0; step <= 10; ++step) {
      auto& bin = *table.mutable_bins(index);
      bin.set_recent_failures(bin.recent_passages() * step / 10);

      rule->Weigh(table);

      EXPECT_GE(bin.probability(), before - 1e-12) << seed << " step " << step;
      before = bin.probability();
    }
  }
}

TEST(FailureRateRule, MixesTheUniformShareInOnce) {
  v1::CurriculumTable table = MakeTable();
  for (auto& bin : *table.mutable_bins()) bin.set_visits(98);
  table.mutable_bins(3)->set_failures(99);

  MakeFailureRateRule(0.2)->Weigh(table);

  // Weights 10 * 1 and 39 / 100.
  EXPECT_NEAR(table.bins(3).probability(),
              0.2 * 10 / 49 + 0.8 * 10 / (10 + 0.39), 1e-12);
}

}  // namespace
}  // namespace sinew::learner
