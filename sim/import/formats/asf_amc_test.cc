#include "sim/import/formats/asf_amc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/import/formats/testing/bad_file.h"
#include "sim/import/formats/testing/check_clip.h"
#include "sim/import/formats/testing/made_files.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
using Changes = std::vector<std::pair<const absl::string_view, std::string>>;

// A thigh down, a foot ahead of it, a head up; y up, lengths in metres.
constexpr char kAsf[] = R"(# small
:version 1.10
:units
  mass 1.0
  length 0.0254
  angle deg
:documentation
  begin here
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name thigh
    direction 0 -1 0
    length 0.9
    axis 10 20 30 XYZ
    dof rx rz
    limits (-160.0 20.0)
           (-70.0 70.0)
  end
  begin
    name foot
    direction 0 0 1
    length 0.2
    axis 0 0 0 XYZ
    dof rx ry rz
  end
  begin
    name head
    direction 0 1 0
    length 0.6
    axis 0 0 0
  end
:hierarchy
  begin
    root thigh head
    thigh foot
  end
)";

constexpr char kAmc[] = R"(# small
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 0 0 0
thigh 0 0
foot 0 0 0
2
root 1 2 3 10 20 30
thigh 40 50
foot 10 20 30
)";

AsfSkeleton Skeleton(const Changes& changes = {}) {
  auto skeleton = ParseAsf(absl::StrReplaceAll(kAsf, changes), "a.asf");
  EXPECT_THAT(skeleton, IsOk());
  return skeleton.ok() ? *std::move(skeleton) : AsfSkeleton();
}

absl::StatusOr<SourceClip> Parse(const Changes& changes,
                                 const AsfSkeleton& skeleton = Skeleton(),
                                 const ReadOptions& options = {}) {
  absl::StatusOr<SourceClip> clip =
      ParseAmc(absl::StrReplaceAll(kAmc, changes), skeleton, "clip",
               "dir/clip.amc", options);
  if (clip.ok()) testing::CheckClip(*clip);
  return clip;
}

TEST(Asf, PutsEachJointAtTheEndOfItsParentBone) {
  const auto clip = Parse({});

  ASSERT_THAT(clip, IsOk());
  std::vector<std::string> names;
  for (const SourceJoint& joint : clip->skeleton.joints) {
    names.push_back(joint.name);
  }
  EXPECT_THAT(names, ElementsAre("root", "thigh", "foot", "foot_end", "head",
                                 "head_end"));
  const std::vector<Vector3d> at =
      WorldPositions(clip->skeleton, clip->poses[0]);
  // The file's (1, 2, 3) is the world's (3, 1, 2); z is up, x is ahead.
  EXPECT_TRUE(at[0].isApprox(Vector3d(3, 1, 2))) << "root";
  EXPECT_TRUE(at[1].isApprox(Vector3d(3, 1, 2))) << "thigh";
  EXPECT_TRUE(at[2].isApprox(Vector3d(3, 1, 1.1))) << "foot";
  EXPECT_TRUE(at[3].isApprox(Vector3d(3.2, 1, 1.1))) << "foot_end";
  EXPECT_TRUE(at[5].isApprox(Vector3d(3, 1, 2.6))) << "head_end";
  EXPECT_TRUE(clip->skeleton.joints[5].is_end);
}

TEST(Amc, TurnsBonesInTheirOwnAxes) {
  const auto clip = Parse({});

  ASSERT_THAT(clip, IsOk());
  // The file's x, y, z axes are the world's y, z, x; angles about x go first.
  const Vector3d x = Vector3d::UnitY();
  const Vector3d y = Vector3d::UnitZ();
  const Vector3d z = Vector3d::UnitX();
  const Quaterniond axis = AngleAxisd(30 * kDegree, z) *
                           AngleAxisd(20 * kDegree, y) *
                           AngleAxisd(10 * kDegree, x);
  const Quaterniond turn =
      AngleAxisd(50 * kDegree, z) * AngleAxisd(40 * kDegree, x);
  const std::vector<Quaterniond>& rotation = clip->poses[1].rotation;
  EXPECT_TRUE(rotation[1].isApprox(axis * turn * axis.inverse(), 1e-12));
  EXPECT_TRUE(rotation[0].isApprox(axis, 1e-12)) << "the root turns likewise";
  EXPECT_TRUE(rotation[2].isApprox(axis, 1e-12)) << "and the foot";
  EXPECT_TRUE(rotation[4].isApprox(Quaterniond::Identity())) << "no dof";
}

TEST(Amc, TakesTheOrderOfAxesAndOfDegreesOfFreedomFromTheSkeleton) {
  const AsfSkeleton skeleton = Skeleton(
      {{"axis 10 20 30 XYZ", "axis 10 20 30 ZYX"}, {"dof rx rz", "dof rz rx"}});
  const auto clip = Parse({}, skeleton);

  ASSERT_THAT(clip, IsOk());
  const Vector3d x = Vector3d::UnitY();
  const Vector3d y = Vector3d::UnitZ();
  const Vector3d z = Vector3d::UnitX();
  const Quaterniond axis = AngleAxisd(30 * kDegree, x) *
                           AngleAxisd(20 * kDegree, y) *
                           AngleAxisd(10 * kDegree, z);
  const Quaterniond turn =
      AngleAxisd(50 * kDegree, x) * AngleAxisd(40 * kDegree, z);
  EXPECT_TRUE(
      clip->poses[1].rotation[1].isApprox(axis * turn * axis.inverse(), 1e-12));
}

TEST(Amc, ReadsRootOrderAndPosition) {
  const AsfSkeleton skeleton =
      Skeleton({{"order TX TY TZ RX RY RZ", "order RZ RX RY TZ TX TY"},
                {"position 0 0 0", "position 10 20 30"}});
  const auto clip =
      Parse({{"root 1 2 3 10 20 30", "root 0 0 0 3 1 2"}}, skeleton);

  ASSERT_THAT(clip, IsOk());
  EXPECT_TRUE(clip->poses[1].root_position.isApprox(Vector3d(33, 11, 22)));
}

TEST(Amc, ReadsRadians) {
  const auto degrees = Parse({});
  const auto by_amc = Parse(
      {{":DEGREES", ":RADIANS"}, {"thigh 40 50", "thigh 0.698132 0.872665"}});
  const auto by_asf =
      Parse({{":DEGREES", ""}, {"thigh 40 50", "thigh 0.698132 0.872665"}},
            Skeleton({{"angle deg", "angle rad"},
                      {"axis 10 20 30", "axis 0.174533 0.349066 0.523599"}}));

  ASSERT_THAT(degrees, IsOk());
  ASSERT_THAT(by_amc, IsOk());
  ASSERT_THAT(by_asf, IsOk());
  const Quaterniond& expected = degrees->poses[1].rotation[1];
  EXPECT_LT(by_amc->poses[1].rotation[1].angularDistance(expected), 1e-5);
  EXPECT_LT(by_asf->poses[1].rotation[1].angularDistance(expected), 1e-5);
}

TEST(Amc, HasTheRateOfTheUserOfTheFileOrOfCmu) {
  ReadOptions options;
  options.frames_per_second = 50;
  const auto by_user = Parse({}, Skeleton(), options);
  const auto by_file = Parse({{":DEGREES", ":SAMPLES-PER-SECOND 60"}});
  const auto by_cmu = Parse({});

  ASSERT_THAT(by_user, IsOk());
  ASSERT_THAT(by_file, IsOk());
  ASSERT_THAT(by_cmu, IsOk());
  EXPECT_EQ(by_user->facts.frames_per_second(), 50);
  EXPECT_EQ(by_file->facts.frames_per_second(), 60);
  EXPECT_EQ(by_cmu->facts.frames_per_second(), 120);
  EXPECT_THAT(by_file->facts.concluded(),
              ElementsAre("metres_per_unit", "up_axis"));
  EXPECT_THAT(by_cmu->facts.concluded(),
              ElementsAre("metres_per_unit", "up_axis", "frames_per_second"));
}

TEST(Amc, HasCmusUnitOfLengthOrOneThatMakesAPerson) {
  const auto asf = ParseAsf(testing::MadeAsf(), "made.asf");
  ASSERT_THAT(asf, IsOk());
  const auto cmu = ParseAmc(testing::MadeAmc(2), *asf, "clip", "made.amc", {});
  // An inch a unit would make a person of 4 cm.
  const auto metres = Parse({}, Skeleton({{"length 0.0254", "length 1"}}));

  ASSERT_THAT(cmu, IsOk());
  ASSERT_THAT(metres, IsOk());
  EXPECT_DOUBLE_EQ(cmu->facts.metres_per_unit(), 0.0254 / 0.45);
  EXPECT_THAT(cmu->warnings, IsEmpty());
  EXPECT_EQ(metres->facts.metres_per_unit(), 1);
}

TEST(Amc, HoldsASingleFrame) {
  const absl::string_view all(kAmc);
  const auto clip = ParseAmc(all.substr(0, all.find("\n2\n")), Skeleton(),
                             "clip", "clip.amc", {});

  ASSERT_THAT(clip, IsOk());
  EXPECT_THAT(clip->poses, SizeIs(2));
  EXPECT_THAT(clip->warnings, ElementsAre(HasSubstr("single pose")));
}

struct BadFile {
  Changes changes;
  std::string expected;
};

class AsfError : public ::testing::TestWithParam<BadFile> {};

TEST_P(AsfError, NamesFileLineExpectedAndFound) {
  EXPECT_THAT(
      ParseAsf(absl::StrReplaceAll(kAsf, GetParam().changes), "dir/a.asf"),
      testing::IsRefused("dir/a.asf: line ", GetParam().expected));
}

INSTANTIATE_TEST_SUITE_P(
    Bones, AsfError,
    ::testing::Values(
        BadFile{{{":version", "version"}},
                "line 2: expected a section of an ASF file, found \"version\""},
        BadFile{{{"length 0.0254", "length 0"}}, "expected a length > 0"},
        BadFile{{{"angle deg", "angle turns"}},
                "expected an angle in deg or rad, found \"turns\""},
        BadFile{{{"axis XYZ", "axis XXZ"}},
                "line 11: expected an order of axes like XYZ, found \"XXZ\""},
        BadFile{{{"order TX TY", "order TX TX"}},
                "line 10: expected each of TX TY TZ RX RY RZ at most once, "
                "found \"TX\""},
        BadFile{{{"dof rx rz", "dof rx l"}},
                "line 21: expected each of rx ry rz at most once, found \"l\""},
        BadFile{{{"dof rx rz", "dof rx tz"}}, "found \"tz\""},
        BadFile{{{"direction 0 -1 0", "direction 0 -1"}},
                "line 18: expected a number, found \"\""},
        BadFile{{{"length 0.9", "length nan"}},
                "line 19: expected a finite number"},
        BadFile{{{"length 0.9", "length -1"}}, "expected a length >= 0, found"},
        BadFile{{{"length 0.9", ""}},
                "line 24: expected a length of bone \"thigh\", found none"},
        BadFile{{{"name thigh", ""}}, "expected a bone with a name"},
        BadFile{{{"  end\n  begin\n    name foot", "  begin\n    name foot"}},
                "line 25: expected one name a bone, found \" foot\""}));

INSTANTIATE_TEST_SUITE_P(
    Hierarchy, AsfError,
    ::testing::Values(
        BadFile{{{":hierarchy\n", ""}}, "line 41: expected a bone with a name"},
        BadFile{{{"root thigh head", "root thigh tail"}},
                "line 40: expected a bone of :bonedata, found \"tail\""},
        BadFile{{{"root thigh head", "root thigh"}},
                "leads from the root to every bone, found \"head apart\""},
        BadFile{
            {{"root thigh head", "root head"}, {"thigh foot", "foot thigh"}},
            "found \"thigh apart\""},
        BadFile{{{"thigh foot", "thigh foot thigh"}},
                "line 41: expected one parent for each bone and none for the "
                "root, found another for \"thigh\""},
        BadFile{{{"thigh foot", "thigh foot root"}}, "another for \"root\""},
        BadFile{{{"name head", "name foot"}},
                "expected bones of different names, root aside, found \"foot "
                "twice\""},
        BadFile{{{"name head", "name root"}}, "found \"root twice\""}));

TEST(Asf, RefusesWhatIsNone) {
  EXPECT_THAT(ParseAsf("", "a.asf"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a section :bonedata, found none")));
  EXPECT_THAT(ParseAsf("\x7f"
                       "ELF",
                       "a.asf"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected a section of an ASF file")));
  EXPECT_THAT(ParseAsf(":bonedata\nbegin\n name a\n length 1", "a.asf"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected \"end\" of the last bone")));
}

class AmcError : public ::testing::TestWithParam<BadFile> {};

TEST_P(AmcError, NamesFileLineFrameExpectedAndFound) {
  EXPECT_THAT(Parse(GetParam().changes),
              testing::IsRefused("dir/clip.amc: line ", GetParam().expected));
}

INSTANTIATE_TEST_SUITE_P(
    Files, AmcError,
    ::testing::Values(
        BadFile{{{kAmc, ""}}, "line 0: expected at least one frame, found"},
        BadFile{{{kAmc, "walk 1\n"}},
                "line 1: expected the number of a frame, found \"walk\""},
        BadFile{{{"\n2\n", "\n3\n"}},
                "line 8: frame 1: expected the next frame after it, found 3"},
        BadFile{{{"thigh 40 50\nfoot 10 20 30\n", ""}},
                "line 9: frame 2: expected numbers of bone \"thigh\", found "
                "the end of the frame"},
        BadFile{{{"foot 0 0 0\n", ""}},
                "line 7: frame 1: expected numbers of bone \"foot\""},
        BadFile{{{"foot 10", "tail 10"}},
                "line 11: frame 2: expected a bone of the skeleton, found "
                "\"tail\""},
        BadFile{{{"foot 10", "thigh 10"}},
                "expected each bone once, found \"thigh\" twice"},
        BadFile{{{"thigh 40 50", "thigh 40"}},
                "line 10: frame 2: bone \"thigh\": expected 2 numbers: "
                "expected a number, found \"\""},
        BadFile{{{"thigh 40 50", "thigh 40 50 60"}},
                "expected 2 numbers, found more"},
        BadFile{{{"thigh 40 50", "thigh 40 1e99"}},
                "expected a finite number of at most 1e+09 in size"},
        BadFile{{{":DEGREES", ":SAMPLES-PER-SECOND 0"}},
                "line 3: expected 0.001 to 10000 samples per second, found"}));

TEST(Amc, BoundsMemoryByTheSizeOfTheFile) {
  std::string asf = ":bonedata\n";
  std::string links = ":hierarchy\nroot";
  for (int i = 0; i < 1000; ++i) {
    absl::StrAppend(&asf, "begin\nname b", i, "\nlength 1\nend\n");
    absl::StrAppend(&links, " b", i);
  }
  const auto skeleton = ParseAsf(absl::StrCat(asf, links), "a.asf");
  ASSERT_THAT(skeleton, IsOk());
  std::string amc;
  for (int i = 0; i < 20000; ++i) absl::StrAppend(&amc, i, "\n");

  EXPECT_THAT(ParseAmc(amc, *skeleton, "clip", "a.amc", {}),
              StatusIs(absl::StatusCode::kResourceExhausted,
                       HasSubstr("joints times frames in a file of its size")));
}

// A folder of empty files.
std::string Folder(const std::string& name,
                   const std::vector<std::string>& files) {
  const std::string folder = JoinPath(std::getenv("TEST_TMPDIR"), name);
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  for (const std::string& file : files) {
    EXPECT_THAT(WriteFileAtomically(JoinPath(folder, file), ""), IsOk());
  }
  return folder;
}

TEST(AsfCandidates, AreFilesNamedLikeTheClipLikeliestFirst) {
  const std::string folder = Folder(
      "several é", {"02.asf", "02_01.ASF", "0.asf", "charleston.asf", "x.txt"});

  EXPECT_THAT(AsfCandidates(folder + "/02_01.amc"),
              ElementsAre(folder + "/02_01.ASF", folder + "/02.asf"));
  EXPECT_THAT(AsfCandidates(folder + "/charleston1.amc"),
              ElementsAre(folder + "/charleston.asf"));
  EXPECT_THAT(AsfCandidates(folder + "/05_01.amc"), IsEmpty());
}

TEST(AsfCandidates, IncludeTheSingleSkeletonOfTheFolder) {
  const std::string folder = Folder("single", {"dancer.asf", "waltz.amc"});

  EXPECT_THAT(AsfCandidates(folder + "/waltz.amc"),
              ElementsAre(folder + "/dancer.asf"));
}

TEST(AsfCandidates, AreNoneWithoutAFolder) {
  EXPECT_THAT(AsfCandidates("/no/such/folder/a_1.amc"), IsEmpty());
}

}  // namespace
}  // namespace sinew::import
