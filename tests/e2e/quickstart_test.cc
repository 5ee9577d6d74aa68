// The whole way that a newcomer takes, shortened: import, train, evaluate,
// verify, report, through the real command.
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
using ::testing::HasSubstr;

std::string Scratch(const std::string& name) {
  return JoinPath(std::getenv("TEST_TMPDIR"), name);
}

// Exit code of `sinew quickstart` with these arguments; its output goes to
// `log`.
int Quickstart(std::vector<std::string> arguments, const std::string& log) {
  arguments.insert(arguments.begin(), "quickstart");
  arguments.insert(arguments.begin(), JoinPath(std::getenv("TEST_SRCDIR"),
                                               "sinew/tools/sinew/sinew"));
  const auto child = Subprocess::Start({.argv = arguments, .output_file = log});
  EXPECT_THAT(child, IsOk());
  const auto status = (*child)->Wait(absl::Minutes(4));
  EXPECT_THAT(status, IsOk());
  return status.ok() ? status->code : -1;
}

TEST(Quickstart, LeavesBundleEvaluationAndReportAndGoesOnWhereItWas) {
  const std::string out = Scratch("quickstart");
  const std::string log = Scratch("log");

  ASSERT_EQ(Quickstart({"--out", out, "--minutes", "0.03"}, log), 0)
      << *ReadFile(log);

  for (const char* file : {"motions/manifest.json", "metrics.jsonl",
                           "bundle/manifest.json", "eval.json"}) {
    EXPECT_TRUE(FileExists(JoinPath(out, file))) << file;
  }
  EXPECT_THAT(*ReadFile(JoinPath(out, "report.html")),
              HasSubstr("humanoid3d_walk"));
  EXPECT_THAT(*ReadFile(log), HasSubstr("$ ./sinew verify"));

  EXPECT_EQ(Quickstart({"--out", out, "--minutes", "0.03"}, log), 0);
  EXPECT_THAT(*ReadFile(log), HasSubstr("(done before: "));
}

TEST(Quickstart, RefusesATimeThatIsNone) {
  const std::string log = Scratch("refused");

  EXPECT_EQ(Quickstart({"--minutes", "0", "--out", Scratch("none")}, log), 2);

  EXPECT_THAT(*ReadFile(log), HasSubstr("--minutes: expected > 0, found 0"));
  EXPECT_FALSE(FileExists(Scratch("none")));
}

}  // namespace
}  // namespace sinew
