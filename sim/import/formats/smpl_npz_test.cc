#include "sim/import/formats/smpl_npz.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/smpl_skeleton.h"
#include "sim/import/formats/testing/bad_file.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/npz_writer.h"
#include "sim/import/formats/testing/recordings.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using testing::CheckClip;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::MakeNpy;
using testing::MakeNpyText;
using testing::MakeNpz;
using testing::NpzMember;

constexpr char kShape3[] = "(3, 3)";

// Three frames of a body that stands at (0, 0, 1), one m further along +x each
// frame, in AMASS's world: a quarter turn about x brings the model's y up.
std::vector<double> StandingPoses(int columns) {
  std::vector<double> poses(3 * columns, 0);
  for (int frame = 0; frame < 3; ++frame) poses[frame * columns] = M_PI / 2;
  return poses;
}

std::vector<double> Trans() { return {0, 0, 1, 1, 0, 1, 2, 0, 1}; }

std::vector<NpzMember> Members(int columns = 72) {
  return {{"poses", MakeNpy("<f4", absl::StrCat("(3, ", columns, ")"),
                            StandingPoses(columns))},
          {"trans", MakeNpy("<f8", kShape3, Trans())},
          {"mocap_framerate", MakeNpy("<i8", "()", {50})},
          {"gender", MakeNpyText("neutral")},
          {"betas", MakeNpy("<f8", "(16,)", std::vector<double>(16, 0.5))}};
}

std::vector<NpzMember> With(const NpzMember& member) {
  std::vector<NpzMember> members = Members();
  for (NpzMember& old : members) {
    if (old.name == member.name) old = member;
  }
  return members;
}

std::vector<NpzMember> Without(const std::string& name) {
  std::vector<NpzMember> members = Members();
  std::erase_if(members, [&](const NpzMember& m) { return m.name == name; });
  return members;
}

absl::StatusOr<SourceClip> Parse(const std::vector<NpzMember>& members,
                                 const ReadOptions& options = {}) {
  return ParseSmplNpz(MakeNpz(members), "walk", "dir/walk.npz", options);
}

std::vector<Vector3d> Positions(const SourceClip& clip, int frame) {
  return WorldPositions(clip.skeleton, clip.poses[frame]);
}

TEST(SmplNpz, ReadsABodyThatStandsInAWorldWithZUp) {
  const auto clip = Parse(Members());

  ASSERT_THAT(clip, IsOk());
  CheckClip(*clip);
  EXPECT_EQ(clip->name, "walk");
  EXPECT_DOUBLE_EQ(clip->duration(), 0.04);
  EXPECT_EQ(clip->facts.format(), "smpl_npz");
  EXPECT_EQ(clip->facts.up_axis(), "z");
  EXPECT_DOUBLE_EQ(clip->facts.frames_per_second(), 50);
  EXPECT_THAT(clip->facts.concluded(), IsEmpty());
  EXPECT_THAT(clip->warnings, IsEmpty());
  const std::vector<Vector3d> joints = Positions(*clip, 1);
  // The model looks along its z axis, which the quarter turn makes -y.
  const Vector3d up = (joints[clip->skeleton.Find("head")] -
                       joints[clip->skeleton.Find("spine1")])
                          .normalized();
  EXPECT_GT(up.z(), 0.99);
  const Vector3d left = joints[clip->skeleton.Find("left_hip")] -
                        joints[clip->skeleton.Find("right_hip")];
  EXPECT_GT(left.x(), 0.13);
  const Vector3d foot = joints[clip->skeleton.Find("left_foot")] -
                        joints[clip->skeleton.Find("left_ankle")];
  EXPECT_LT(foot.y(), -0.1) << "toes point forward";
  // trans moves the model's origin; the pelvis of the mean body is beside it.
  EXPECT_TRUE(joints[0].isApprox(Vector3d(1, 0, 1) + SmplPelvis(), 1e-9));
}

TEST(SmplNpz, RestPoseIsATThatLooksAlongX) {
  const SourceSkeleton& skeleton = SmplSkeleton();
  const std::vector<Eigen::Quaterniond> rest(skeleton.joints.size(),
                                             Eigen::Quaterniond::Identity());
  const auto joints = WorldPositions(skeleton, Vector3d::Zero(), rest);

  const Vector3d hand = joints[skeleton.Find("left_hand")];
  EXPECT_NEAR(hand.y(), 0.767, 0.001);
  EXPECT_NEAR(hand.z(), 0.437, 0.001);
  EXPECT_GT(joints[skeleton.Find("left_foot")].x(), 0.06);
  // Pelvis to ankle, of the mean body: 0.864 m.
  EXPECT_NEAR(joints[skeleton.Find("left_ankle")].z(), -0.8646, 0.0005);
}

TEST(SmplNpz, TurnsJointsAboutTheModelsAxes) {
  std::vector<double> poses = StandingPoses(72);
  poses[3 * 4] = M_PI / 2;  // left knee, about the model's x axis: flexion
  const auto clip = Parse(With({"poses", MakeNpy("<f8", "(3, 72)", poses)}));

  ASSERT_THAT(clip, IsOk());
  const auto joints = Positions(*clip, 0);
  const Vector3d shank = joints[clip->skeleton.Find("left_ankle")] -
                         joints[clip->skeleton.Find("left_knee")];
  EXPECT_GT(shank.y(), 0.39) << "the shank points backwards, +y";
  EXPECT_LT(std::abs(shank.z()), 0.05);
}

TEST(SmplNpz, EveryBodyModelGivesTheSameBody) {
  const auto smpl = Parse(Members(72));
  ASSERT_THAT(smpl, IsOk());
  for (const int columns : {66, 156, 165}) {
    const auto other = Parse(Members(columns));
    ASSERT_THAT(other, IsOk()) << columns;
    EXPECT_EQ(Positions(*other, 2), Positions(*smpl, 2)) << columns;
  }
}

TEST(SmplNpz, ReadsTheDialectOfAmassX) {
  std::vector<double> root(9, 0);
  for (int frame = 0; frame < 3; ++frame) root[3 * frame] = M_PI / 2;
  const auto clip =
      Parse({{"root_orient", MakeNpy("<f4", kShape3, root)},
             {"pose_body", MakeNpy("<f8", "(3, 63)", std::vector<double>(189))},
             {"trans", MakeNpy("<f8", kShape3, Trans())},
             {"mocap_frame_rate", MakeNpy("<f8", "()", {50})},
             {"latent_labels", MakeNpy("|O", false, "(41,)", "a pickle")}});

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(Positions(*clip, 1), Positions(*Parse(Members()), 1));
}

TEST(SmplNpz, ReadsRowsThatAreSplitIntoJoints) {
  std::vector<NpzMember> members = Without("poses");
  members.push_back(
      {"pose_aa", MakeNpy("<f4", "(3, 24, 3)", StandingPoses(72))});

  EXPECT_THAT(Parse(members), IsOk());
}

TEST(SmplNpz, ReadsFortranOrder) {
  // Frame by frame: (0, 0, 1), (1, 0, 1), (2, 0, 1).
  std::string data;
  const std::string c_order =
      MakeNpy("<f8", kShape3, {0, 1, 2, 0, 0, 0, 1, 1, 1});
  data = c_order.substr(c_order.size() - 72);
  const auto clip = Parse(With({"trans", MakeNpy("<f8", true, kShape3, data)}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(Positions(*clip, 2), Positions(*Parse(Members()), 2));
}

TEST(SmplNpz, DeflatedFilesGiveTheSameClip) {
  const auto clip = ParseSmplNpz(MakeNpz(Members(), /*deflated=*/true), "walk",
                                 "walk.npz", {});

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(Positions(*clip, 2), Positions(*Parse(Members()), 2));
}

TEST(SmplNpz, ConcludesYUpFromABodyThatStandsAlongY) {
  const auto clip = Parse(
      With({"poses", MakeNpy("<f4", "(3, 72)", std::vector<double>(216, 0))}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_EQ(clip->facts.up_axis(), "y");
  EXPECT_THAT(clip->facts.concluded(), ElementsAre("up_axis"));
  EXPECT_NEAR((clip->poses[0].rotation[0] * Vector3d::UnitZ()).z(), 1, 1e-9);
}

TEST(SmplNpz, OptionsGoBeforeTheFile) {
  const auto clip =
      Parse(Members(),
            {.metres_per_unit = 0.01, .up_axis = 'x', .frames_per_second = 10});

  ASSERT_THAT(clip, IsOk());
  EXPECT_DOUBLE_EQ(clip->duration(), 0.2);
  // One unit along x, which is up.
  EXPECT_NEAR(
      clip->poses[1].root_position.z() - clip->poses[0].root_position.z(), 0.01,
      1e-9);
  EXPECT_THAT(Parse(Members(), {.frames_per_second = NAN}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("frames per second: expected a number from "
                                 "0.001 to 10000, found nan")));
}

TEST(SmplNpz, WarnsOfABodyFarFromTheMean) {
  const auto clip = Parse(With({"betas", MakeNpy("<f4", "(2,)", {-4.5, 1})}));

  ASSERT_THAT(clip, IsOk());
  EXPECT_THAT(clip->warnings,
              ElementsAre(HasSubstr("neutral, shape coefficients up to 4.5")));
}

struct BadFile {
  std::vector<NpzMember> members;
  std::string expected;
};

class SmplNpzError : public ::testing::TestWithParam<BadFile> {};

TEST_P(SmplNpzError, NamesFileMemberExpectedAndFound) {
  EXPECT_THAT(Parse(GetParam().members),
              testing::IsRefused("dir/walk.npz: ", GetParam().expected));
}

std::vector<double> PosesWith(int at, double value) {
  std::vector<double> poses = StandingPoses(72);
  poses[at] = value;
  return poses;
}

INSTANTIATE_TEST_SUITE_P(
    Members, SmplNpzError,
    ::testing::Values(
        BadFile{{{"fps", MakeNpy("<i4", "(1,)", {30})}, {"joint_pos", "?"}},
                "poses: expected a member of this name, pose_aa, or "
                "root_orient and pose_body, found fps, joint_pos"},
        BadFile{Without("poses"), "poses: expected a member of this name"},
        BadFile{Without("trans"), "expected a member trans, found betas, "},
        BadFile{Without("mocap_framerate"),
                "mocap_framerate: expected the number of frames per second"},
        BadFile{With({"mocap_framerate", MakeNpy("<f8", "()", {0})}),
                "mocap_framerate: expected more than 0"},
        BadFile{With({"mocap_framerate", MakeNpy("<f8", "(2,)", {30, 30})}),
                "expected one number, found float64 (2)"},
        BadFile{With({"mocap_framerate", MakeNpyText("fast")}),
                "expected one number, found text ()"}));

INSTANTIATE_TEST_SUITE_P(
    Arrays, SmplNpzError,
    ::testing::Values(
        BadFile{With({"poses", MakeNpy("|O", false, "(3, 72)", "pickle")}),
                "poses: expected an array of real numbers or text, found "
                "pickled Python objects"},
        BadFile{With({"poses", MakeNpyText("no poses")}),
                "poses: expected numbers (frames, 66 or 72 or 156 or 165), "
                "found text ()"},
        BadFile{With({"poses",
                      MakeNpy("<f4", "(3, 69)", std::vector<double>(207))}),
                "found float32 (3, 69)"},
        BadFile{
            With({"poses", MakeNpy("<f4", "(1, 72)", std::vector<double>(72))}),
            "poses: expected at least 2 frames"},
        BadFile{With({"poses", MakeNpy("<f4", "(0, 72)", {})}),
                "poses: expected at least 2 frames"},
        BadFile{With({"poses",
                      MakeNpy("<f4", "(2, 72)", std::vector<double>(144))}),
                "poses: expected 3 frames as in dir/walk.npz: trans, found 2"},
        BadFile{With({"poses", MakeNpy("<f8", "(3, 72)", PosesWith(77, NAN))}),
                "poses: frame 1, column 5: expected a number within +-1000, "
                "found nan"},
        BadFile{With({"trans", MakeNpy("<f8", kShape3,
                                       {0, 0, 0, 0, 1e300, 0, 0, 0, 0})}),
                "trans: frame 1, column 1: expected a number within"},
        BadFile{With({"trans", MakeNpy("<f8", "(3, 3)", {1, 2, 3})}),
                "trans: expected"}));

TEST(SmplNpz, RefusesAClipOfMoreThanFourHoursBeforeReadingIt) {
  EXPECT_THAT(
      Parse(With({"mocap_framerate", MakeNpy("<f8", "()", {1e-4})})),
      StatusIs(
          absl::StatusCode::kResourceExhausted,
          HasSubstr("poses: expected at most 14400 seconds, found 20000")));
}

TEST(SmplNpz, RefusesAMemberTwice) {
  std::string bytes = MakeNpz({{"poses", "a"}, {"pos3s", "b"}});
  for (size_t at; (at = bytes.find("pos3s")) != std::string::npos;) {
    bytes.replace(at, 5, "poses");
  }
  EXPECT_THAT(ParseSmplNpz(bytes, "c", "c.npz", {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected each member once, found \"poses\" "
                                 "twice")));
}

TEST(SmplNpz, RefusesWhatIsNoZip) {
  EXPECT_THAT(ParseSmplNpz("HIERARCHY", "c", "c.npz", {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("c.npz: expected an npz (zip) file, found: "
                                 "Not a zip archive")));
}

// Changes what the directory and the member's header say of a size.
std::string WithSize(std::string bytes, uint32_t old_size, uint32_t new_size) {
  const std::string from(reinterpret_cast<const char*>(&old_size), 4);
  const std::string to(reinterpret_cast<const char*>(&new_size), 4);
  for (size_t at = 0; (at = bytes.find(from, at)) != std::string::npos;) {
    bytes.replace(at, 4, to);
  }
  return bytes;
}

TEST(SmplNpz, RefusesSizesThatDeflateCannotReach) {
  const std::string poses = MakeNpy("<f4", "(3, 72)", StandingPoses(72));
  const std::string bytes =
      WithSize(MakeNpz(Members(), /*deflated=*/true),
               static_cast<uint32_t>(poses.size()), 1 << 29);

  EXPECT_THAT(ParseSmplNpz(bytes, "c", "c.npz", {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("c.npz: poses: expected a size that"),
                             HasSubstr("found 536870912"))));
}

TEST(SmplNpz, FindsDamageByTheChecksum) {
  std::string bytes = MakeNpz(Members());
  const std::string trans = MakeNpy("<f8", kShape3, Trans());
  bytes[bytes.find(trans) + trans.size() - 1] ^= 1;

  EXPECT_THAT(ParseSmplNpz(bytes, "c", "c.npz", {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("c.npz: trans: cannot be read: CRC error")));
}

TEST(SmplNpz, AnyTruncationIsAnErrorAndNotACrash) {
  for (const bool deflated : {false, true}) {
    const std::string bytes = MakeNpz(Members(), deflated);
    for (size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(ParseSmplNpz(bytes.substr(0, size), "c", "c.npz", {}).ok());
    }
  }
}

// Real files: estimated from videos, so that feet may be off the floor by some
// centimetres, and more in flight.
TEST(SmplNpz, RealBodiesStandUprightOnTheFloor) {
  const auto recordings = testing::Recordings("motions/asap/smpl_npz", ".npz");
  if (recordings.empty()) GTEST_SKIP() << "SINEW_DATA is not set";
  double worst = 0;
  for (const auto& [name, bytes] : recordings) {
    const auto clip = ParseSmplNpz(bytes, name, name, {});
    ASSERT_THAT(clip, IsOk());
    CheckClip(*clip);
    EXPECT_EQ(clip->facts.up_axis(), "z") << name;
    EXPECT_EQ(clip->facts.frames_per_second(), 30) << name;
    std::vector<double> lowest;
    double upright = 0;
    for (size_t frame = 0; frame < clip->poses.size(); ++frame) {
      const auto joints = Positions(*clip, static_cast<int>(frame));
      double low = joints[0].z();
      for (const Vector3d& joint : joints) low = std::min(low, joint.z());
      lowest.push_back(low);
      upright +=
          (joints[clip->skeleton.Find("neck")] - joints[0]).normalized().z();
    }
    std::nth_element(lowest.begin(), lowest.begin() + lowest.size() / 2,
                     lowest.end());
    const double median = lowest[lowest.size() / 2];
    EXPECT_GT(median, -0.05) << name;
    EXPECT_LT(median, 0.15) << name;
    worst = std::max(worst, std::abs(median));
    EXPECT_GT(upright / static_cast<double>(clip->poses.size()), 0.7) << name;
  }
  EXPECT_GE(recordings.size(), 40u);
  RecordProperty("worst_median_height_m", absl::StrCat(worst));
}

}  // namespace
}  // namespace sinew::import
