#include "common/subprocess.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::Eq;
using ::testing::HasSubstr;

// Longer than any test may take: who waits this long hangs.
constexpr absl::Duration kHang = absl::Minutes(1);
// First argument of this program when it plays the parent in a test.
constexpr char kParentRole[] = "--start-a-child-and-wait";

std::unique_ptr<Subprocess> StartOrDie(Subprocess::Options options) {
  auto child = Subprocess::Start(options);
  EXPECT_THAT(child, IsOk());
  return *std::move(child);
}

std::unique_ptr<Subprocess> Shell(const std::string& script) {
  return StartOrDie({.argv = {"sh", "-c", script}});
}

std::string OutputPath() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string path =
      JoinPath(::testing::TempDir(),
               absl::StrCat("subprocess-", info->name(), "-", getpid()));
  EXPECT_THAT(RemoveRecursively(path), IsOk());
  return path;
}

// A fifo that children write to: tells without waiting for time when they say
// something, and when the last of them is gone.
class Fifo {
 public:
  Fifo() : path_(OutputPath()) {
    EXPECT_EQ(mkfifo(path_.c_str(), 0600), 0);
    fd_ = open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  ~Fifo() { close(fd_); }

  const std::string& path() const { return path_; }

  // False if nothing comes for too long.
  bool AwaitData() {
    pollfd event = {.fd = fd_, .events = POLLIN, .revents = 0};
    return poll(&event, 1, absl::ToInt64Milliseconds(kHang)) == 1;
  }

  // True once all writers have ended.
  bool AwaitEnd() {
    std::array<char, 64> bytes;
    while (AwaitData()) {
      if (read(fd_, bytes.data(), bytes.size()) <= 0) return true;
    }
    return false;
  }

 private:
  const std::string path_;
  int fd_ = -1;
};

// What a child with these options prints.
std::string OutputOf(Subprocess::Options options) {
  options.output_file = OutputPath();
  EXPECT_THAT(StartOrDie(options)->Wait(kHang), IsOk());
  auto output = ReadFile(options.output_file);
  EXPECT_THAT(output, IsOk());
  return *std::move(output);
}

TEST(Subprocess, ReportsTheExitCode) {
  const auto status = Shell("exit 7")->Wait(kHang);

  ASSERT_THAT(status, IsOk());
  EXPECT_EQ(status->code, 7);
  EXPECT_EQ(status->signal, 0);
  EXPECT_FALSE(status->ok());
  EXPECT_EQ(status->ToString(), "exit code 7");
}

TEST(Subprocess, ReportsTheSignal) {
  const auto status = Shell("kill -9 $$")->Wait(kHang);

  ASSERT_THAT(status, IsOk());
  EXPECT_EQ(status->signal, SIGKILL);
  EXPECT_EQ(status->ToString(), "killed by signal 9 (Killed)");
}

TEST(Subprocess, NamesTheProgramThatIsMissing) {
  EXPECT_THAT(Subprocess::Start({.argv = {"/nowhere/program"}}),
              StatusIs(absl::StatusCode::kNotFound,
                       AllOf(HasSubstr("/nowhere/program"),
                             HasSubstr("No such file or directory"))));
}

TEST(Subprocess, NamesTheFolderAndTheOutputFileThatAreMissing) {
  EXPECT_THAT(
      Subprocess::Start({.argv = {"true"}, .working_directory = "/nowhere"}),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("folder /nowhere")));
  EXPECT_THAT(
      Subprocess::Start({.argv = {"true"}, .output_file = "/nowhere/log"}),
      StatusIs(absl::StatusCode::kNotFound,
               HasSubstr("output file /nowhere/log")));
}

TEST(Subprocess, NeedsAProgram) {
  EXPECT_THAT(Subprocess::Start({}),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST(Subprocess, PassesArgumentsEnvironmentAndFolder) {
  const std::string output = OutputOf({
      .argv = {"sh", "-c", "echo \"$1|$COLOUR|$PWD\" >&2", "sh", "a b"},
      .environment = {{"COLOUR", "blue"}},
      .working_directory = "/usr",
  });

  EXPECT_EQ(output, "a b|blue|/usr\n");
}

TEST(Subprocess, StartsWithClosedDescriptorsAndEmptyInput) {
  // Without O_CLOEXEC: the child would inherit it.
  const int leak = open("/dev/null", O_RDONLY);

  const std::string output =
      OutputOf({.argv = {"sh", "-c",
                         absl::StrCat("cat; test -e /proc/$$/fd/", leak,
                                      " && echo open || echo closed")}});
  close(leak);

  EXPECT_EQ(output, "closed\n");
}

TEST(Subprocess, StopsWaitingAtTheDeadlineAndAtAStop) {
  const auto child = StartOrDie({.argv = {"sleep", "1000"}});
  std::stop_source stop;
  stop.request_stop();

  EXPECT_THAT(child->Wait(absl::ZeroDuration()),
              StatusIs(absl::StatusCode::kDeadlineExceeded,
                       HasSubstr("sleep (process")));
  EXPECT_THAT(child->Wait(kHang, stop.get_token()),
              StatusIs(absl::StatusCode::kCancelled));
  EXPECT_FALSE(child->exit_status().has_value());
}

TEST(Subprocess, TerminatesAChildThatListens) {
  const auto child = StartOrDie({.argv = {"sleep", "1000"}});

  EXPECT_EQ(child->Terminate(kHang).signal, SIGTERM);
  EXPECT_TRUE(child->exit_status().has_value());
}

TEST(Subprocess, KillsAChildThatDoesNotListenAndWhatItStarted) {
  Fifo output;
  const auto child = StartOrDie({.argv = {"sh", "-c",
                                          "trap '' TERM; echo deaf; "
                                          "while :; do sleep 1000; done"},
                                 .output_file = output.path()});
  ASSERT_TRUE(output.AwaitData());

  EXPECT_EQ(child->Terminate(absl::Milliseconds(1)).signal, SIGKILL);

  EXPECT_TRUE(output.AwaitEnd());
}

TEST(Subprocess, IgnoresSignalsToAChildThatHasEnded) {
  const auto child = Shell("exit 0");
  ASSERT_THAT(child->Wait(kHang), IsOk());

  child->Signal(SIGKILL);

  EXPECT_TRUE(child->Terminate(absl::ZeroDuration()).ok());
}

TEST(Subprocess, EndsWithItsOwner) {
  pid_t pid = 0;
  {
    const auto child = StartOrDie({.argv = {"sleep", "1000"}});
    pid = child->pid();
    EXPECT_EQ(kill(pid, 0), 0);
  }

  EXPECT_NE(kill(pid, 0), 0);
}

TEST(Subprocess, DiesWhenItsParentIsKilled) {
  Fifo output;
  const auto parent = StartOrDie(
      {.argv = {"/proc/self/exe", kParentRole}, .output_file = output.path()});
  ASSERT_TRUE(output.AwaitData());

  kill(parent->pid(), SIGKILL);

  EXPECT_TRUE(output.AwaitEnd());
}

// The parent of DiesWhenItsParentIsKilled: its child says on the inherited
// standard output that it runs.
int PlayParent() {
  const auto child = Subprocess::Start(
      {.argv = {"sh", "-c", "trap '' TERM INT HUP; echo up; exec sleep 1000"}});
  if (!child.ok()) return EXIT_FAILURE;
  return (*child)->Wait(absl::Hours(1)).ok() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  ::testing::InitGoogleMock(&argc, argv);
  if (argc > 1 && std::string(argv[1]) == sinew::kParentRole) {
    return sinew::PlayParent();
  }
  return RUN_ALL_TESTS();
}
