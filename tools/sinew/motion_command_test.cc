#include "tools/sinew/motion_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "nlohmann/json.hpp"
#include "sim/import/testing/made_clips.h"
#include "tools/sinew/command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class MotionCommandTest : public ::testing::Test {
 protected:
  static std::string Path(const std::string& name) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    return JoinPath(JoinPath(::testing::TempDir(), test->name()), name);
  }
  static std::string Write(const std::string& name, const std::string& text) {
    const std::string path = Path(name);
    EXPECT_THAT(MakeDirectories(path.substr(0, path.find_last_of('/'))),
                IsOk());
    EXPECT_THAT(WriteFileAtomically(path, text), IsOk());
    return path;
  }

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
  Write("clips/march.txt", import::testing::MarchJson());
  Write("clips/sub folder/lying.txt", import::testing::LyingJson());
  const std::string bad = Write("bad.txt", "{}");

  EXPECT_THAT(Run({"import", "--out", Path("library"), "--licence", "CC0",
                   "--no-pictures", Path("clips"), bad}),
              IsOk());

  EXPECT_THAT(printed_, AllOf(HasSubstr("1 rejected"), HasSubstr("bad.txt"),
                              HasSubstr("march"), HasSubstr("report.html")));
  const Json report =
      Json::parse(*ReadFile(JoinPath(Path("library"), "report.json")));
  EXPECT_EQ(report["clips"].size(), 3);
  EXPECT_TRUE(FileExists(JoinPath(Path("library"), "report.html")));

  EXPECT_THAT(Run({"inspect", Path("library")}), IsOk());
  EXPECT_THAT(printed_, AllOf(HasSubstr("2 clips"), HasSubstr("deepmimic"),
                              HasSubstr("CC0")));
  EXPECT_THAT(Run({"inspect", Path("library"), "--clip", "march"}), IsOk());
  EXPECT_THAT(printed_, AllOf(HasSubstr("format                 deepmimic"),
                              HasSubstr("unexplained root force")));
  EXPECT_THAT(Run({"inspect", Path("library"), "--clip", "walk"}),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("\"walk\"")));
}

TEST_F(MotionCommandTest, FailsWhereNoFileCanBeImportedButSaysWhy) {
  EXPECT_THAT(Run({"import", "--out", Path("library"), Write("bad.txt", "{}")}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected at least one clip")));

  EXPECT_THAT(printed_, HasSubstr("bad.txt"));
  EXPECT_TRUE(FileExists(JoinPath(Path("library"), "report.json")));
  EXPECT_TRUE(FileExists(JoinPath(Path("library"), "report.html")));
}

TEST_F(MotionCommandTest, ASecondImportLeavesTheReportAlone) {
  const std::string march = Write("march.txt", import::testing::MarchJson());
  const std::vector<std::string> words = {"import", "--out", Path("library"),
                                          "--no-pictures", march};
  ASSERT_THAT(Run(words), IsOk());
  const std::string page = JoinPath(Path("library"), "report.html");
  ASSERT_THAT(WriteFileAtomically(page, "mine"), IsOk());

  EXPECT_THAT(Run(words), IsOk());

  EXPECT_EQ(*ReadFile(page), "mine");
  EXPECT_THAT(printed_, HasSubstr("1 unchanged files not read again"));
  EXPECT_THAT(Run({"report", Path("library"), "--pictures", "0"}), IsOk());
  EXPECT_THAT(*ReadFile(page), HasSubstr("<!doctype html>"));
}

TEST_F(MotionCommandTest, PrintsTheMapOfASkeletonForEditing) {
  const std::string march = Write("march.txt", import::testing::MarchJson());

  EXPECT_THAT(Run({"map", march}), IsOk());
  EXPECT_THAT(printed_,
              AllOf(HasSubstr("name: \"deepmimic\""), HasSubstr("left_hip")));
  EXPECT_THAT(Run({"map", march, "--draft", "--name", "mine"}), IsOk());
  EXPECT_THAT(printed_,
              AllOf(HasSubstr("name: \"mine\""), HasSubstr("left_hip")));

  // And back again.
  const std::string map = Write("mine.textproto", printed_);
  EXPECT_THAT(Run({"import", "--out", Path("library"), "--map", map,
                   "--no-html", march}),
              IsOk());
  EXPECT_THAT(
      Run({"import", "--out", Path("other"), "--map",
           Write("bad.textproto", "name: \"bad\""), march}),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("bad.textproto")));
}

}  // namespace
}  // namespace sinew::tools
