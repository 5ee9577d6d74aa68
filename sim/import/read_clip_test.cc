#include "sim/import/read_clip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "sim/character/character.h"
#include "sim/import/retarget/import_model.h"
#include "sim/import/testing/made_clips.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr absl::StatusCode kInvalid = absl::StatusCode::kInvalidArgument;

// A hip that rises, in BVH.
constexpr char kBvh[] =
    "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 0\n"
    "  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n"
    "  JOINT Leg\n  {\n    OFFSET 0 -90 0\n"
    "    CHANNELS 3 Zrotation Yrotation Xrotation\n"
    "    End Site\n    {\n      OFFSET 0 -80 0\n    }\n  }\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.033333\n"
    "0 170 0 0 0 0 0 0 0\n0 171 0 0 0 0 0 0 0\n";

// To be read as a format.
ReadClipOptions As(const std::string& format) {
  ReadClipOptions options;
  options.format = format;
  return options;
}

class ReadClipTest : public ::testing::Test {
 protected:
  static absl::StatusOr<Source> Read(const std::string& path,
                                     const ReadClipOptions& options = {},
                                     const ImportModel* model = nullptr) {
    const auto bytes = ReadFile(path);
    EXPECT_THAT(bytes, IsOk());
    return ReadClip(path, *bytes, "clip", model, options);
  }
};

TEST_F(ReadClipTest, ReadsWhatTheContentSaysWhateverTheName) {
  const auto march = Read(WriteTestFile("march.bvh", testing::MarchJson()));
  ASSERT_THAT(march, IsOk());
  EXPECT_EQ(std::get<SourceClip>(*march).facts.format(), "deepmimic");

  const auto rise = Read(WriteTestFile("rise.txt", kBvh));
  ASSERT_THAT(rise, IsOk());
  EXPECT_EQ(std::get<SourceClip>(*rise).facts.format(), "bvh");
  EXPECT_EQ(std::get<SourceClip>(*rise).name, "clip");
}

TEST_F(ReadClipTest, ReadsAsToldWhateverTheContent) {
  EXPECT_THAT(Read(WriteTestFile("rise.bvh", kBvh), As("deepmimic")),
              StatusIs(kInvalid, HasSubstr("rise.bvh: expected JSON")));
  EXPECT_THAT(Read(WriteTestFile("rise.bvh", kBvh), As("bvhh")),
              StatusIs(kInvalid, HasSubstr("format: expected one of")));
}

TEST_F(ReadClipTest, HandsOverridesToTheReader) {
  ReadClipOptions options;
  options.read.metres_per_unit = 0.02;
  options.read.frames_per_second = 60;

  const auto rise = Read(WriteTestFile("rise.bvh", kBvh), options);

  ASSERT_THAT(rise, IsOk());
  const auto& clip = std::get<SourceClip>(*rise);
  EXPECT_NEAR(clip.duration(), 1.0 / 60, 1e-6);
  EXPECT_NEAR(clip.skeleton.joints[1].offset.norm(), 1.8, 1e-6);
  EXPECT_THAT(
      clip.facts.concluded(),
      ::testing::Not(::testing::Contains(std::string("metres_per_unit"))));
}

TEST_F(ReadClipTest, RefusesOverridesThatMakeNoSense) {
  ReadClipOptions options;
  options.read.up_axis = 'w';
  EXPECT_THAT(Read(WriteTestFile("rise.bvh", kBvh), options),
              StatusIs(kInvalid, HasSubstr("up axis")));
}

TEST_F(ReadClipTest, AnAmcNeedsItsSkeleton) {
  const std::string amc =
      WriteTestFile("13_30.amc", ":FULLY-SPECIFIED\n:DEGREES\n1\n");
  EXPECT_THAT(Read(amc), StatusIs(kInvalid, HasSubstr("(--asf), found none")));
  EXPECT_THAT(CompanionFiles(amc, ":FULLY-SPECIFIED\n", {}),
              StatusIs(kInvalid, HasSubstr("13_30.amc")));
  ReadClipOptions absent;
  absent.asf = TestPath("none.asf");
  EXPECT_THAT(Read(amc, absent),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("none.asf")));

  const std::string asf = WriteTestFile("13.asf", ":version 1.10\n");
  EXPECT_THAT(CompanionFiles(amc, ":FULLY-SPECIFIED\n", {}),
              IsOkAndHolds(ElementsAre(asf)));
  EXPECT_THAT(CompanionFiles(amc, kBvh, As("bvh")), IsOkAndHolds(IsEmpty()));
}

TEST_F(ReadClipTest, ARobotsRecordingNeedsTheRobot) {
  const std::string csv = WriteTestFile("walk.csv", "0,0,1,0,0,0,1,0.1\n");
  EXPECT_THAT(Read(csv),
              StatusIs(kInvalid, HasSubstr("takes the robot's model")));
}

TEST_F(ReadClipTest, SaysWhyTrainingArraysAreNoRecording) {
  EXPECT_THAT(Read(WriteTestFile("walk.npz", "PK\x03\x04 joint_pos.npy")),
              StatusIs(kInvalid, HasSubstr("joints have no names")));
}

TEST_F(ReadClipTest, FoldersAreWalkedForClips) {
  const std::string march =
      WriteTestFile("in/b/march.txt", testing::MarchJson());
  const std::string rise = WriteTestFile("in/a b/rise.BVH", kBvh);
  const std::string table =
      WriteTestFile("in/robot.csv", "x,y,z\n0.1,0.2,0.3\n");
  WriteTestFile("in/SOURCE.txt", "These clips were recorded by ...");
  WriteTestFile("in/labels.csv", "motion,subject,description\n02_01,2,walk\n");
  WriteTestFile("in/body.xml", "<mujoco><worldbody/></mujoco>");
  WriteTestFile("in/02.asf", ":version 1.10");
  WriteTestFile("in/picture.png", "\x89PNG");
  const std::string notes = WriteTestFile("notes.txt", "no clip");

  EXPECT_THAT(ExpandFolders({notes, TestPath("in"), TestPath("absent.bvh")}),
              IsOkAndHolds(ElementsAre(notes, rise, march, table,
                                       TestPath("absent.bvh"))));
}

// A model whose keyframes begin at byte `at`.
std::string Model(size_t at, absl::string_view keyframes) {
  std::string text = "<mujoco><!--";
  text.resize(at - 3, 'x');
  return absl::StrCat(text, "-->", keyframes, "</mujoco>");
}

TEST_F(ReadClipTest, FindsKeyframesFarBehindTheirModel) {
  const absl::string_view keys =
      "<keyframe><key qpos='0'/><key qpos='1'/></keyframe>";
  const std::string far = WriteTestFile("in/far.xml", Model(3 << 20, keys));
  // "<" is among the first 64 KiB or MiB that are looked at, "key" is not.
  const std::string head =
      WriteTestFile("in/head.xml", Model((64 << 10) - 1, keys));
  const std::string piece = WriteTestFile(
      "in/piece.xml", Model((64 << 10) - 3 + (1 << 20) - 1, keys));
  WriteTestFile("in/other.xml",
                absl::StrCat("<page>", std::string(100 << 10, ' '), keys));
  WriteTestFile("in/without.xml", Model(3 << 20, "<worldbody/>"));

  EXPECT_THAT(ExpandFolders({TestPath("in")}),
              IsOkAndHolds(ElementsAre(far, head, piece)));
}

TEST_F(ReadClipTest, AFolderWithoutClipsIsAnError) {
  WriteTestFile("in/readme.txt", "nothing here");
  EXPECT_THAT(ExpandFolders({TestPath("in")}),
              StatusIs(absl::StatusCode::kNotFound,
                       HasSubstr("expected motion clips in this folder")));
}

// Whatever lies in the collection of real files gives a clip or an error that
// names it.
TEST_F(ReadClipTest, EveryRealFileGivesAClipOrAnError) {
  const char* data = std::getenv("SINEW_DATA");
  if (data == nullptr) GTEST_SKIP() << "SINEW_DATA is not set";
  const auto g1 = character::Character::Load("g1", v1::Physics());
  ASSERT_THAT(g1, IsOk());
  const ImportModel model = MakeImportModel(**g1);
  int clips = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(
           JoinPath(data, "motions"))) {
    if (!entry.is_regular_file()) continue;
    const std::string path = entry.path().string();
    const bool broken = absl::StrContains(path, "/broken/");
    const auto source = Read(path, {}, &model);
    clips += source.ok();
    if (source.ok()) {
      EXPECT_FALSE(broken) << path;
    } else {
      EXPECT_THAT(std::string(source.status().message()),
                  HasSubstr(entry.path().filename().string()));
    }
  }
  EXPECT_GT(clips, 200);
}

}  // namespace
}  // namespace sinew::import
