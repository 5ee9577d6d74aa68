#include "tools/sinew/run_flags.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/testing/matchers.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

absl::StatusOr<TrainingRun::Options> OptionsOf(const std::string& more) {
  CLI::App app;
  RunFlags flags;
  AddRunFlags(app, flags);
  app.parse("--recipe pulse --motions clips --run runs/pulse " + more);
  return MakeRunOptions(flags);
}

TEST(RunFlags, SayHowTeachersOnOtherMachinesAreSpokenTo) {
  const auto options = OptionsOf(
      "--teacher 10.0.0.2:7004 --tls-certificate own.pem --tls-key "
      "own.key --tls-authority authority.pem");

  ASSERT_THAT(options, IsOk());
  EXPECT_THAT(options->teachers, ElementsAre("10.0.0.2:7004"));
  EXPECT_EQ(options->security.certificate_file, "own.pem");
  EXPECT_EQ(options->security.key_file, "own.key");
  EXPECT_EQ(options->security.authority_file, "authority.pem");
  EXPECT_FALSE(options->security.allow_insecure);
}

TEST(RunFlags, SetTheRecipesFieldsAndItsSeed) {
  const auto options =
      OptionsOf("--seed 7 --set ppo.epochs=3 --threads 2 --allow-insecure");

  ASSERT_THAT(options, IsOk());
  EXPECT_EQ(options->recipe.seed(), 7);
  EXPECT_EQ(options->recipe.ppo().epochs(), 3);
  EXPECT_EQ(options->cores, 2);
  EXPECT_TRUE(options->security.allow_insecure);
}

TEST(RunFlags, RefuseTimesThatAreNoNumber) {
  for (const char* flag :
       {"--minutes", "--teacher-patience", "--teacher-timeout"}) {
    for (const char* time : {" nan", " inf"}) {
      EXPECT_THROW(static_cast<void>(OptionsOf(std::string(flag) + time)),
                   CLI::ValidationError)
          << flag << time;
    }
  }
}

TEST(RunFlags, AFieldThatNoRecipeHasIsNamed) {
  EXPECT_THAT(
      OptionsOf("--set ppo.epoch=3"),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("ppo.epoch")));
}

}  // namespace
}  // namespace sinew::tools
