#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "sim/import/clip_report.h"
#include "sim/import/importer.h"
#include "sim/import/testing/import_fixture.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class ImporterMotionTest : public testing::ImportFixture {};

// Height of the lowest body frame, m.
double LowestBody(const motion::Library& library, int clip, int64_t frame) {
  const float* position = library.frame(clip, frame).body_position;
  double lowest = INFINITY;
  for (int b = 0; b < library.num_bodies(); ++b) {
    lowest = std::min(lowest, double{position[3 * b + 2]});
  }
  return lowest;
}

TEST_F(ImporterMotionTest, BringsAMarchToTheFloorAndMakesItPhysical) {
  const auto library =
      Import({WriteTestFile("march.txt", testing::MarchJson()),
              WriteTestFile("floats.txt", testing::MarchJson(0.13))},
             "march");
  ASSERT_EQ(library->num_clips(), 2);
  for (const ClipReport& report : reports_) {
    const v1::ClipQuality& quality = report.info.quality();
    EXPECT_LT(quality.residual_force_bodyweights(), 0.1) << report.name;
    EXPECT_LT(quality.joint_fit_max_rad(), 0.3) << report.name;
    EXPECT_LT(quality.penetration_max_m(), 0.01) << report.name;
    EXPECT_LT(quality.floating_mean_m(), 0.01) << report.name;
    EXPECT_LT(quality.loop_seam_m(), 0.05) << report.name;
  }
  // A floating capture gives the same motion.
  for (int64_t t = 0; t < library->clip(0).num_frames(); ++t) {
    EXPECT_NEAR(library->frame(0, t).root_position[2],
                library->frame(1, t).root_position[2], 0.005);
  }
}

TEST_F(ImporterMotionTest, BringsALyingBodyToTheFloor) {
  const auto library =
      Import({WriteTestFile("lying.txt", testing::LyingJson())}, "lying");
  for (int64_t t = 0; t < library->clip(0).num_frames(); ++t) {
    // Limbs are a few centimetres thick.
    EXPECT_LT(LowestBody(*library, 0, t), 0.15) << t;
    EXPECT_GT(LowestBody(*library, 0, t), 0.0) << t;
  }
  EXPECT_LT(reports_[0].info.quality().penetration_max_m(), 0.01);
  EXPECT_EQ(reports_[0].supported_share, 1);
}

TEST_F(ImporterMotionTest, VelocitiesAreThoseOfTheFramesAlsoAcrossTheSeam) {
  const auto library =
      Import({WriteTestFile("march.txt", testing::MarchJson())}, "velocities");
  const double rate = library->manifest().frames_per_second();
  const int joints = library->num_joints();
  motion::ReferenceFrame before(*library), at(*library), after(*library);
  for (int64_t t = 1; t < 2 * library->clip(0).num_frames(); ++t) {
    before.Load(0, t - 1);
    at.Load(0, t);
    after.Load(0, t + 1);
    for (int j = 0; j < joints; ++j) {
      const double slope =
          (after.view().joint_position[j] - before.view().joint_position[j]) *
          rate / 2;
      EXPECT_NEAR(at.view().joint_velocity[j], slope, 2e-4) << t << " " << j;
    }
    for (int i = 0; i < 3 * library->num_bodies(); ++i) {
      const double slope =
          (after.view().body_position[i] - before.view().body_position[i]) *
          rate / 2;
      // Second order in the spacing of the frames.
      EXPECT_NEAR(at.view().body_linear_velocity[i], slope, 0.15) << t;
    }
    const Eigen::Vector3d turn = motion::CentralAngularVelocity(
        motion::FromWxyz(before.view().root_rotation).normalized(),
        motion::FromWxyz(at.view().root_rotation).normalized(),
        motion::FromWxyz(after.view().root_rotation).normalized(), 1 / rate);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(at.view().root_angular_velocity[i], turn[i], 5e-3) << t;
    }
  }
}

TEST_F(ImporterMotionTest, AddsMirrorImagesUnderNamesOfTheirOwn) {
  options_.edits.mirror = true;
  const auto library =
      Import({WriteTestFile("march.txt", testing::MarchJson()),
              WriteTestFile("lying_mirror.txt", testing::LyingJson()),
              WriteTestFile("lying.txt", testing::LyingJson())},
             "mirrored");

  // The mirror image of "lying" finds its name taken.
  ASSERT_THAT(reports_, SizeIs(6));
  EXPECT_THAT(reports_[5].status,
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr("found a file called lying_mirror")));
  EXPECT_EQ(library->num_clips(), 5);
  EXPECT_EQ(library->clip(1).name(), "march_mirror");
  EXPECT_EQ(library->clip(1).mirror_of(), "march");
  EXPECT_EQ(library->clip(1).trial(), "march");
  EXPECT_EQ(library->clip(0).mirror_of(), "");
  // It walks along x too, and sways to the other side.
  const int64_t last = library->clip(0).num_frames() - 1;
  EXPECT_NEAR(library->frame(1, last).root_position[0],
              library->frame(0, last).root_position[0], 1e-4);
  EXPECT_NEAR(library->frame(1, last).root_position[1],
              -library->frame(0, last).root_position[1], 1e-4);
}

TEST_F(ImporterMotionTest, RecordedClipsKeepTheirQuality) {
  const std::vector<std::string> files = testing::RecordedClips();
  if (files.empty()) GTEST_SKIP() << "SINEW_DATA is not set";
  Import(files, "recorded");
  for (const ClipReport& report : reports_) {
    EXPECT_THAT(report.status, IsOk());
    const v1::ClipQuality& quality = report.info.quality();
    EXPECT_LT(quality.residual_force_bodyweights(), 0.25) << report.name;
    EXPECT_LT(quality.penetration_max_m(), 0.02) << report.name;
    EXPECT_LT(quality.floating_mean_m(), 0.01) << report.name;
    EXPECT_LT(quality.joint_fit_mean_rad(), 0.1) << report.name;
  }
}

TEST_F(ImporterMotionTest, SecondsAreThoseThatTrimmingLeaves) {
  options_.edits.from_s = 0.2;
  options_.edits.to_s = 0.7;

  const auto library =
      Import({WriteTestFile("march.txt", testing::MarchJson())}, "trimmed");

  EXPECT_NEAR(reports_[0].duration_s, 0.5, 0.05);
  EXPECT_NEAR(reports_[0].duration_s,
              static_cast<double>(library->clip(0).num_frames()) / 30, 1e-9);
}

TEST_F(ImporterMotionTest, RejectsAClipThatIsOverBeforeABodyCanFall) {
  options_.edits.from_s = 0.2;
  options_.edits.to_s = 0.3;

  EXPECT_THAT(ImportFiles(*character_,
                          {WriteTestFile("march.txt", testing::MarchJson())},
                          options_, TestPath("short"), &reports_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected at least one clip")));

  ASSERT_THAT(reports_, SizeIs(1));
  EXPECT_EQ(reports_[0].verdict.status, ClipStatus::kRejected);
  EXPECT_THAT(reports_[0].status,
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("march.txt: length 0.1")));
  EXPECT_THAT(reports_[0].verdict.reason, HasSubstr("expected at least 0.2 s"));
}

}  // namespace
}  // namespace sinew::import
