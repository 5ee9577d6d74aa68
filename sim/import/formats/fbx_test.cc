#include "sim/import/formats/fbx.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/workspace_files.h"
#include "sim/import/formats/testing/binary_fbx.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/made_fbx.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::BinaryFbx;
using testing::BinaryFbxOptions;
using testing::CheckClip;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
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

// Largest differences from what was written, m and rad, and the joints.
struct Difference {
  double position = 0;
  double rotation = 0;
  std::string moved, turned;
};

Difference Compare(const SourceClip& clip, const MadeFbx& made,
                   double metres_per_unit, const Quaterniond& turn) {
  Difference difference;
  for (size_t frame = 0; frame < made.world.size(); ++frame) {
    const SourcePose& pose = clip.poses[frame];
    const auto positions = WorldPositions(clip.skeleton, pose);
    const auto rotations = WorldRotations(clip.skeleton, pose.rotation);
    for (size_t i = 0; i < made.joints.size(); ++i) {
      const int joint = clip.skeleton.Find(made.joints[i]);
      const Eigen::Affine3d& world = made.world[frame][i];
      const double moved =
          (positions[joint] - turn * world.translation() * metres_per_unit)
              .norm();
      const Quaterniond expected(
          (world.linear() * made.rest[i].linear().transpose()).eval());
      const double turned = motion::AngleBetween(
          rotations[joint], turn * expected * turn.conjugate());
      if (moved > difference.position) {
        difference.position = moved;
        difference.moved = absl::StrCat(made.joints[i], ", frame ", frame);
      }
      if (turned > difference.rotation) {
        difference.rotation = turned;
        difference.turned = absl::StrCat(made.joints[i], ", frame ", frame);
      }
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
  std::optional<BinaryFbxOptions> binary = std::nullopt;  // else text
};

std::string BytesOf(const Variant& variant, const MadeFbx& made) {
  if (!variant.binary) return made.bytes;
  return BinaryFbx(made.bytes, *variant.binary);
}

class FbxRoundTrip : public ::testing::TestWithParam<Variant> {};

TEST_P(FbxRoundTrip, KeepsEveryJointWhereItWas) {
  const Variant& variant = GetParam();
  const MadeFbx made = MakeFbx(variant.options);
  const auto clip =
      ParseFbx(BytesOf(variant, made), "walk", "dir/walk.fbx", {});

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
  EXPECT_LT(difference.position, 1e-3) << difference.moved;
  EXPECT_LT(difference.rotation, 1e-3) << difference.turned;
  RecordProperty("position_m", absl::StrCat(difference.position));
  RecordProperty("rotation_rad", absl::StrCat(difference.rotation));
}

INSTANTIATE_TEST_SUITE_P(
    Files, FbxRoundTrip,
    ::testing::Values(
        Variant{"mixamo", {}, 0.01, kToZUp, 'y'},
        Variant{"no_mesh", {.mesh = false}, 0.01, kToZUp, 'y'},
        Variant{"metres_and_z_up",
                {.centimetres_per_unit = 100, .up_axis = 2},
                1,
                Quaterniond::Identity(),
                'z'},
        Variant{"dense_keys", {.frames_per_second = 60}, 0.01, kToZUp, 'y'},
        Variant{"binary", {}, 0.01, kToZUp, 'y', BinaryFbxOptions{}},
        Variant{"binary_no_mesh",
                {.mesh = false},
                0.01,
                kToZUp,
                'y',
                BinaryFbxOptions{}},
        Variant{"binary_plain_arrays",
                {},
                0.01,
                kToZUp,
                'y',
                BinaryFbxOptions{.version = 7400, .deflate = false}},
        Variant{"binary_wide_offsets",
                {},
                0.01,
                kToZUp,
                'y',
                BinaryFbxOptions{.version = 7500, .deflate = true}}),
    [](const auto& info) { return info.param.name; });

TEST(Fbx, EndsOfLimbsAreJointsThatNeverTurn) {
  const auto clip = ParseFbx(MakeFbx().bytes, "c", "c.fbx", {});

  ASSERT_THAT(clip, IsOk());
  std::vector<std::string> ends;
  for (const SourceJoint& joint : clip->skeleton.joints) {
    if (joint.is_end) ends.push_back(joint.name);
  }
  EXPECT_THAT(ends, ::testing::UnorderedElementsAre("mixamorig:HeadTop_End",
                                                    "mixamorig:LeftToeBase",
                                                    "mixamorig:RightToeBase"));
}

TEST(Fbx, RatesThatOnlyTheKeysTellAreConcluded) {
  const auto stated = ParseFbx(MakeFbx().bytes, "c", "c.fbx", {});
  ASSERT_THAT(stated, IsOk());
  EXPECT_THAT(stated->facts.concluded(), IsEmpty());

  const auto dense =
      ParseFbx(MakeFbx({.frames_per_second = 60}).bytes, "c", "c.fbx", {});
  ASSERT_THAT(dense, IsOk());
  EXPECT_THAT(dense->facts.concluded(), ElementsAre("frames_per_second"));
}

TEST(Fbx, OptionsGoBeforeTheFile) {
  const auto clip = ParseFbx(
      MakeFbx().bytes, "c", "c.fbx",
      {.metres_per_unit = 0.02, .up_axis = 'z', .frames_per_second = 48});

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
  std::string text = MakeFbx().bytes;
  // The connections of curves go to nobody.
  text = absl::StrReplaceAll(text,
                             {{"AnimationCurveNode:", "AnimationXurveNode:"}});
  EXPECT_THAT(ParseFbx(text, "c", "dir/c.fbx", {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("dir/c.fbx: "), HasSubstr("expected"))));
}

// A file by hand, whose root has a pre-rotation and whose thigh turns by 30
// degrees in a second.
std::string TwoBones() {
  const auto path = FindWorkspaceFile("sim/import/formats/seeds/two_bones.fbx");
  EXPECT_THAT(path, IsOk());
  return ReadFile(*path).value_or("");
}

TEST(Fbx, PreRotationsAreInTheWorld) {
  const auto clip = ParseFbx(TwoBones(), "c", "c.fbx", {});

  ASSERT_THAT(clip, IsOk());
  CheckClip(*clip);
  EXPECT_THAT(Names(*clip), ElementsAre("Hips", "LeftUpLeg"));
  EXPECT_EQ(clip->poses.size(), 31u);
  // The root turns 10 degrees about y in the rest pose already.
  EXPECT_LT(
      motion::AngleBetween(clip->poses[0].rotation[0], Quaterniond::Identity()),
      1e-5);
  const Vector3d offset = clip->skeleton.joints[1].offset;
  EXPECT_NEAR(offset.y(), 0.09 * std::cos(M_PI / 18), 1e-6);
  EXPECT_NEAR(offset.z(), -0.06, 1e-6);
  EXPECT_NEAR(motion::AngleBetween(clip->poses[30].rotation[1],
                                   clip->poses[0].rotation[1]),
              M_PI / 6, 1e-5);
}

TEST(Fbx, RefusesLongClips) {
  const std::string text =
      absl::StrReplaceAll(TwoBones(), {{"0,46186158000", "0,923723160000000"}});
  EXPECT_THAT(ParseFbx(text, "c", "dir/c.fbx", {}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("dir/c.fbx: expected at most 14400 seconds, "
                                 "found 20000")));
}

// Text or binary.
class FbxBytes : public ::testing::TestWithParam<bool> {
 protected:
  static std::string Bytes() {
    const std::string text = MakeFbx({.frames = 3}).bytes;
    return GetParam() ? BinaryFbx(text) : text;
  }
};

TEST_P(FbxBytes, TruncatedFilesAreErrorsOrClips) {
  const std::string bytes = Bytes();
  for (int i = 0; i < 20; ++i) {
    const auto clip =
        ParseFbx(bytes.substr(0, bytes.size() * i / 20), "c", "dir/c.fbx", {});
    if (clip.ok()) CheckClip(*clip);
    if (!clip.ok()) {
      EXPECT_THAT(std::string(clip.status().message()), HasSubstr("dir/c.fbx"));
    }
  }
}

TEST_P(FbxBytes, DamagedFilesAreErrorsOrClipsWhateverTheLibraryDoes) {
  constexpr int kFiles = 80;
  std::mt19937 random(7);
  int clips = 0, refused = 0, crashed = 0;
  const std::string bytes = Bytes();
  for (int i = 0; i < kFiles; ++i) {
    std::string damaged = bytes;
    for (int k = 0; k < 1 << (i % 8); ++k) {
      damaged[64 + random() % (damaged.size() - 64)] =
          static_cast<char>(random());
    }
    const auto clip = ParseFbx(damaged, "c", "dir/c.fbx", {});
    if (clip.ok()) {
      CheckClip(*clip);
      ++clips;
      continue;
    }
    EXPECT_THAT(std::string(clip.status().message()), HasSubstr("dir/c.fbx"));
    ++(absl::StrContains(clip.status().message(), "library fails") ? crashed
                                                                   : refused);
  }
  EXPECT_GT(refused + crashed, 0);
  RecordProperty("clips", clips);
  RecordProperty("refused", refused);
  RecordProperty("crashed", crashed);
}

INSTANTIATE_TEST_SUITE_P(Forms, FbxBytes, ::testing::Bool(),
                         [](const auto& info) {
                           return info.param ? "binary" : "text";
                         });

}  // namespace
}  // namespace sinew::import
