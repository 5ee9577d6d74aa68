#include "sim/world/start.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>

#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::world {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// Clips of the toy: 24 frames (loops), 20, 16.
constexpr int kStartable = 24 + 19 + 15;

class StartTableTest : public ::testing::Test {
 protected:
  v1::CurriculumTable::Bin* AddBin(int clip, int first, int frames,
                                   double probability) {
    v1::CurriculumTable::Bin* bin = curriculum_.add_bins();
    bin->set_clip(clip);
    bin->set_first_frame(first);
    bin->set_num_frames(frames);
    bin->set_probability(probability);
    return bin;
  }
  absl::StatusOr<StartTable> Create() {
    return StartTable::Create(recipe_, *toy_.library, curriculum_);
  }
  // Share of draws by (clip, frame).
  std::map<std::pair<int, int>, double> Shares(const StartTable& table,
                                               int draws) {
    std::map<std::pair<int, int>, double> shares;
    for (int i = 0; i < draws; ++i) {
      const StartFrame start = table.Draw(5, i % 64, i / 64);
      shares[{start.clip, start.frame}] += 1.0 / draws;
    }
    return shares;
  }

  testing::ToyWorld toy_ = testing::MakeToyWorld();
  v1::Start recipe_;
  v1::CurriculumTable curriculum_;
};

TEST_F(StartTableTest, DrawsEveryFrameThatHasASuccessorAlike) {
  const auto table = Create();
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->num_frames(), kStartable);

  const auto shares = Shares(*table, 100000);

  EXPECT_EQ(shares.size(), kStartable);
  for (const auto& [start, share] : shares) {
    EXPECT_NEAR(share * kStartable, 1, 0.15);  // 6 standard deviations
  }
}

TEST_F(StartTableTest, IsAFunctionOfItsArguments) {
  const auto table = Create();
  ASSERT_TRUE(table.ok());

  const StartFrame first = table->Draw(1, 2, 3);
  int same = 0;
  for (uint64_t episode = 0; episode < 100; ++episode) {
    const StartFrame other = table->Draw(1, 2, episode);
    same += other.clip == first.clip && other.frame == first.frame ? 1 : 0;
  }

  EXPECT_EQ(table->Draw(1, 2, 3).frame, first.frame);
  EXPECT_LT(same, 20);
}

TEST_F(StartTableTest, DrawsBinsByTheirProbabilityUnderEveryOtherRule) {
  AddBin(0, 0, 12, 0.75);
  AddBin(1, 10, 10, 0.25);  // its last frame cannot be started at
  AddBin(2, 0, 16, 0);
  for (const auto rule :
       {v1::Start::RULE_BINS, v1::Start::RULE_PHC_SOFT,
        v1::Start::RULE_PHC_HARD, v1::Start::RULE_ADAPTIVE_BINS}) {
    recipe_.set_rule(rule);
    recipe_.set_uniform_share(0.1);  // the learner has mixed it in
    const auto table = Create();
    ASSERT_TRUE(table.ok()) << table.status();

    const auto shares = Shares(*table, 100000);

    EXPECT_EQ(shares.size(), 12u + 9u);
    EXPECT_NEAR(shares.at({0, 3}), 0.75 / 12, 0.004);
    EXPECT_NEAR(shares.at({1, 18}), 0.25 / 9, 0.004);
    EXPECT_EQ(shares.count({0, 20}), 0u);
    EXPECT_EQ(shares.count({1, 19}), 0u);
  }
}

TEST_F(StartTableTest, NeverDrawsFromALeftOutClip) {
  LeaveOut({1}, toy_);
  const auto table = Create();
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->num_frames(), 24 + 15);

  const auto shares = Shares(*table, 20000);

  EXPECT_EQ(shares.size(), 24u + 15u);
  EXPECT_EQ(shares.count({1, 0}), 0u);
  EXPECT_EQ(shares.count({2, 14}), 1u);
}

TEST_F(StartTableTest, DrawsFromTheNamedClipsAloneUnderEveryRule) {
  recipe_.add_only_clips("sway");
  AddBin(0, 0, 24, 0);
  AddBin(1, 0, 10, 0.75);
  AddBin(1, 10, 9, 0.25);
  AddBin(2, 0, 15, 0);
  for (const auto rule :
       {v1::Start::RULE_UNIFORM, v1::Start::RULE_BINS, v1::Start::RULE_PHC_SOFT,
        v1::Start::RULE_PHC_HARD, v1::Start::RULE_ADAPTIVE_BINS}) {
    recipe_.set_rule(rule);
    const auto table = Create();
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_EQ(table->num_frames(), 19);

    const auto shares = Shares(*table, 20000);

    EXPECT_EQ(shares.size(), 19u) << rule;
    for (const auto& [start, share] : shares) EXPECT_EQ(start.first, 1);
  }
}

TEST_F(StartTableTest, DrawsFromTheOthersByTheirBinsUnderEveryRule) {
  recipe_.add_only_clips("sway");
  recipe_.set_other_clips_share(0.25);
  AddBin(0, 0, 24, 0.25);
  AddBin(1, 0, 19, 0.75);
  AddBin(2, 0, 15, 0);
  for (const auto rule :
       {v1::Start::RULE_UNIFORM, v1::Start::RULE_ADAPTIVE_BINS}) {
    recipe_.set_rule(rule);
    const auto table = Create();
    ASSERT_TRUE(table.ok()) << table.status();
    EXPECT_EQ(table->num_frames(), 24 + 19 + 15);
    double sway = 0;

    for (const auto& [start, share] : Shares(*table, 20000)) {
      EXPECT_NE(start.first, 2);
      if (start.first == 1) sway += share;
    }

    EXPECT_NEAR(sway, 0.75, 0.02) << rule;
  }
}

TEST_F(StartTableTest, HasNoFramesWhereTheNamedClipsAreElsewhere) {
  recipe_.add_only_clips("another");

  const auto table = Create();

  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->num_frames(), 0);
}

TEST_F(StartTableTest, RefusesLeftOutBins) {
  LeaveOut({0}, toy_);
  recipe_.set_rule(v1::Start::RULE_BINS);
  AddBin(0, 0, 12, 1);
  EXPECT_THAT(Create(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("curriculum.bins[0].clip: expected one to "
                                 "train on, found turn, which is left out")));
}

TEST_F(StartTableTest, HasNoFramesOfALibraryWithNothingToTrainOn) {
  LeaveOut({0, 1, 2}, toy_);

  const auto table = Create();

  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_EQ(table->num_frames(), 0);
}

TEST_F(StartTableTest, IsUniformWithoutBins) {
  recipe_.set_rule(v1::Start::RULE_BINS);
  const auto table = Create();
  ASSERT_TRUE(table.ok());

  EXPECT_EQ(Shares(*table, 20000).size(), kStartable);
}

TEST_F(StartTableTest, RefusesBinsThatDoNotFit) {
  recipe_.set_rule(v1::Start::RULE_BINS);
  const auto expect = [this](const char* message) {
    EXPECT_THAT(Create(), StatusIs(absl::StatusCode::kInvalidArgument,
                                   HasSubstr(message)));
    curriculum_.Clear();
  };
  AddBin(3, 0, 4, 1);
  expect("curriculum.bins[0].clip: expected 0 to 2, found 3");
  AddBin(0, 20, 5, 1);
  expect("within 0 to 24 of clip turn with one to start at, found 20 to 25");
  AddBin(1, 19, 1, 1);
  expect("within 0 to 20 of clip sway with one to start at, found 19 to 20");
  AddBin(0, 0, 5, -0.5);
  expect("curriculum.bins[0].probability: expected >= 0, found -0.5");
  AddBin(0, 0, 5, 0.5);
  expect("expected probabilities that sum to 1, found 0.5");
}

}  // namespace
}  // namespace sinew::world
