#include "tools/sinew/eval_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"
#include "tools/evaluation/testing/written_bundle.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::internal::CaptureStdout;
using ::testing::internal::GetCapturedStdout;

absl::Status Eval(const std::string& arguments) {
  CLI::App app;
  app.require_subcommand(1);
  Action action;
  AddEvalCommand(app, action);
  app.parse(absl::StrCat("eval ", arguments));
  return action(StopToken());
}

class EvalCommand : public evaluation::testing::WrittenBundle {
 protected:
  // Of the bundle; what it prints goes to `said`.
  absl::Status Evaluate(const std::string& more, std::string* said) const {
    CaptureStdout();
    const absl::Status status =
        Eval(absl::StrCat("--bundle ", bundle_, " --motions ", motions_,
                          " --out ", out_, " --starts 1 --seconds 0.5", more));
    *said = GetCapturedStdout();
    return status;
  }
};

TEST_F(EvalCommand, EvaluatesABundleAndTabulatesWhatItFound) {
  Write();
  world::testing::LeaveOutOnDisk(2, motions_);
  // Of the three clips, and of a fourth that is not among them.
  ASSERT_THAT(
      WriteFileAtomically(
          JoinPath(motions_, "report.json"),
          R"({"clips": [{"status": "ok"}, {"status": "ok"}, {"status": "ok"},
              {"status": "rejected", "frames": 9}]})"),
      IsOk());

  std::string said;
  ASSERT_THAT(Evaluate("", &said), IsOk());
  EXPECT_THAT(said, AllOf(HasSubstr("trained on"), HasSubstr("left out"),
                          HasSubstr("of 4 clips")));
  CaptureStdout();
  const absl::Status tabulated =
      Eval(absl::StrCat("--table toy=", out_, " --table again=", out_));
  const std::string table = GetCapturedStdout();
  ASSERT_THAT(tabulated, IsOk());
  EXPECT_THAT(table, AllOf(HasSubstr("| toy |"), HasSubstr("| again |"),
                           HasSubstr("/4) |")));
}

TEST_F(EvalCommand, FailsStartsAtTheDistanceThatItIsTold) {
  Write();
  std::string usually, strictly, refused;

  ASSERT_THAT(Evaluate("", &usually), IsOk());
  EXPECT_THAT(usually, Not(HasSubstr("policy       0 of 3 clips")));
  ASSERT_THAT(Evaluate(" --max-mean-body-distance 1e-6", &strictly), IsOk());
  EXPECT_THAT(strictly, HasSubstr("policy       0 of 3 clips (0 from their "
                                  "first frame), 0 of 3 starts"));
  // Each failed at its first frame, and no clip is among the successful ones.
  EXPECT_THAT(strictly, ContainsRegex("policy .* E_g [0-9.]+ mm, E [0-9.]+ "
                                      "mm, E_vel -, E_acc -\n"));
  EXPECT_THAT(strictly, ContainsRegex("\nsuccessful .* E_g -, E -, E_vel -, "
                                      "E_acc -\n"));
  EXPECT_THAT(*ReadFile(out_), HasSubstr("\"fall_distance_m\": 1e-06"));
  EXPECT_THAT(
      Evaluate(" --max-mean-body-distance 0", &refused),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("evaluation.max_mean_body_distance: expected")));
}

TEST_F(EvalCommand, NamesTheFlagThatIsMissing) {
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(Eval("--bundle b --out o"),
              StatusIs(kInvalid, HasSubstr("--motions")));
  EXPECT_THAT(Eval("--table o.json"),
              StatusIs(kInvalid, HasSubstr("expected NAME=FILE")));
  EXPECT_THAT(
      Eval("--bundle b --motions m --out /nowhere/o.json"),
      StatusIs(absl::StatusCode::kNotFound,
               HasSubstr("/nowhere/o.json: expected a folder /nowhere")));
  EXPECT_THAT(
      Eval("--table a=/nowhere/o.json"),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere/o.json")));
}

TEST_F(EvalCommand, RefusesNumbersThatMeanNothing) {
  for (const char* flag :
       {"--seconds nan", "--seconds inf", "--max-mean-body-distance nan",
        "--starts 0", "--starts 2000000000", "--threads=-5"}) {
    EXPECT_THROW(Eval(absl::StrCat("--bundle b --motions m --out o ", flag))
                     .IgnoreError(),
                 CLI::ValidationError)
        << flag;
  }
}

TEST_F(EvalCommand, TakesNoOtherFlagBesideATable) {
  EXPECT_THROW(static_cast<void>(Eval("--table a=o.json --bundle b")),
               CLI::ExcludesError);
  EXPECT_THROW(static_cast<void>(Eval("--starts 2 --table a=o.json")),
               CLI::ExcludesError);
}

}  // namespace
}  // namespace sinew::tools
