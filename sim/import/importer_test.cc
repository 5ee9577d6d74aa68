#include "sim/import/importer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

class ImporterTest : public ::testing::Test {
 protected:
  ImporterTest() {
    auto loaded = character::Character::Load("humanoid", v1::Physics());
    EXPECT_THAT(loaded, IsOk());
    character_ = *std::move(loaded);
  }

  static std::string Path(const std::string& name) {
    return JoinPath(::testing::TempDir(), name);
  }
  static std::string Write(const std::string& name, const std::string& text) {
    EXPECT_THAT(WriteFileAtomically(Path(name), text), IsOk());
    return Path(name);
  }
  std::unique_ptr<motion::Library> Import(
      const std::vector<std::string>& files, const std::string& name) {
    reports_.clear();
    EXPECT_THAT(
        ImportFiles(*character_, files, options_, Path(name), &reports_),
        IsOk());
    auto library = motion::Library::Load(Path(name));
    EXPECT_THAT(library, IsOk());
    return *std::move(library);
  }
  // Height of the lowest body frame, m.
  static double LowestBody(const motion::Library& library, int clip,
                           int64_t frame) {
    const float* position = library.frame(clip, frame).body_position;
    double lowest = INFINITY;
    for (int b = 0; b < library.num_bodies(); ++b) {
      lowest = std::min(lowest, double{position[3 * b + 2]});
    }
    return lowest;
  }

  std::unique_ptr<const character::Character> character_;
  ImportOptions options_;
  std::vector<ClipReport> reports_;
};

TEST_F(ImporterTest, BringsAMarchToTheFloorAndMakesItPhysical) {
  const auto library =
      Import({Write("march.txt", testing::MarchJson()),
              Write("floats.txt", testing::MarchJson(0.13))},
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

TEST_F(ImporterTest, BringsALyingBodyToTheFloor) {
  const auto library =
      Import({Write("lying.txt", testing::LyingJson())}, "lying");
  for (int64_t t = 0; t < library->clip(0).num_frames(); ++t) {
    // Limbs are a few centimetres thick.
    EXPECT_LT(LowestBody(*library, 0, t), 0.15) << t;
    EXPECT_GT(LowestBody(*library, 0, t), 0.0) << t;
  }
  EXPECT_LT(reports_[0].info.quality().penetration_max_m(), 0.01);
  EXPECT_EQ(reports_[0].supported_share, 1);
}

TEST_F(ImporterTest, VelocitiesAreThoseOfTheFramesAlsoAcrossTheSeam) {
  const auto library =
      Import({Write("march.txt", testing::MarchJson())}, "velocities");
  const double rate = library->manifest().frames_per_second();
  const int joints = library->num_joints();
  motion::ReferenceFrame before(*library), at(*library), after(*library);
  for (int64_t t = 1; t < 2 * library->clip(0).num_frames(); ++t) {
    before.Load(*library, 0, t - 1);
    at.Load(*library, 0, t);
    after.Load(*library, 0, t + 1);
    for (int j = 0; j < joints; ++j) {
      const double slope = (after.view().joint_position[j] -
                            before.view().joint_position[j]) *
                           rate / 2;
      EXPECT_NEAR(at.view().joint_velocity[j], slope, 2e-4) << t << " " << j;
    }
    for (int i = 0; i < 3 * library->num_bodies(); ++i) {
      const double slope = (after.view().body_position[i] -
                            before.view().body_position[i]) *
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

TEST_F(ImporterTest, OneBadFileDoesNotStopTheOthers) {
  const std::string good = testing::MarchJson();
  const std::vector<std::string> files = {
      Write("text.txt", "no clip at all"),
      Write("good.txt", good),
      Write("cut.txt", good.substr(0, good.size() / 2)),
      Write("nan.txt", absl::StrReplaceAll(good, {{"0.890000000", "NaN"}})),
      Path("absent.txt"),
      Path("good.txt"),
  };
  const auto library = Import(files, "mixed");
  EXPECT_EQ(library->num_clips(), 1);
  ASSERT_EQ(reports_.size(), files.size());
  EXPECT_THAT(reports_[0].status,
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("text.txt: expected JSON")));
  EXPECT_THAT(reports_[1].status, IsOk());
  EXPECT_THAT(reports_[2].status, StatusIs(absl::StatusCode::kInvalidArgument,
                                           HasSubstr("cut.txt")));
  EXPECT_THAT(reports_[3].status,
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("nan.txt: expected finite numbers")));
  EXPECT_THAT(reports_[4].status, StatusIs(absl::StatusCode::kNotFound,
                                           HasSubstr("absent.txt")));
  EXPECT_THAT(reports_[5].status,
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr("expected a unique name")));
}

TEST_F(ImporterTest, WritesNothingWhereNoFileIsGood) {
  EXPECT_THAT(ImportFiles(*character_, {Write("bad.txt", "{}")}, options_,
                          Path("none"), &reports_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected at least one clip")));
  EXPECT_FALSE(FileSize(JoinPath(Path("none"), "manifest.json")).ok());
}

TEST_F(ImporterTest, RefusesARateOutOfRange) {
  options_.rate = 0;
  EXPECT_THAT(ImportFiles(*character_, {}, options_, Path("rate"), &reports_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("rate: expected > 0")));
}

TEST_F(ImporterTest, RecordedClipsKeepTheirQuality) {
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

}  // namespace
}  // namespace sinew::import
