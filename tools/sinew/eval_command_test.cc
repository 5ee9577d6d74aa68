#include "tools/sinew/eval_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
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

TEST(EvalCommand, EvaluatesABundleAndTabulatesWhatItFound) {
  const auto toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  const std::string out = JoinPath(toy.folder, "eval.json");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
              IsOk());
  world::testing::LeaveOutOnDisk(2, toy.library_folder);
  // Of the three clips, and of a fourth that is not among them.
  ASSERT_THAT(
      WriteFileAtomically(
          JoinPath(toy.library_folder, "report.json"),
          R"({"clips": [{"status": "ok"}, {"status": "ok"}, {"status": "ok"},
              {"status": "rejected", "frames": 9}]})"),
      IsOk());

  CaptureStdout();
  const absl::Status evaluated =
      Eval(absl::StrCat("--bundle ", bundle, " --motions ", toy.library_folder,
                        " --out ", out, " --starts 1 --seconds 0.5"));
  const std::string said = GetCapturedStdout();

  ASSERT_THAT(evaluated, IsOk());
  EXPECT_THAT(said, AllOf(HasSubstr("trained on"), HasSubstr("left out"),
                          HasSubstr("of 4 clips")));
  CaptureStdout();
  const absl::Status tabulated =
      Eval(absl::StrCat("--table toy=", out, " --table again=", out));
  const std::string table = GetCapturedStdout();
  ASSERT_THAT(tabulated, IsOk());
  EXPECT_THAT(table, AllOf(HasSubstr("| toy |"), HasSubstr("| again |"),
                           HasSubstr("/4) |")));
}

TEST(EvalCommand, FailsStartsAtTheDistanceThatItIsTold) {
  const auto toy = world::testing::MakeToyWorld();
  const std::string bundle = JoinPath(toy.folder, "bundle");
  const std::string out = JoinPath(toy.folder, "eval.json");
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle),
              IsOk());
  const std::string all =
      absl::StrCat("--bundle ", bundle, " --motions ", toy.library_folder,
                   " --out ", out, " --starts 1 --seconds 0.5");

  CaptureStdout();
  const absl::Status usual = Eval(all);
  const std::string usually = GetCapturedStdout();
  CaptureStdout();
  const absl::Status strict = Eval(all + " --max-mean-body-distance 1e-6");
  const std::string strictly = GetCapturedStdout();

  ASSERT_THAT(usual, IsOk());
  EXPECT_THAT(usually, Not(HasSubstr("policy       0 of 3 clips")));
  ASSERT_THAT(strict, IsOk());
  EXPECT_THAT(strictly, HasSubstr("policy       0 of 3 clips"));
  EXPECT_THAT(*ReadFile(out), HasSubstr("\"fall_distance_m\": 1e-06"));
  EXPECT_THAT(
      Eval(all + " --max-mean-body-distance 0"),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("evaluation.max_mean_body_distance: expected")));
}

TEST(EvalCommand, NamesTheFlagThatIsMissing) {
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

TEST(EvalCommand, TakesNoOtherFlagBesideATable) {
  EXPECT_THROW(static_cast<void>(Eval("--table a=o.json --bundle b")),
               CLI::ExcludesError);
  EXPECT_THROW(static_cast<void>(Eval("--starts 2 --table a=o.json")),
               CLI::ExcludesError);
}

}  // namespace
}  // namespace sinew::tools
