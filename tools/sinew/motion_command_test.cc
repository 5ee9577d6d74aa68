#include "tools/sinew/motion_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "nlohmann/json.hpp"
#include "sim/import/testing/made_clips.h"
#include "tools/sinew/command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::sinew::testing::TestPath;
using ::sinew::testing::WriteTestFile;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

class MotionCommandTest : public ::testing::Test {
 protected:
  // Runs `sinew motion ...`; what it prints is in printed_.
  absl::Status Run(std::vector<std::string> words) {
    CLI::App app;
    Action action;
    AddMotionCommand(app, action);
    words.insert(words.begin(), "motion");
    std::vector<std::string> reversed(words.rbegin(), words.rend());
    app.parse(reversed);
    ::testing::internal::CaptureStdout();
    const absl::Status status = action(StopToken());
    printed_ = ::testing::internal::GetCapturedStdout();
    return status;
  }

  std::string printed_;
};

TEST_F(MotionCommandTest, ImportsAFolderAndReportsIt) {
  WriteTestFile("clips/march.txt", import::testing::MarchJson());
  WriteTestFile("clips/sub folder/lying.txt", import::testing::LyingJson());
  const std::string bad = WriteTestFile("bad.txt", "{}");

  EXPECT_THAT(Run({"import", "--out", TestPath("library"), "--licence", "CC0",
                   "--no-pictures", TestPath("clips"), bad}),
              IsOk());

  EXPECT_THAT(printed_, AllOf(HasSubstr("1 rejected"), HasSubstr("bad.txt"),
                              HasSubstr("march"), HasSubstr("report.html")));
  const Json report =
      Json::parse(*ReadFile(JoinPath(TestPath("library"), "report.json")));
  EXPECT_EQ(report["clips"].size(), 3);
  EXPECT_TRUE(FileExists(JoinPath(TestPath("library"), "report.html")));

  EXPECT_THAT(Run({"inspect", TestPath("library")}), IsOk());
  EXPECT_THAT(printed_, AllOf(HasSubstr("2 clips"), HasSubstr("deepmimic"),
                              HasSubstr("CC0")));
  EXPECT_THAT(Run({"inspect", TestPath("library"), "--clip", "march"}), IsOk());
  EXPECT_THAT(printed_, AllOf(HasSubstr("format                 deepmimic"),
                              HasSubstr("unexplained root force")));
  EXPECT_THAT(Run({"inspect", TestPath("library"), "--clip", "walk"}),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("\"walk\"")));
}

TEST_F(MotionCommandTest, CreditsFilesByPath) {
  const std::string mocap =
      WriteTestFile("mocap/march.txt", import::testing::MarchJson());
  const std::string own =
      WriteTestFile("own.txt", import::testing::MarchJson(0.01));

  EXPECT_THAT(Run({"import", "--out", TestPath("library"), "--no-html",
                   "--credit", TestPath("mocap"), "a mocap database", "free",
                   "--credit", own, "a dancer", "CC BY 4.0", mocap, own}),
              IsOk());

  ASSERT_THAT(Run({"inspect", TestPath("library"), "--clip", "march"}), IsOk());
  EXPECT_THAT(printed_,
              AllOf(HasSubstr("a mocap database"), HasSubstr("free")));
  ASSERT_THAT(Run({"inspect", TestPath("library"), "--clip", "own"}), IsOk());
  EXPECT_THAT(printed_, AllOf(HasSubstr("a dancer"), HasSubstr("CC BY 4.0")));
}

TEST_F(MotionCommandTest, MirrorsAllOrSomeOfTheFiles) {
  const std::string one =
      WriteTestFile("one.txt", import::testing::MarchJson());
  const std::string two =
      WriteTestFile("two.txt", import::testing::MarchJson(0.01));
  const std::string out = TestPath("mirrors");

  ASSERT_THAT(Run({"import", "--out", out, "--no-html", "--mirror-within", two,
                   one, two}),
              IsOk());

  ASSERT_THAT(Run({"inspect", out}), IsOk());
  EXPECT_THAT(printed_, AllOf(HasSubstr("3 clips"), HasSubstr("two_mirror"),
                              Not(HasSubstr("one_mirror"))));
  EXPECT_THROW(static_cast<void>(Run({"import", "--out", out, "--mirror",
                                      "--mirror-within", two, one, two})),
               CLI::ExcludesError);
}

TEST_F(MotionCommandTest, RefusesNumbersThatAreNone) {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{
           {"import", "--out", "x", "--fps", "nan", "f"},
           {"import", "--out", "x", "--unit", "nan", "f"},
           {"import", "--out", "x", "--rate", "nan", "f"},
           {"import", "--out", "x", "--left-out-share", "nan", "f"},
           {"import", "--out", "x", "--trim", "0", "nan", "f"},
           {"blend", "--out", "x", "--seconds", "nan", "f", "g"},
           {"report", "x", "--megabytes", "nan"},
           {"render", "x", "--video", "--seconds", "nan"}}) {
    EXPECT_THROW(static_cast<void>(Run(words)), CLI::ValidationError)
        << words[0] << " " << words[3];
  }
}

TEST_F(MotionCommandTest, HasSecondsOfAVideoAlone) {
  EXPECT_THROW(static_cast<void>(Run({"render", "x", "--seconds", "5"})),
               CLI::RequiresError);
}

TEST_F(MotionCommandTest, FailsWhereNoFileCanBeImportedButSaysWhy) {
  EXPECT_THAT(Run({"import", "--out", TestPath("library"),
                   WriteTestFile("bad.txt", "{}")}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected at least one clip")));

  EXPECT_THAT(printed_, HasSubstr("bad.txt"));
  EXPECT_TRUE(FileExists(JoinPath(TestPath("library"), "report.json")));
  EXPECT_TRUE(FileExists(JoinPath(TestPath("library"), "report.html")));
}

TEST_F(MotionCommandTest, ReportsAnImportThatWroteNoLibrary) {
  const std::string march =
      WriteTestFile("march.txt", import::testing::MarchJson());
  const std::string page = JoinPath(TestPath("library"), "report.html");
  ASSERT_THAT(Run({"import", "--out", TestPath("library"), "--report-only",
                   "--no-html", march}),
              IsOk());
  EXPECT_THAT(printed_, HasSubstr("good enough for the library"));
  EXPECT_THAT(Run({"report", TestPath("library"), "--pictures", "0"}), IsOk());
  EXPECT_TRUE(FileExists(page));

  // Where every file was rejected, too.
  ASSERT_THAT(Run({"import", "--out", TestPath("library"), "--no-html",
                   WriteTestFile("bad.txt", "{}")}),
              StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_FALSE(FileExists(page));
  EXPECT_THAT(Run({"report", TestPath("library"), "--pictures", "0"}), IsOk());
  EXPECT_THAT(*ReadFile(page), HasSubstr("bad.txt"));
}

TEST_F(MotionCommandTest, AGivenMapIsNoDraftWhateverItsName) {
  const std::string march =
      WriteTestFile("march.txt", import::testing::MarchJson());
  ASSERT_THAT(Run({"map", march, "--draft"}), IsOk());
  ASSERT_THAT(printed_, HasSubstr("name: \"draft\""));
  const std::string map = WriteTestFile("mine.textproto", printed_);

  ASSERT_THAT(Run({"import", "--out", TestPath("library"), "--map", map,
                   "--no-html", march}),
              IsOk());

  const Json report =
      Json::parse(*ReadFile(JoinPath(TestPath("library"), "report.json")));
  const Json& clip = report["clips"][0];
  EXPECT_EQ(clip["source"]["map"], "draft");
  EXPECT_THAT(clip["reason"].get<std::string>(),
              Not(HasSubstr("no known skeleton map")));
}

TEST_F(MotionCommandTest, ASecondImportLeavesTheReportAlone) {
  const std::string march =
      WriteTestFile("march.txt", import::testing::MarchJson());
  const std::vector<std::string> words = {
      "import", "--out", TestPath("library"), "--no-pictures", march};
  ASSERT_THAT(Run(words), IsOk());
  const std::string page = JoinPath(TestPath("library"), "report.html");
  ASSERT_THAT(WriteFileAtomically(page, "mine"), IsOk());

  EXPECT_THAT(Run(words), IsOk());

  EXPECT_EQ(*ReadFile(page), "mine");
  EXPECT_THAT(printed_, HasSubstr("1 unchanged files not read again"));
  EXPECT_THAT(Run({"report", TestPath("library"), "--pictures", "0"}), IsOk());
  EXPECT_THAT(*ReadFile(page), HasSubstr("<!doctype html>"));
}

TEST_F(MotionCommandTest, TrimTakesTwoNumbersAndNoFiles) {
  const std::string march =
      WriteTestFile("march.txt", import::testing::MarchJson());
  const std::string other =
      WriteTestFile("other.txt", import::testing::MarchJson(0.05));

  EXPECT_THAT(Run({"import", "--out", TestPath("library"), "--no-html",
                   "--trim", "0.2", "0.7", march, other}),
              IsOk());

  const Json report =
      Json::parse(*ReadFile(JoinPath(TestPath("library"), "report.json")));
  EXPECT_EQ(report["clips"].size(), 2);
}

TEST_F(MotionCommandTest, BlendsTwoClipsOverAGap) {
  const std::string march =
      WriteTestFile("march.txt", import::testing::MarchJson());
  const std::string other =
      WriteTestFile("other.txt", import::testing::MarchJson(0.05));

  ASSERT_THAT(Run({"blend", "--out", TestPath("library"), "--seconds", "0.2",
                   "--no-pictures", "--trim-first", "0", "0.8", march, "--with",
                   march, other}),
              IsOk());

  EXPECT_THAT(printed_,
              AllOf(HasSubstr("march_to_other"), HasSubstr("report.html")));
  EXPECT_THAT(Run({"inspect", TestPath("library")}), IsOk());
  EXPECT_THAT(printed_, HasSubstr("2 clips, 90 frames"));
  EXPECT_THAT(Run({"inspect", TestPath("library"), "--clip", "march_to_other"}),
              IsOk());
  EXPECT_THAT(printed_, HasSubstr("0.2 s by other.txt"));
}

TEST_F(MotionCommandTest, BlendsTheListedPairsIntoOneLibrary) {
  WriteTestFile("march.txt", import::testing::MarchJson());
  WriteTestFile("other.txt", import::testing::MarchJson(0.05));
  const std::string list = WriteTestFile("blends.textproto", R"(
    blends { first: "march.txt" second: "other.txt" gap_s: 0.2 first_to_s: 0.8 }
    blends { first: "march.txt" second: "other.txt" gap_s: 1 name: "again" })");

  ASSERT_THAT(
      Run({"blend", "--out", TestPath("library"), "--no-html", "--list", list}),
      IsOk());

  EXPECT_THAT(printed_,
              AllOf(HasSubstr("march_to_other"), HasSubstr("  again  ")));
  // A root that is mistyped gives no library of the others alone.
  EXPECT_THAT(
      Run({"blend", "--out", TestPath("library"), "--no-html", "--list", list,
           "--root", TestPath("elsewhere"), "--with", TestPath("march.txt")}),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("root: expected a folder")));
}

TEST_F(MotionCommandTest, BlendsTwoClipsOrAList) {
  const std::string list = WriteTestFile(
      "blends.textproto", "blends { first: \"a\" second: \"b\" }");
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"blend", "--out", TestPath("library")});
    return Run(words);
  };
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--seconds", "0.2"},
        {"--trim-first", "0", "1"},
        {"--trim-second", "0", "1"},
        {"a.txt", "b.txt"}}) {
    std::vector<std::string> words = {"--list", list};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_THROW(static_cast<void>(run(words)), CLI::ExcludesError) << more[0];
  }
  EXPECT_THROW(static_cast<void>(run({"--root", "a", "b.txt", "c.txt"})),
               CLI::RequiresError);
  EXPECT_THAT(run({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                HasSubstr("expected two clips or --list, "
                                          "found neither")));
  EXPECT_THAT(run({"a.txt"}), StatusIs(absl::StatusCode::kInvalidArgument,
                                       HasSubstr("found one clip")));
}

TEST_F(MotionCommandTest, RefusesToBlendWhatIsNoClipOrOverNoGap) {
  const std::string march =
      WriteTestFile("march.txt", import::testing::MarchJson());
  EXPECT_THAT(Run({"blend", "--out", TestPath("library"), "--no-html", march,
                   TestPath("absent.txt")}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected at least one clip")));
  EXPECT_THAT(printed_, HasSubstr("absent.txt"));
  EXPECT_THAT(Run({"blend", "--out", TestPath("library"), "--seconds", "0",
                   march, march}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("gap of more than 0")));
}

TEST_F(MotionCommandTest, RefusesNumbersOfThreadsThatNoMachineHas) {
  for (const char* threads : {"0", "-2", "1000000"}) {
    EXPECT_THROW(
        static_cast<void>(Run({"import", "--out", TestPath("library"),
                               absl::StrCat("--threads=", threads), "x.bvh"})),
        CLI::ValidationError)
        << threads;
  }
}

TEST_F(MotionCommandTest, PrintsTheMapOfASkeletonForEditing) {
  const std::string march =
      WriteTestFile("march.txt", import::testing::MarchJson());

  EXPECT_THAT(Run({"map", march}), IsOk());
  EXPECT_THAT(printed_,
              AllOf(HasSubstr("name: \"deepmimic\""), HasSubstr("left_hip")));
  EXPECT_THAT(Run({"map", march, "--draft", "--name", "mine"}), IsOk());
  EXPECT_THAT(printed_,
              AllOf(HasSubstr("name: \"mine\""), HasSubstr("left_hip")));

  // And back again.
  const std::string map = WriteTestFile("mine.textproto", printed_);
  EXPECT_THAT(Run({"import", "--out", TestPath("library"), "--map", map,
                   "--no-html", march}),
              IsOk());
  EXPECT_THAT(
      Run({"import", "--out", TestPath("other"), "--map",
           WriteTestFile("bad.textproto", "name: \"bad\""), march}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("bad.textproto")));
}

}  // namespace
}  // namespace sinew::tools
