#include "sim/import/importer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "nlohmann/json.hpp"
#include "sim/import/quality_gate.h"
#include "sim/import/testing/import_fixture.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"

namespace sinew::import {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using Json = nlohmann::json;

class ImporterTest : public testing::ImportFixture {};

TEST_F(ImporterTest, OneBadFileDoesNotStopTheOthers) {
  const std::string good = testing::MarchJson();
  const std::vector<std::string> files = {
      WriteTestFile("text.txt", "no clip at all"),
      WriteTestFile("good.txt", good),
      WriteTestFile("cut.txt", good.substr(0, good.size() / 2)),
      WriteTestFile("nan.txt",
                    absl::StrReplaceAll(good, {{"0.890000000", "NaN"}})),
      TestPath("absent.txt"),
      TestPath("good.txt"),
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
  EXPECT_THAT(reports_[4].status,
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("absent.txt")));
  EXPECT_THAT(reports_[5].status,
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr("expected a unique name")));
}

TEST_F(ImporterTest, WritesNothingWhereNoFileIsGood) {
  EXPECT_THAT(ImportFiles(*character_, {WriteTestFile("bad.txt", "{}")},
                          options_, TestPath("none"), &reports_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("expected at least one clip"),
                             HasSubstr("in 1 files: "), HasSubstr("bad.txt"))));
  EXPECT_FALSE(FileSize(JoinPath(TestPath("none"), "manifest.json")).ok());
}

TEST_F(ImporterTest, LeavesALibraryOfANewerVersionAsItIs) {
  const std::string file = WriteTestFile("good.txt", testing::MarchJson());
  Import({file}, "newer");
  const std::string manifest = JoinPath(TestPath("newer"), "manifest.json");
  const std::string newer =
      absl::StrReplaceAll(Bytes("newer", "manifest.json"),
                          {{"\"format_version\": 1", "\"format_version\": 2"}});
  ASSERT_THAT(WriteFileAtomically(manifest, newer), IsOk());

  EXPECT_THAT(
      ImportFiles(*character_, {file}, options_, TestPath("newer"), &reports_),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               HasSubstr("manifest.json: format_version: expected at most 1, "
                         "found 2 (written by a newer version)")));

  EXPECT_EQ(Bytes("newer", "manifest.json"), newer);
}

TEST_F(ImporterTest, LeavesALibraryAsItIsWhereNoFileIsGood) {
  const std::string file = WriteTestFile("good.txt", testing::MarchJson());
  Import({file}, "kept");
  const std::string report = Bytes("kept", "report.json");
  const std::string import = Bytes("kept", "import.json");

  EXPECT_THAT(ImportFiles(*character_, {WriteTestFile("bad.txt", "{}")},
                          options_, TestPath("kept"), &reports_),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected at least one clip")));
  options_.report_only = true;
  EXPECT_THAT(
      ImportFiles(*character_, {file}, options_, TestPath("kept"), &reports_),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               HasSubstr("kept: expected a folder without a library")));

  EXPECT_EQ(Bytes("kept", "report.json"), report);
  EXPECT_EQ(Bytes("kept", "import.json"), import);
}

TEST_F(ImporterTest, RefusesARateOutOfRange) {
  options_.rate = 0;
  EXPECT_THAT(
      ImportFiles(*character_, {}, options_, TestPath("rate"), &reports_),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("rate: expected > 0")));
}

TEST_F(ImporterTest, LeavesOutRecordingsWithTheirMirrorImages) {
  const std::string file = WriteTestFile("march.txt", testing::MarchJson());
  EXPECT_FALSE(Import({file}, "none")->clip(0).left_out());
  options_.edits.mirror = true;
  options_.left_out_share = 1;

  const auto library = Import({file}, "split");

  ASSERT_EQ(library->num_clips(), 2);
  EXPECT_TRUE(library->clip(0).left_out());
  EXPECT_TRUE(library->clip(1).left_out());
  EXPECT_EQ(ReportOf("split")["clips"][1]["left_out"], true);

  options_.left_out_share = 0;
  EXPECT_FALSE(Import({file}, "split")->clip(1).left_out());

  options_.left_out_share = 1.5;
  EXPECT_THAT(
      ImportFiles(*character_, {file}, options_, TestPath("share"), &reports_),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("left-out share: expected within [0, 1], "
                         "found 1.5")));
}

TEST_F(ImporterTest, MirrorsOnlyWhatLiesWithinThePathsThatItIsGiven) {
  const std::string left = WriteTestFile("left.txt", testing::MarchJson());
  const std::string right =
      WriteTestFile("right.txt", testing::MarchJson() + " ");
  options_.edits.mirror = true;
  options_.mirror_within = {right};

  const auto library = Import({left, right}, "some");

  ASSERT_EQ(library->num_clips(), 3);
  EXPECT_EQ(library->clip(0).name(), "left");
  EXPECT_EQ(library->clip(1).name(), "right");
  EXPECT_EQ(library->clip(2).name(), "right_mirror");
  EXPECT_EQ(library->clip(2).mirror_of(), "right");

  options_.mirror_within = {TestPath("")};
  EXPECT_EQ(Import({left, right}, "some")->num_clips(), 4);
  options_.mirror_within = {left};
  EXPECT_EQ(Import({left, right}, "some")->clip(1).name(), "left_mirror");
  EXPECT_EQ(Import({left, right}, "some")->num_clips(), 3);

  const auto refusal = [&] {
    return ImportFiles(*character_, {left, right}, options_,
                       TestPath("refused"), &reports_);
  };
  options_.mirror_within = {left, TestPath("centre.txt")};
  EXPECT_THAT(refusal(), StatusIs(absl::StatusCode::kInvalidArgument,
                                  HasSubstr("mirror within: expected the path "
                                            "of a file of this import")));
  options_.mirror_within = {left};
  options_.edits.mirror = false;
  EXPECT_THAT(refusal(), StatusIs(absl::StatusCode::kInvalidArgument,
                                  HasSubstr("mirror within: expected no "
                                            "paths")));
}

TEST_F(ImporterTest, RejectsWhatNoBodyCouldDoNamingFigureAndLimit) {
  ASSERT_NE(JumpingJson(), testing::MarchJson());
  Import({WriteTestFile("march.txt", testing::MarchJson()),
          WriteTestFile("jumps.txt", JumpingJson())},
         "gate");

  EXPECT_THAT(reports_[1].status,
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("jumps.txt"), HasSubstr("limit"))));
  EXPECT_EQ(reports_[1].verdict.status, ClipStatus::kRejected);
  EXPECT_TRUE(reports_[1].measured());
}

TEST_F(ImporterTest, ReportsEveryFileInOrder) {
  options_.credit.provenance = "made by formula";
  Import({WriteTestFile("march.txt", testing::MarchJson()),
          WriteTestFile("bad.txt", "{}"),
          WriteTestFile("jumps.txt", JumpingJson())},
         "report");

  const Json report = ReportOf("report");

  EXPECT_EQ(report["character"], "humanoid");
  EXPECT_EQ(report["counts"]["rejected"], 2);
  const Json& clips = report["clips"];
  ASSERT_THAT(clips, SizeIs(3));
  EXPECT_EQ(clips[0]["file"], TestPath("march.txt"));
  EXPECT_EQ(clips[0]["name"], "march");
  EXPECT_NE(clips[0]["status"], "rejected");
  EXPECT_NEAR(clips[0]["seconds"], 1, 1e-6);
  EXPECT_EQ(clips[0]["trial"], "march");
  for (const char* figure :
       {"foot_skate_cm_per_s", "penetration_cm", "floating_cm",
        "joint_limit_violations_percent", "peak_joint_speed_rad_per_s",
        "peak_joint_acceleration_rad_per_s2", "retarget_error_cm",
        "residual_force_bodyweights", "residual_torque_nm",
        "peak_torque_ratio"}) {
    EXPECT_TRUE(clips[0]["figures"][figure].is_number()) << figure;
  }
  EXPECT_EQ(clips[1]["status"], "rejected");
  EXPECT_THAT(clips[1]["reason"].get<std::string>(), HasSubstr("bad.txt"));
  EXPECT_FALSE(clips[1].contains("figures"));
  EXPECT_EQ(clips[2]["status"], "rejected");
  EXPECT_TRUE(clips[2]["figures"].is_object());
}

TEST_F(ImporterTest, CreditsEveryFileByItsFolder) {
  options_.credit = {"made by formula", "CC0"};
  options_.credits = {{TestPath("mocap"), {"a mocap database", "free"}}};
  const auto library =
      Import({WriteTestFile("mocap/march.txt", testing::MarchJson()),
              WriteTestFile("own.txt", testing::MarchJson(0.01))},
             "credits");

  EXPECT_EQ(library->clip(0).provenance(), "a mocap database");
  EXPECT_EQ(library->clip(0).licence(), "free");
  EXPECT_EQ(library->clip(1).provenance(), "made by formula");
  EXPECT_EQ(library->clip(1).licence(), "CC0");
}

TEST_F(ImporterTest, RefusesACreditOfNoFile) {
  const std::string file =
      WriteTestFile("mocap/march.txt", testing::MarchJson());
  const PathCredit good = {TestPath("mocap"), {"a mocap database", "free"}};
  // Misspelt, empty, and where a nearer one says otherwise.
  for (const std::string& path :
       {TestPath("mocop"), std::string(), TestPath("")}) {
    options_.credits = {good, {path, {"another", "free"}}};

    EXPECT_THAT(ImportFiles(*character_, {file}, options_, TestPath("refused"),
                            &reports_),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         HasSubstr(absl::StrCat("found \"", path, "\""))))
        << path;
  }
  EXPECT_FALSE(FileExists(TestPath("refused")));
}

TEST_F(ImporterTest, GivesTheSameLibraryOnAnyNumberOfThreads) {
  std::vector<std::string> files;
  for (int i = 0; i < 5; ++i) {
    files.push_back(WriteTestFile(absl::StrCat("march", i, ".txt"),
                                  testing::MarchJson(0.01 * i)));
  }
  options_.threads = 1;
  Import(files, "one");
  options_.threads = 4;
  Import(files, "four");

  for (const char* name : {"manifest.json", "frames.safetensors"}) {
    EXPECT_EQ(Bytes("one", name), Bytes("four", name)) << name;
  }
}

TEST_F(ImporterTest, TakesPathsWithSpacesAndAnyLetters) {
  const auto library = Import(
      {WriteTestFile("M\u00e4rz 2026/\u6b69\u304f.txt", testing::MarchJson()),
       WriteTestFile("caf\xE9/caf\xE9.txt", testing::MarchJson(0.01))},
      "\u0431\u0438\u0431\u043b \u00fc");

  EXPECT_EQ(library->clip(0).name(), "\u6b69\u304f");
  EXPECT_EQ(library->clip(1).name(), "caf%E9");
}

TEST_F(ImporterTest, NamesTheSecondClipOfANameAfterItsFolder) {
  const auto library =
      Import({WriteTestFile("a/walk.txt", testing::MarchJson()),
              WriteTestFile("b/walk.txt", testing::MarchJson(0.01))},
             "names");

  EXPECT_EQ(library->clip(0).name(), "walk");
  EXPECT_EQ(library->clip(1).name(), "b_walk");
  // One recording, as far as names tell: never split between training and test.
  EXPECT_EQ(library->clip(0).trial(), library->clip(1).trial());
}

TEST_F(ImporterTest, RefusesAFolderThatAnotherImportHolds) {
  const std::string file = WriteTestFile("march.txt", testing::MarchJson());
  ASSERT_THAT(MakeDirectories(TestPath("held")), IsOk());
  const auto lock = DirectoryLock::Acquire(TestPath("held"));
  ASSERT_THAT(lock, IsOk());

  EXPECT_THAT(
      ImportFiles(*character_, {file}, options_, TestPath("held"), &reports_),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("held")));
}

TEST_F(ImporterTest, CanReportWithoutWritingALibrary) {
  options_.report_only = true;

  EXPECT_THAT(ImportFiles(*character_,
                          {WriteTestFile("march.txt", testing::MarchJson())},
                          options_, TestPath("report"), &reports_),
              IsOk());

  EXPECT_THAT(ReportOf("report")["clips"], SizeIs(1));
  EXPECT_FALSE(FileExists(JoinPath(TestPath("report"), "manifest.json")));
}

TEST_F(ImporterTest, TellsOfEveryFileOnce) {
  std::vector<int> done;
  options_.on_progress = [&](const ImportProgress& progress) {
    done.push_back(progress.done);
    EXPECT_EQ(progress.total, 2);
    EXPECT_THAT(progress.last->file, Not(IsEmpty()));
  };
  Import({WriteTestFile("march.txt", testing::MarchJson()),
          WriteTestFile("bad.txt", "{}")},
         "telling");
  EXPECT_EQ(done, std::vector<int>({1, 2}));
}

}  // namespace
}  // namespace sinew::import
