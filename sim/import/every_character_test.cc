// Human clips on every character that comes with the project.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "sim/character/character.h"
#include "sim/import/clip_report.h"
#include "sim/import/import_clip.h"
#include "sim/import/importer.h"
#include "sim/import/quality_gate.h"
#include "sim/import/retarget/import_model.h"
#include "sim/import/testing/made_clips.h"
#include "sim/import/testing/made_skeletons.h"
#include "sim/motion/library.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::SizeIs;

class EveryCharacterTest : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (absl::string_view(GetParam()) == "h1_2" &&
        std::getenv("SINEW_DATA") == nullptr) {
      GTEST_SKIP() << "SINEW_DATA is not set: the model of h1_2 is there";
    }
    auto loaded = character::Character::Load(GetParam(), v1::Physics());
    ASSERT_THAT(loaded, IsOk());
    character_ = *std::move(loaded);
  }

  std::unique_ptr<const character::Character> character_;
};

TEST_P(EveryCharacterTest, MarchesIntoALibrary) {
  std::vector<ClipReport> reports;

  ASSERT_THAT(ImportFiles(*character_,
                          {WriteTestFile("march.txt", testing::MarchJson())},
                          {}, TestPath("library"), &reports),
              IsOk());

  ASSERT_THAT(reports, SizeIs(1));
  EXPECT_THAT(reports[0].status, IsOk());
  EXPECT_NE(reports[0].verdict.status, ClipStatus::kRejected)
      << reports[0].verdict.reason;
  EXPECT_LT(reports[0].info.quality().penetration_max_m(), 0.04);
  const auto library = motion::Library::Load(TestPath("library"));
  ASSERT_THAT(library, IsOk());
  // A second, which repeats and gets on along x.
  EXPECT_EQ((*library)->clip(0).num_frames(), 30);
  EXPECT_TRUE((*library)->clip(0).loops());
  EXPECT_GT((*library)->clip(0).cycle_x(), 0.4);
}

TEST_P(EveryCharacterTest, TakesASkeletonThatNoMapKnows) {
  const ImportModel model = MakeImportModel(*character_);
  testing::SkeletonStyle t_pose;
  t_pose.arms = 1.5;

  const auto clip = ImportClip(model, testing::MadeClip(t_pose), {});

  ASSERT_THAT(clip, IsOk());
  EXPECT_NEAR(clip->duration_s, 2, 0.1);
  EXPECT_GT(clip->supported_share, 0.9);
  const Verdict verdict = JudgeQuality(clip->info.quality());
  EXPECT_NE(verdict.status, ClipStatus::kRejected) << verdict.reason;
}

INSTANTIATE_TEST_SUITE_P(AllCharacters, EveryCharacterTest,
                         ::testing::Values("cmu_humanoid", "g1", "h1_2",
                                           "humanoid"),
                         [](const auto& info) {
                           return std::string(info.param);
                         });

}  // namespace
}  // namespace sinew::import
