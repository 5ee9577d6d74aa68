#include "tools/sinew/promote_command.h"

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/local_store.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"
#include "tools/sinew/testing/run_command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RunCommand;

// Two bundles of the toy: "good" all but follows the reference, "bad" pulls all
// legs up by 8 units, so that the trunk falls.
class PromoteCommand : public ::testing::Test {
 protected:
  PromoteCommand() : toy_(world::testing::MakeToyWorld()) {
    Write("good", 0);
    Write("bad", 8);
  }

  // `distance`: at which starts of its evaluations fail, m.
  void Write(const std::string& name, float action, double distance = 0.5) {
    bundle::BundleContent content =
        bundle::testing::ToyContent(toy_, /*gain=*/0.01);
    for (float& bias :
         content.weights.at("policy/mean/bias").mutable_float32()) {
      bias += action;
    }
    content.manifest.set_max_mean_body_distance(distance);
    EXPECT_THAT(bundle::WriteBundle(content, Path(name)), IsOk());
  }

  std::string Path(const std::string& name) const {
    return JoinPath(toy_.folder, name);
  }

  absl::Status Run(const std::string& arguments) {
    return RunCommand(
        AddPromoteCommand,
        absl::StrCat("promote --store ", Path("store"), " ", arguments),
        /*stop=*/{}, &output_);
  }

  absl::Status Promote(const std::string& name, const std::string& more = "") {
    return Run(absl::StrCat("--bundle ", Path(name), " --id ", name,
                            " --motions ", toy_.library_folder,
                            " --starts 1 --seconds 0.3 --threads 2 ", more));
  }

  // What an alias names; "none".
  std::string Alias(const std::string& alias) {
    const auto store =
        checkpoint::LocalStore::OpenReadOnly(Path("store"), clock_);
    if (!store.ok()) return "none";
    const auto artifact = (*store)->GetArtifact(alias);
    return artifact.ok() ? artifact->id() : "none";
  }

  const world::testing::ToyWorld toy_;
  const SystemClock clock_ = {};
  std::string output_;
};

TEST_F(PromoteCommand, MakesTheFirstBundleTheStableOne) {
  EXPECT_THAT(Promote("good"), IsOk());

  EXPECT_EQ(Alias("stable"), "good");
  EXPECT_EQ(Alias("stable-previous"), "none");
  EXPECT_THAT(output_, AllOf(HasSubstr("E_g-mpjpe"), HasSubstr(" mm\n"),
                             HasSubstr("stable -> good (was none)"),
                             Not(HasSubstr("where both win"))));
}

TEST_F(PromoteCommand, ReplacesAWorseOneAndCanGoBack) {
  ASSERT_THAT(Promote("bad"), IsOk());

  EXPECT_THAT(Promote("good"), IsOk());

  EXPECT_EQ(Alias("stable"), "good");
  EXPECT_EQ(Alias("stable-previous"), "bad");
  EXPECT_THAT(output_, HasSubstr("stable -> good (was bad)"));

  EXPECT_THAT(Run("--rollback"), IsOk());

  EXPECT_EQ(Alias("stable"), "bad");
  EXPECT_THAT(output_, HasSubstr("stable -> bad (was good)"));
  EXPECT_THAT(Run("--rollback"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("to go back to, found bad")));
}

TEST_F(PromoteCommand, RefusesAWorseOneAndLeavesTheStoreAsItIs) {
  ASSERT_THAT(Promote("good"), IsOk());

  EXPECT_THAT(Promote("bad"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(Path("bad") + ": not promoted: "),
                             HasSubstr("expected at"))));

  EXPECT_EQ(Alias("stable"), "good");
  EXPECT_EQ(Alias("stable-previous"), "none");
  EXPECT_EQ(Alias("bad"), "none");
  // Both are in the table.
  EXPECT_THAT(output_, AllOf(HasSubstr("\ngood "), HasSubstr("\nbad ")));
}

// Judged each by its own, the one that is stable would win all, this one none.
TEST_F(PromoteCommand, JudgesBothByTheCandidatesDistance) {
  Write("strict", 0, 1e-6);
  ASSERT_THAT(Promote("good"), IsOk());

  EXPECT_THAT(Promote("strict"), IsOk());

  EXPECT_EQ(Alias("stable"), "strict");
}

TEST_F(PromoteCommand, ToleratesWhatItIsTold) {
  ASSERT_THAT(Promote("good"), IsOk());

  EXPECT_THAT(Promote("bad", "--success-tolerance 1 --error-tolerance 1e6"),
              IsOk());

  EXPECT_EQ(Alias("stable"), "bad");
}

TEST_F(PromoteCommand, KeepsWhatIsStableAlready) {
  ASSERT_THAT(Promote("good"), IsOk());

  EXPECT_THAT(Promote("good"), IsOk());

  EXPECT_EQ(Alias("stable"), "good");
  EXPECT_EQ(Alias("stable-previous"), "none");
}

TEST_F(PromoteCommand, PrintsTheErrorsOfTheClipsThatBothWin) {
  ASSERT_THAT(Promote("good"), IsOk());
  ASSERT_THAT(Promote("good"), IsOk());

  // It wins two of three; its error over all frames is another one.
  EXPECT_THAT(output_, HasSubstr("E_g-mpjpe where both win\n"));
  EXPECT_THAT(output_,
              ContainsRegex("\ngood .* [0-9.]+ mm +[0-9.]+ mm\ngood "));
}

TEST_F(PromoteCommand, NamesABundleByItsDigestUnlessItIsTold) {
  ASSERT_THAT(
      Run(absl::StrCat("--bundle ", Path("good"), " --motions ",
                       toy_.library_folder, " --starts 1 --seconds 0.5")),
      IsOk());

  const auto good = bundle::ReadBundle(Path("good"));
  ASSERT_THAT(good, IsOk());
  EXPECT_EQ(Alias("stable"),
            "bundle-" + good->manifest.manifest_sha256().substr(0, 16));
}

TEST_F(PromoteCommand, TakesBundlesWithALatent) {
  const world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  ASSERT_THAT(bundle::WriteBundle(bundle::testing::ToyLatentContent(toy),
                                  Path("latent")),
              IsOk());

  EXPECT_THAT(Promote("latent"), IsOk());

  EXPECT_EQ(Alias("stable"), "latent");

  // What others decode latents by does not go away.
  EXPECT_THAT(Promote("good", "--success-tolerance 1 --error-tolerance 1e6"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr(Path("good") +
                                       ": cannot follow incumbent latent"),
                             HasSubstr("graphs: expected \"encoder\""))));
  EXPECT_EQ(Alias("stable"), "latent");
  EXPECT_EQ(Alias("good"), "none");
}

TEST_F(PromoteCommand, NamesTheCandidateThatIsAltered) {
  ASSERT_THAT(WriteFileAtomically(Path("good/policy.onnx"), "edited"), IsOk());

  EXPECT_THAT(Promote("good"),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr(Path("good")),
                             HasSubstr("policy.onnx: expected SHA-256"))));
  EXPECT_EQ(Alias("stable"), "none");
}

TEST_F(PromoteCommand, SaysWhichFlagsItNeeds) {
  EXPECT_THAT(Run("--motions x"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("--bundle: expected it without --rollback")));
  EXPECT_THAT(Run("--bundle x"), StatusIs(absl::StatusCode::kInvalidArgument,
                                          HasSubstr("--motions: expected it")));
  EXPECT_THAT(Run("--rollback --bundle x"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("--bundle: expected none with --rollback, "
                                 "found x")));
  // Before anything is evaluated.
  EXPECT_THAT(Run("--bundle none --motions none --id stable"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("--id: artifact id: expected none that is "
                                 "the name of an alias")));
}

TEST_F(PromoteCommand, RefusesNumbersThatMeanNothing) {
  for (const char* flag :
       {"--success-tolerance 2", "--success-tolerance nan",
        "--error-tolerance nan", "--error-tolerance inf", "--seconds nan",
        "--starts 0", "--starts 2000000000", "--threads=-5"}) {
    EXPECT_THROW(
        Run(absl::StrCat("--bundle x --motions x ", flag)).IgnoreError(),
        CLI::ValidationError)
        << flag;
  }
}

TEST_F(PromoteCommand, TakesNoFlagOfAnEvaluationToGoBack) {
  for (const char* flag :
       {"--id x", "--success-tolerance 0.5", "--error-tolerance 0.5",
        "--starts 2", "--seconds 2", "--threads 2"}) {
    EXPECT_THROW(Run(absl::StrCat("--rollback ", flag)).IgnoreError(),
                 CLI::ExcludesError)
        << flag;
  }
}

TEST_F(PromoteCommand, HasNothingToGoBackToInANewStore) {
  EXPECT_THAT(Run("--rollback"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("alias \"stable-previous\": expected")));
}

}  // namespace
}  // namespace sinew::tools
