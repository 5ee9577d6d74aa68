// What the real command says to bad input: exit code 2, a message that names
// what was expected and found, and nothing written.
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/subprocess.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string text;  // of both streams
};

std::string Scratch(const std::string& name) {
  return JoinPath(std::getenv("TEST_TMPDIR"), name);
}

// Runs `sinew` with the arguments.
Outcome Sinew(std::vector<std::string> arguments) {
  static int run = 0;
  const std::string log = Scratch(absl::StrCat("run", ++run, ".log"));
  arguments.insert(arguments.begin(), JoinPath(std::getenv("TEST_SRCDIR"),
                                               "sinew/tools/sinew/sinew"));
  EXPECT_THAT(WriteFileAtomically(log, ""), IsOk());
  const auto child = Subprocess::Start({.argv = arguments, .output_file = log});
  EXPECT_THAT(child, IsOk());
  const auto status = (*child)->Wait(absl::Minutes(2));
  EXPECT_THAT(status, IsOk());
  EXPECT_EQ(status->signal, 0);
  return {.code = status->code, .text = *ReadFile(log)};
}

// `sinew train` into a run of this name.
Outcome Train(const std::string& run, std::vector<std::string> more) {
  std::vector<std::string> arguments = {"train", "--run", Scratch(run),
                                        "--motions", Scratch("no_library")};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return Sinew(arguments);
}

TEST(BadInput, OfTheCommandLineIsAUsageError) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{
           {},
           {"fly"},
           {"train", "--nonsense"},
           {"train"},
           {"bench"},
           {"motion"},
           {"motion", "import", "--rate", "fast"}}) {
    const Outcome outcome = Sinew(arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.text;
    EXPECT_FALSE(outcome.text.empty());
  }
}

TEST(BadInput, NamesTheWordThatIsUnknown) {
  EXPECT_THAT(Sinew({"trian", "--run", "r"}).text,
              HasSubstr("unknown here: trian"));
  EXPECT_THAT(Sinew({"motion", "imprt", "a.bvh"}).text,
              HasSubstr("unknown here: imprt"));
  EXPECT_THAT(Sinew({"train", "--nonsense"}).text,
              HasSubstr("unknown here: --nonsense"));
}

TEST(BadInput, NeverMakesHelpFail) {
  const Outcome outcome = Sinew({"--help"});

  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.text, AllOf(HasSubstr("train"), HasSubstr("bench")));
}

TEST(BadInput, NamesARecipeThatIsNotThere) {
  const Outcome outcome = Train("a", {"--recipe", "no_such_recipe"});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text, HasSubstr("no_such_recipe"));
  EXPECT_FALSE(FileExists(Scratch("a")));
}

TEST(BadInput, NamesFileLineAndTheNearestFieldOfARecipe) {
  const std::string recipe = Scratch("mine.textproto");
  ASSERT_THAT(WriteFileAtomically(recipe, "ppo {\n  epoch: 3\n}\n"), IsOk());

  const Outcome outcome = Train("b", {"--recipe", recipe});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text,
              AllOf(HasSubstr("mine.textproto:2:"), HasSubstr("\"epoch\""),
                    HasSubstr("\"epochs\"")));
  EXPECT_FALSE(FileExists(Scratch("b")));
}

TEST(BadInput, NamesAFieldThatIsOutOfRange) {
  const Outcome outcome =
      Train("c", {"--recipe", "track_clip", "--set", "ppo.ratio_clip=-1"});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text, AllOf(HasSubstr("recipe field ppo.ratio_clip"),
                                  HasSubstr("found -1")));
}

TEST(BadInput, NamesTheNearestPathOfAnAssignment) {
  const Outcome outcome =
      Train("d", {"--recipe", "track_clip", "--set", "ppo.minibach=64"});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text,
              AllOf(HasSubstr("minibach"), HasSubstr("\"minibatch\"")));
}

TEST(BadInput, NamesALagThatCouldDeadlock) {
  const Outcome outcome =
      Train("e", {"--recipe", "track_clip", "--set", "evaluation.delay=1",
                  "--set", "rollouts.max_policy_lag=1"});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text,
              AllOf(HasSubstr("evaluation.delay"),
                    HasSubstr("or the learner would wait for itself")));
}

TEST(BadInput, NamesALibraryThatCannotBeRead) {
  // The recipes themselves are good.
  for (const char* recipe : {"track_clip", "track_library"}) {
    const Outcome outcome = Train("f", {"--recipe", recipe});

    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.text, HasSubstr("no_library"));
    EXPECT_FALSE(FileExists(Scratch("f")));
  }
}

TEST(BadInput, NamesAFolderThatIsNoRun) {
  const Outcome outcome = Sinew({"curriculum", Scratch("no_run")});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text, HasSubstr("no_run: expected a run directory"));
}

TEST(BadInput, NamesHowManyFallenStartsThereMayBe) {
  for (const char* starts : {"0", "-3", "1000000"}) {
    const Outcome outcome = Sinew({"eval", "--bundle", Scratch("no_bundle"),
                                   "--motions", Scratch("no_library"), "--out",
                                   Scratch("eval.json"), "--fallen", starts});

    EXPECT_EQ(outcome.code, 2) << outcome.text;
    EXPECT_THAT(outcome.text, HasSubstr("fallen starts: expected 1 to 1024"));
    EXPECT_FALSE(FileExists(Scratch("eval.json")));
  }
}

TEST(BadInput, NamesWhatACharacterIsWhereAFolderIsGiven) {
  const std::string folder = Scratch("a_folder");
  ASSERT_THAT(MakeDirectories(folder), IsOk());

  const Outcome outcome =
      Sinew({"train", "--run", Scratch("g"), "--motions", Scratch("no_library"),
             "--recipe", "track_clip", "--character", folder});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text, AllOf(HasSubstr(".textproto file"),
                                  HasSubstr("found the folder " + folder)));
}

TEST(BadInput, NamesAClipThatCannotBeRead) {
  const std::string clip = Scratch("clip.txt");
  ASSERT_THAT(WriteFileAtomically(clip, "no clip"), IsOk());

  const Outcome outcome =
      Sinew({"motion", "import", "--out", Scratch("library"), clip});

  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.text, HasSubstr("clip.txt"));
  // A report says why; there is no library.
  EXPECT_TRUE(FileExists(Scratch("library/report.json")));
  EXPECT_FALSE(FileExists(Scratch("library/manifest.json")));
}

}  // namespace
}  // namespace sinew
