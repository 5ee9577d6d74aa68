#ifndef SINEW_COMMON_LOGGING_H_
#define SINEW_COMMON_LOGGING_H_

#include <concepts>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "common/mutex.h"

namespace spdlog {
class logger;
}  // namespace spdlog

namespace sinew {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

// One structured value beside a message; text is borrowed for the call.
class LogValue {
 public:
  using Variant =
      std::variant<bool, int64_t, uint64_t, double, absl::string_view>;

  // NOLINTBEGIN(google-explicit-constructor): log("x", {{"key", 3}}).
  LogValue(bool value) : value_(value) {}
  template <std::signed_integral T>
  LogValue(T value) : value_(static_cast<int64_t>(value)) {}
  template <std::unsigned_integral T>
    requires(!std::same_as<T, bool>)
  LogValue(T value) : value_(static_cast<uint64_t>(value)) {}
  template <std::floating_point T>
  LogValue(T value) : value_(static_cast<double>(value)) {}
  LogValue(const char* value) : value_(absl::string_view(value)) {}
  LogValue(absl::string_view value) : value_(value) {}
  LogValue(const std::string& value) : value_(absl::string_view(value)) {}
  // NOLINTEND

  const Variant& value() const { return value_; }

 private:
  Variant value_;
};

// A key is lower_snake_case with its unit, and none of time, level, role,
// message.
struct LogField {
  absl::string_view key;
  LogValue value;
};
using LogFields = std::initializer_list<LogField>;

// Writes one line per event, levelled and structured:
//
//   2026-03-01T12:00:00.000Z INFO learner: snapshot published version=41
//   {"time":"2026-03-01T12:00:00.000Z","level":"info","role":"learner",
//    "message":"snapshot published","version":41}          (on one line)
//
// to stderr (or the console writer) and optionally to a file that is rotated,
// so that logs are bounded. Not for hot loops; where an outside event could
// repeat quickly, use rate_limited_log.h.
//
// Thread-safety: yes, lines are never mixed. Ownership: borrows the clock.
// Blocking: as long as stderr and the disk do. Errors: Create; later ones
// (disk full) are reported on stderr once a second at most, never thrown.
class Logger {
 public:
  enum class Format { kText, kJson };
  // Takes a finished line without its end; e.g. a progress bar that makes room
  // for it. Called by one thread at a time.
  using Console = std::function<void(absl::string_view line)>;

  struct Options {
    // Lower levels are dropped.
    LogLevel level = LogLevel::kInfo;
    // Of the console; files are always JSON lines.
    Format format = Format::kText;
    // "learner", "actor" ...; empty: left out.
    std::string role = {};
    // JSON lines are appended here; empty: no file.
    std::string file = {};
    // A file of this many bytes is renamed to NAME.1.EXT and so on; the
    // oldest is removed.
    int64_t max_file_bytes = int64_t{16} << 20;
    int max_old_files = 3;
  };

  // PERMISSION_DENIED ...: the file cannot be opened (named, with the reason).
  static absl::StatusOr<std::unique_ptr<Logger>> Create(const Options& options,
                                                        const Clock& clock);
  ~Logger();
  Logger(const Logger&) = delete;
  Logger& operator=(const Logger&) = delete;

  void Log(LogLevel level, absl::string_view message, LogFields fields = {}) {
    Write(level, message, absl::MakeConstSpan(fields.begin(), fields.size()));
  }
  // The same with fields that were collected at run time.
  void Write(LogLevel level, absl::string_view message,
             absl::Span<const LogField> fields) SINEW_EXCLUDES(mu_);
  bool enabled(LogLevel level) const { return level >= options_.level; }

  // Where lines for people go; unset: stderr.
  void SetConsole(Console console) SINEW_EXCLUDES(mu_);

 private:
  Logger(const Options& options, const Clock& clock,
         std::shared_ptr<spdlog::logger> stderr_log,
         std::shared_ptr<spdlog::logger> file_log);

  const Options options_;
  const Clock& clock_;
  const std::shared_ptr<spdlog::logger> stderr_log_;
  // Null without a file.
  const std::shared_ptr<spdlog::logger> file_log_;

  Mutex mu_;
  Console console_ SINEW_GUARDED_BY(mu_);
};

// The program's logger. Until main sets one, lines of level info and above go
// to stderr as text.
void SetProgramLogger(std::shared_ptr<Logger> logger);
std::shared_ptr<Logger> ProgramLogger();

// Through the program's logger.
void LogDebug(absl::string_view message, LogFields fields = {});
void LogInfo(absl::string_view message, LogFields fields = {});
void LogWarning(absl::string_view message, LogFields fields = {});
void LogError(absl::string_view message, LogFields fields = {});

}  // namespace sinew

#endif  // SINEW_COMMON_LOGGING_H_
