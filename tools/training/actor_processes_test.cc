#include "tools/training/actor_processes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <csignal>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/rpc/retry.h"
#include "common/testing/matchers.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string NewFolder() {
  std::string path = JoinPath(getenv("TEST_TMPDIR"), "actors.XXXXXX");
  EXPECT_NE(mkdtemp(path.data()), nullptr);
  return path;
}

ActorProcesses::Options Shell(const std::string& folder,
                              const std::string& script) {
  ActorProcesses::Options options;
  options.argv = {"/bin/sh", "-c", script, "actor", "{index}"};
  options.log_folder = folder;
  options.max_failures = 3;
  options.backoff.initial = absl::Milliseconds(1);
  options.backoff.longest = absl::Milliseconds(1);
  return options;
}

// For what processes do, which nothing announces.
bool Await(const std::function<bool()>& holds) {
  for (int i = 0; i < 60'000 && !holds(); ++i) {
    rpc::WaitFor(absl::Milliseconds(1), {});
  }
  return holds();
}

std::string Log(const std::string& folder, int index) {
  return ReadFile(JoinPath(folder, absl::StrCat("actor-", index, ".log")))
      .value_or("");
}

TEST(ActorProcessesTest, TellsEachItsNumberAndKeepsItsOutput) {
  const std::string folder = NewFolder();
  ActorProcesses::Options options = Shell(folder, "");
  options.argv[2] = "echo I am $1; exec tail -f /dev/null";
  options.count = 2;

  const auto actors = ActorProcesses::Start(options);
  ASSERT_THAT(actors, IsOk());

  EXPECT_TRUE(Await([&] { return Log(folder, 1) == "I am 1\n"; }));
  EXPECT_TRUE(Await([&] { return Log(folder, 0) == "I am 0\n"; }));
}

TEST(ActorProcessesTest, StartsAgainWhatWasKilled) {
  const std::string folder = NewFolder();
  const auto actors =
      ActorProcesses::Start(Shell(folder, "exec tail -f /dev/null"));
  ASSERT_THAT(actors, IsOk());
  const std::vector<pid_t> first = (*actors)->pids();
  ASSERT_EQ(first.size(), 1);

  kill(first[0], SIGKILL);

  EXPECT_TRUE(Await([&] {
    const std::vector<pid_t> now = (*actors)->pids();
    return now.size() == 1 && now[0] != first[0];
  }));
  EXPECT_THAT((*actors)->check(), IsOk());
  EXPECT_EQ((*actors)->restarts(), 1);
}

TEST(ActorProcessesTest, GivesUpOnWhatKeepsEndingAndShowsItsLastWords) {
  const std::string folder = NewFolder();
  const auto actors =
      ActorProcesses::Start(Shell(folder, "echo no such thing; exit 7"));
  ASSERT_THAT(actors, IsOk());

  EXPECT_TRUE(Await([&] { return !(*actors)->check().ok(); }));

  EXPECT_THAT(
      (*actors)->check(),
      StatusIs(absl::StatusCode::kUnavailable,
               AllOf(HasSubstr("actor 0 has ended 3 times"),
                     HasSubstr("exit code 7"), HasSubstr("no such thing"))));
}

TEST(ActorProcessesTest, EndsThemWithItself) {
  const std::string folder = NewFolder();
  std::vector<pid_t> pids;
  {
    const auto actors =
        ActorProcesses::Start(Shell(folder, "exec tail -f /dev/null"));
    ASSERT_THAT(actors, IsOk());
    pids = (*actors)->pids();
  }
  EXPECT_EQ(kill(pids.at(0), 0), -1);
}

TEST(ActorProcessesTest, NamesAProgramThatIsNotThere) {
  ActorProcesses::Options options = Shell(NewFolder(), "");
  options.argv = {"/no/such/program"};

  EXPECT_THAT(
      ActorProcesses::Start(options),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("/no/such/program")));
}

}  // namespace
}  // namespace sinew::tools
