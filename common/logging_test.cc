#include "common/logging.h"

#include <unistd.h>

#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/time.h"
#include "common/files.h"
#include "common/rate_limited_log.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::SimulatedClock;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// 2026-03-01 12:00:00 UTC.
constexpr int64_t kNoon = 1772366400;

// A logger whose console lines are kept.
class Recorder {
 public:
  explicit Recorder(Logger::Options options = {})
      : clock_(absl::FromUnixSeconds(kNoon)) {
    auto logger = Logger::Create(options, clock_);
    EXPECT_THAT(logger, IsOk());
    logger_ = *std::move(logger);
    logger_->SetConsole(
        [this](absl::string_view line) { lines_.emplace_back(line); });
  }

  Logger& logger() { return *logger_; }
  SimulatedClock& clock() { return clock_; }
  const std::vector<std::string>& lines() const { return lines_; }

 private:
  SimulatedClock clock_;
  std::vector<std::string> lines_;
  std::unique_ptr<Logger> logger_;
};

std::string LogPath() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string folder = JoinPath(
      ::testing::TempDir(), absl::StrCat("log-", info->name(), "-", getpid()));
  EXPECT_THAT(RemoveRecursively(folder), IsOk());
  EXPECT_THAT(MakeDirectories(folder), IsOk());
  return JoinPath(folder, "role.log");
}

TEST(Logger, WritesTextWithKeysAndValues) {
  Recorder recorder({.role = "learner"});

  recorder.logger().Log(LogLevel::kInfo, "snapshot published",
                        {{"version", 41}, {"seconds", 0.5}, {"best", true}});

  EXPECT_THAT(recorder.lines(),
              ElementsAre("2026-03-01T12:00:00.000Z INFO learner: snapshot "
                          "published version=41 seconds=0.5 best=true"));
}

TEST(Logger, QuotesTextThatWouldNotReadBack) {
  Recorder recorder;

  recorder.logger().Log(
      LogLevel::kWarning, "refused",
      {{"peer", "a b"}, {"why", "said \"no\"\n"}, {"note", ""}, {"ok", "x-1"}});

  EXPECT_THAT(recorder.lines(),
              ElementsAre(EndsWith(" WARNING: refused peer=\"a b\" why=\"said "
                                   "\\\"no\\\"\\n\" note=\"\" ok=x-1")));
}

TEST(Logger, KeepsAMessageOnOneLine) {
  Recorder recorder;

  recorder.logger().Log(LogLevel::kInfo, "it's\n\x1b[2Jhere");

  EXPECT_THAT(recorder.lines(),
              ElementsAre(EndsWith("INFO: it's\\n\\033[2Jhere")));
}

TEST(Logger, WritesJsonThatParses) {
  Recorder recorder({.format = Logger::Format::kJson, .role = "actor"});

  recorder.logger().Log(
      LogLevel::kError, "bad \"bytes\" \xff",
      {{"count", std::numeric_limits<uint64_t>::max()}, {"loss", 0.25}});

  ASSERT_THAT(recorder.lines(), SizeIs(1));
  const auto line = nlohmann::json::parse(recorder.lines()[0]);
  EXPECT_EQ(line["time"], "2026-03-01T12:00:00.000Z");
  EXPECT_EQ(line["level"], "error");
  EXPECT_EQ(line["role"], "actor");
  EXPECT_EQ(line["message"], "bad \"bytes\" \xef\xbf\xbd");
  EXPECT_EQ(line["count"], std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(line["loss"], 0.25);
}

TEST(Logger, DropsLevelsBelowItsOwn) {
  Recorder recorder({.level = LogLevel::kWarning});

  recorder.logger().Log(LogLevel::kInfo, "quiet");
  recorder.logger().Log(LogLevel::kWarning, "loud");

  EXPECT_THAT(recorder.lines(), ElementsAre(HasSubstr("loud")));
}

TEST(Logger, AppendsJsonLinesToItsFile) {
  const std::string path = LogPath();

  for (const char* message : {"one", "two"}) {
    Recorder recorder({.file = path});
    recorder.logger().Log(LogLevel::kInfo, message);
  }

  EXPECT_THAT(ReadFile(path),
              IsOkAndHolds("{\"time\":\"2026-03-01T12:00:00.000Z\",\"level\":"
                           "\"info\",\"message\":\"one\"}\n"
                           "{\"time\":\"2026-03-01T12:00:00.000Z\",\"level\":"
                           "\"info\",\"message\":\"two\"}\n"));
}

TEST(Logger, BoundsItsFiles) {
  const std::string path = LogPath();
  Recorder recorder({.file = path, .max_file_bytes = 1000, .max_old_files = 2});

  for (int i = 0; i < 100; ++i) {
    recorder.logger().Log(LogLevel::kInfo, std::string(100, 'x'));
  }

  const std::string folder = path.substr(0, path.rfind('/'));
  const auto names = ListDirectory(folder);
  EXPECT_THAT(names, IsOkAndHolds(SizeIs(3)));
  for (const std::string& name : *names) {
    const auto size = FileSize(JoinPath(folder, name));
    ASSERT_THAT(size, IsOk());
    EXPECT_LE(*size, 1000);
  }
}

TEST(Logger, NamesTheFileThatCannotBeOpened) {
  const SimulatedClock clock;

  EXPECT_THAT(
      Logger::Create({.file = "/nowhere/role.log"}, clock),
      StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere/role.log")));
}

TEST(Logger, NeverMixesLinesOfSeveralThreads) {
  const std::string path = LogPath();
  Recorder recorder({.file = path});
  std::vector<std::thread> threads;

  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&recorder] {
      for (int i = 0; i < 50; ++i) {
        recorder.logger().Log(LogLevel::kInfo, std::string(50, 'x'));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();

  EXPECT_THAT(recorder.lines(), SizeIs(200));
  const std::vector<std::string> lines =
      absl::StrSplit(*ReadFile(path), '\n', absl::SkipEmpty());
  EXPECT_THAT(lines, SizeIs(200));
  for (const std::string& line : lines) EXPECT_EQ(line, lines[0]);
}

TEST(ProgramLogger, IsWhatMainSet) {
  const SimulatedClock clock(absl::FromUnixSeconds(kNoon));
  std::vector<std::string> lines;
  auto logger = Logger::Create({}, clock);
  ASSERT_THAT(logger, IsOk());
  (*logger)->SetConsole(
      [&lines](absl::string_view line) { lines.emplace_back(line); });

  SetProgramLogger(*std::move(logger));
  LogDebug("one");
  LogInfo("two");
  LogWarning("three");
  LogError("four");
  SetProgramLogger(nullptr);

  EXPECT_THAT(lines,
              ElementsAre(HasSubstr("INFO: two"), HasSubstr("WARNING: three"),
                          HasSubstr("ERROR: four")));
}

TEST(ProgramLogger, WritesToStandardErrorUntilMainSetsOne) {
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();

  LogInfo("hello", {{"n", 3}});

  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              EndsWith(" INFO: hello n=3\n"));
  EXPECT_THAT(::testing::internal::GetCapturedStdout(), IsEmpty());
}

TEST(RateLimitedLog, PassesOneLinePerPeriodAndCountsTheRest) {
  Recorder recorder;
  RateLimitedLog log(recorder.logger(), LogLevel::kWarning, absl::Seconds(10),
                     recorder.clock());

  for (int i = 0; i < 5; ++i) log.Log("segment refused", {{"order", i}});
  recorder.clock().Advance(absl::Seconds(10));
  for (int i = 5; i < 7; ++i) log.Log("segment refused", {{"order", i}});

  EXPECT_THAT(
      recorder.lines(),
      ElementsAre(EndsWith("WARNING: segment refused order=0"),
                  EndsWith("WARNING: segment refused order=5 suppressed=4")));
}

}  // namespace
}  // namespace sinew
