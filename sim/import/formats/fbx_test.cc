#include "sim/import/formats/fbx.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/made_fbx.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing::CheckClip;
using testing::MadeFbx;
using testing::MadeFbxOptions;
using testing::MakeFbx;

// From y up to z up as source_clip.h has it, by 120 degrees about (1, 1, 1).
const Quaterniond kToZUp(0.5, 0.5, 0.5, 0.5);

std::vector<std::string> Names(const SourceClip& clip) {
  std::vector<std::string> names;
  for (const SourceJoint& joint : clip.skeleton.joints) {
    names.push_back(joint.name);
  }
  return names;
}

// Largest differences from what was written, m and rad.
struct Difference {
  double position = 0;
  double rotation = 0;
};

Difference Compare(const SourceClip& clip, const MadeFbx& made,
                   double metres_per_unit, const Quaterniond& turn) {
  Difference difference;
  for (size_t frame = 0; frame < made.world.size(); ++frame) {
    const SourcePose& pose = clip.poses[frame];
    const auto positions =
        WorldPositions(clip.skeleton, pose.root_position, pose.rotation);
    const auto rotations = WorldRotations(clip.skeleton, pose.rotation);
    for (size_t i = 0; i < made.joints.size(); ++i) {
      const int joint = clip.skeleton.Find(made.joints[i]);
      const Eigen::Affine3d& world = made.world[frame][i];
      difference.position = std::max(
          difference.position,
          (positions[joint] - turn * world.translation() * metres_per_unit)
              .norm());
      const Quaterniond turned(
          (world.linear() * made.rest[i].linear().transpose()).eval());
      difference.rotation = std::max(
          difference.rotation,
          motion::AngleBetween(rotations[joint],
                               turn * turned * turn.conjugate()));
    }
  }
  return difference;
}

struct Variant {
  const char* name;
  MadeFbxOptions options;
  double metres_per_unit;
  Quaterniond turn;  // to z up
  char up_axis;
};

class FbxRoundTrip : public ::testing::TestWithParam<Variant> {};

TEST_P(FbxRoundTrip, KeepsEveryJointWhereItWas) {
  const Variant& variant = GetParam();
  const MadeFbx made = MakeFbx(variant.options);
  const auto clip = ParseFbx(made.bytes, "walk", "dir/walk.fbx", {});

  ASSERT_THAT(clip, IsOk());
  CheckClip(*clip);
  EXPECT_EQ(clip->name, "walk");
  EXPECT_THAT(Names(*clip), ::testing::UnorderedElementsAreArray(made.joints));
  for (size_t i = 0; i < made.joints.size(); ++i) {
    const int parent =
        clip->skeleton.joints[clip->skeleton.Find(made.joints[i])].parent;
    EXPECT_EQ(parent < 0 ? "" : clip->skeleton.joints[parent].name,
              made.parents[i] < 0 ? "" : made.joints[made.parents[i]]);
  }
  ASSERT_EQ(clip->poses.size(), made.world.size());
  EXPECT_NEAR(clip->facts.frames_per_second(), made.frames_per_second, 1e-6);
  EXPECT_EQ(clip->facts.format(), "fbx");
  EXPECT_EQ(clip->facts.up_axis(), std::string(1, variant.up_axis));
  EXPECT_NEAR(clip->facts.metres_per_unit(), variant.metres_per_unit, 1e-9);
  EXPECT_THAT(clip->warnings, IsEmpty());
  const Difference difference =
      Compare(*clip, made, variant.metres_per_unit, variant.turn);
  EXPECT_LT(difference.position, 1e-3);
  EXPECT_LT(difference.rotation, 1e-3);
  RecordProperty("position_m", absl::StrCat(difference.position));
  RecordProperty("rotation_rad", absl::StrCat(difference.rotation));
}

INSTANTIATE_TEST_SUITE_P(
    Files, FbxRoundTrip,
    ::testing::Values(
        Variant{"binary", {}, 0.01, kToZUp, 'y'},
        Variant{"text", {.binary = false}, 0.01, kToZUp, 'y'},
        Variant{"no_mesh", {.mesh = false}, 0.01, kToZUp, 'y'},
        Variant{"posed_nodes", {.posed_nodes = true}, 0.01, kToZUp, 'y'},
        Variant{"metres_and_z_up",
                {.centimetres_per_unit = 100, .up_axis = 2},
                1,
                Quaterniond::Identity(),
                'z'},
        Variant{"dense_keys", {.frames_per_second = 60}, 0.01, kToZUp, 'y'}),
    [](const auto& info) { return info.param.name; });

TEST(Fbx, EndsOfLimbsAreJointsThatNeverTurn) {
  const auto clip = ParseFbx(MakeFbx().bytes, "c", "c.fbx", {});

  ASSERT_THAT(clip, IsOk());
  std::vector<std::string> ends;
  for (const SourceJoint& joint : clip->skeleton.joints) {
    if (joint.is_end) ends.push_back(joint.name);
  }
  EXPECT_THAT(ends, ::testing::UnorderedElementsAre(
                        "mixamorig:HeadTop_End", "mixamorig:LeftToeBase",
                        "mixamorig:RightToeBase"));
}

TEST(Fbx, RatesThatOnlyTheKeysTellAreConcluded) {
  const auto stated = ParseFbx(MakeFbx().bytes, "c", "c.fbx", {});
  ASSERT_THAT(stated, IsOk());
  EXPECT_THAT(stated->facts.concluded(), IsEmpty());

  const auto dense = ParseFbx(MakeFbx({.frames_per_second = 60}).bytes, "c",
                              "c.fbx", {});
  ASSERT_THAT(dense, IsOk());
  EXPECT_THAT(dense->facts.concluded(), ElementsAre("frames_per_second"));
}

TEST(Fbx, OptionsGoBeforeTheFile) {
  const auto clip = ParseFbx(MakeFbx().bytes, "c", "c.fbx",
                             {.metres_per_unit = 0.02,
                              .up_axis = 'z',
                              .frames_per_second = 48});

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->poses.size(), 49u);
  EXPECT_EQ(clip->facts.up_axis(), "z");
  EXPECT_NEAR(clip->poses[0].root_position.y(), 2, 0.1) << "100 units";
}

TEST(Fbx, RefusesWhatIsNoFbx) {
  EXPECT_THAT(ParseFbx("HIERARCHY ROOT", "c", "dir/c.fbx", {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("dir/c.fbx: expected an FBX file, found "
                                 "neither")));
}

TEST(Fbx, RefusesFilesWithoutAnimation) {
  std::string text = MakeFbx({.binary = false}).bytes;
  // The connections of curves go to nobody.
  text = absl::StrReplaceAll(
      text, {{"AnimationCurveNode:", "AnimationXurveNode:"}});
  EXPECT_THAT(ParseFbx(text, "c", "dir/c.fbx", {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("dir/c.fbx: "), HasSubstr("expected"))));
}

TEST(Fbx, RefusesLongClips) {
  const auto clip =
      ParseFbx(MakeFbx({.frames = 3, .frames_per_second = 1e-4}).bytes, "c",
               "dir/c.fbx", {});
  EXPECT_THAT(clip, StatusIs(absl::StatusCode::kResourceExhausted,
                             HasSubstr("expected at most 14400 seconds")));
}

TEST(Fbx, TruncatedFilesAreErrorsOrClips) {
  for (const bool binary : {true, false}) {
    const std::string bytes = MakeFbx({.binary = binary, .frames = 3}).bytes;
    for (int i = 0; i < 10; ++i) {
      const auto clip = ParseFbx(bytes.substr(0, bytes.size() * i / 10), "c",
                                 "dir/c.fbx", {});
      if (clip.ok()) CheckClip(*clip);
      if (!clip.ok()) {
        EXPECT_THAT(std::string(clip.status().message()),
                    HasSubstr("dir/c.fbx"));
      }
    }
  }
}

TEST(Fbx, DamagedFilesAreErrorsOrClipsWhateverTheLibraryDoes) {
  std::mt19937 random(7);
  int clips = 0, refused = 0, crashed = 0;
  for (const bool binary : {true, false}) {
    const std::string bytes = MakeFbx({.binary = binary, .frames = 3}).bytes;
    for (int i = 0; i < 40; ++i) {
      std::string damaged = bytes;
      for (int k = 0; k < 1 << (i % 8); ++k) {
        damaged[64 + random() % (damaged.size() - 64)] =
            static_cast<char>(random());
      }
      const auto clip = ParseFbx(damaged, "c", "dir/c.fbx", {});
      if (clip.ok()) CheckClip(*clip);
      if (!clip.ok()) {
        EXPECT_THAT(std::string(clip.status().message()),
                    HasSubstr("dir/c.fbx"));
        ++(absl::StrContains(clip.status().message(), "library fails")
               ? crashed
               : refused);
      }
      clips += clip.ok() ? 1 : 0;
    }
  }
  EXPECT_EQ(clips + refused + crashed, 80);
  RecordProperty("clips", clips);
  RecordProperty("refused", refused);
  RecordProperty("crashed", crashed);
}

}  // namespace
}  // namespace sinew::import
