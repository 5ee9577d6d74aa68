#include "sim/motion/library.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/motion/rotation.h"
#include "sim/motion/testing/sample_library.h"

namespace sinew::motion {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using testing::Files;
using testing::Folder;
using testing::GoodFiles;
using ::testing::HasSubstr;
using testing::kFrames;
using testing::kRate;
using testing::kTurn;
using testing::MakeSample;
using testing::Sample;
using testing::SaveAndLoad;

TEST(Library, LoadsWhatWasSaved) {
  const auto library = SaveAndLoad("saved");
  EXPECT_EQ(library->num_clips(), 2);
  EXPECT_EQ(library->FindClip("once"), 1);
  EXPECT_EQ(library->FindClip("twice"), -1);
  const FrameView view = library->frame(1, 2);
  EXPECT_FLOAT_EQ(view.joint_position[0], 0.1F * (kFrames + 2));
  EXPECT_FLOAT_EQ(view.feedforward_torque[0], 3.F * (kFrames + 2));
  EXPECT_EQ(view.contact[0], 1);
}

TEST(Library, GivesEqualDigestsToEqualContent) {
  EXPECT_EQ(SaveAndLoad("one")->digest(), SaveAndLoad("two")->digest());
}

TEST(ReferenceFrame, GoesOnAlongTheCircleCycleAfterCycle) {
  const auto library = SaveAndLoad("wrap");
  ReferenceFrame frame(*library);
  for (const int64_t t : {0, 5, 12, 13, 40, 1207}) {
    frame.Load(0, t);
    const double yaw = kTurn * static_cast<double>(t) / kFrames;
    const FrameView& view = frame.view();
    EXPECT_NEAR(view.root_position[0], 5 + std::sin(yaw), 1e-4) << t;
    EXPECT_NEAR(view.root_position[1], 3 - std::cos(yaw), 1e-4) << t;
    EXPECT_NEAR(view.body_position[1], 3 - std::cos(yaw), 1e-4) << t;
    const double speed = kTurn * kRate / kFrames;
    EXPECT_NEAR(view.root_linear_velocity[0], speed * std::cos(yaw), 1e-4);
    EXPECT_NEAR(view.body_linear_velocity[1], speed * std::sin(yaw), 1e-4);
    EXPECT_NEAR(AngleBetween(FromWxyz(view.root_rotation).normalized(),
                             YawRotation(yaw)),
                0, 1e-3);
    EXPECT_FLOAT_EQ(view.joint_position[0], 0.1F * (t % kFrames));
  }
}

TEST(ReferenceFrame, VelocitiesAreTheDifferencesOfPositionsAlsoAtTheSeam) {
  const auto library = SaveAndLoad("seam");
  ReferenceFrame before(*library), at(*library), after(*library);
  for (int64_t t = 1; t < 3 * kFrames; ++t) {
    before.Load(0, t - 1);
    at.Load(0, t);
    after.Load(0, t + 1);
    for (int i = 0; i < 2; ++i) {
      const double slope =
          (after.view().root_position[i] - before.view().root_position[i]) *
          kRate / 2;
      EXPECT_NEAR(at.view().root_linear_velocity[i], slope, 2e-3) << t;
    }
  }
}

TEST(ReferenceFrame, AClipThatEndsStandsStillAtItsLastFrame) {
  const auto library = SaveAndLoad("end");
  ReferenceFrame frame(*library);
  frame.Load(1, kFrames + 3);
  EXPECT_FLOAT_EQ(frame.view().joint_position[0], 0.1F * (2 * kFrames - 1));
  EXPECT_EQ(frame.view().joint_velocity[0], 0);
  EXPECT_EQ(frame.view().root_linear_velocity[0], 0);
  EXPECT_EQ(frame.view().body_angular_velocity[2], 0);
}

TEST(Library, RefusesATruncatedFramesFileByName) {
  const Files files = GoodFiles();
  for (const size_t size : {size_t{0}, size_t{100}, files.frames.size() - 1}) {
    EXPECT_THAT(
        Library::FromBytes(files.manifest, files.frames.substr(0, size), "lib"),
        StatusIs(absl::StatusCode::kDataLoss,
                 HasSubstr("lib: frames.safetensors: expected SHA-256")));
  }
}

TEST(Library, RefusesAFlippedBitAnywhereInTheFrames) {
  Files files = GoodFiles();
  for (size_t i = 0; i < files.frames.size(); i += 97) {
    files.frames[i] = static_cast<char>(files.frames[i] ^ 4);
    EXPECT_THAT(Library::FromBytes(files.manifest, files.frames, "lib"),
                StatusIs(absl::StatusCode::kDataLoss));
    files.frames[i] = static_cast<char>(files.frames[i] ^ 4);
  }
}

TEST(Library, RefusesATruncatedManifestAndANewerVersion) {
  const Files files = GoodFiles();
  EXPECT_THAT(
      Library::FromBytes(files.manifest.substr(0, files.manifest.size() / 2),
                         files.frames, "lib"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("lib: manifest: expected a motion library")));
  const std::string newer = absl::StrReplaceAll(
      files.manifest,
      {{"\"format_version\": 1", "\"format_version\": 2, \"new_field\": 3"}});
  ASSERT_NE(newer, files.manifest);
  EXPECT_THAT(
      Library::FromBytes(newer, files.frames, "lib"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("format_version: expected 1, found 2 (written by a "
                         "newer version)")));
}

TEST(Library, NamesFolderAndFileThatIsNotThere) {
  EXPECT_THAT(Library::Load(Folder("nowhere")),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("nowhere/manifest.json")));
}

TEST(Library, NamesClipFrameAndTensorOfABadValue) {
  const auto save = [](const Sample& sample) {
    return Library::Save(sample.manifest, sample.frames, Folder("bad"));
  };
  Sample sample = MakeSample();
  sample.frames["joint_position"].mutable_float32()[kFrames + 3] =
      std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(save(sample),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("clip \"once\" frame 3 joint_position: "
                                 "expected a finite number of at most 1e6, "
                                 "found nan")));
  sample = MakeSample();
  sample.frames["body_rotation"].mutable_float32()[4] = 2;
  EXPECT_THAT(save(sample),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("clip \"arc\" frame 1 body_rotation: expected "
                                 "a unit quaternion, found norm 2")));
  sample = MakeSample();
  sample.frames["contact"].mutable_float32()[0] = 1.5F;
  EXPECT_THAT(save(sample), StatusIs(absl::StatusCode::kInvalidArgument,
                                     HasSubstr("a number from 0 to 1")));
  EXPECT_FALSE(FileSize(JoinPath(Folder("bad"), "manifest.json")).ok())
      << "nothing may be written";
}

TEST(Library, RefusesWrongShapesNamesAndSizes) {
  const auto save = [](const Sample& sample) {
    return Library::Save(sample.manifest, sample.frames, Folder("bad"));
  };
  Sample sample = MakeSample();
  sample.frames.erase("contact");
  EXPECT_THAT(save(sample), StatusIs(absl::StatusCode::kInvalidArgument,
                                     HasSubstr("tensor contact: expected it, "
                                               "found no such tensor")));
  sample = MakeSample();
  sample.manifest.add_joints("second");
  EXPECT_THAT(save(sample), StatusIs(absl::StatusCode::kInvalidArgument,
                                     HasSubstr("expected shape [24, 2]")));
  sample = MakeSample();
  sample.manifest.mutable_clips(1)->set_name("arc");
  EXPECT_THAT(save(sample),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("clips: expected unique names")));
  sample = MakeSample();
  sample.manifest.mutable_clips(0)->set_num_frames(0);
  EXPECT_THAT(save(sample),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("clip \"arc\" num_frames: expected at least "
                                 "2, found 0")));
  sample = MakeSample();
  sample.manifest.clear_clips();
  EXPECT_THAT(save(sample),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("clips: expected some, found none")));
  sample = MakeSample();
  sample.manifest.set_frames_per_second(-30);
  EXPECT_THAT(save(sample),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("frames_per_second: expected > 0")));
}

}  // namespace
}  // namespace sinew::motion
