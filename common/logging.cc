#include "common/logging.h"

#include <exception>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/mutex.h"
#include "common/status_macros.h"
#include "nlohmann/json.hpp"
#include "spdlog/logger.h"
#include "spdlog/sinks/rotating_file_sink.h"
#include "spdlog/sinks/stdout_sinks.h"

namespace sinew {
namespace {

struct LevelNames {
  const char* text;
  const char* json;
};

LevelNames NamesOf(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return {"DEBUG", "debug"};
    case LogLevel::kInfo:
      return {"INFO", "info"};
    case LogLevel::kWarning:
      return {"WARNING", "warning"};
    case LogLevel::kError:
      return {"ERROR", "error"};
  }
  return {"?", "?"};
}

// One event with everything that either format shows.
struct Event {
  std::string time;
  LogLevel level;
  absl::string_view role;
  absl::string_view message;
  absl::Span<const LogField> fields;
};

bool NeedsQuotes(absl::string_view text) {
  if (text.empty()) return true;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte <= ' ' || byte == 0x7f || c == '"' || c == '=') return true;
  }
  return false;
}

std::string TextOf(const LogValue& value) {
  return std::visit(
      [](const auto& held) -> std::string {
        using T = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<T, bool>) {
          return held ? "true" : "false";
        } else if constexpr (std::is_same_v<T, absl::string_view>) {
          if (!NeedsQuotes(held)) return std::string(held);
          return absl::StrCat("\"", absl::Utf8SafeCEscape(held), "\"");
        } else {
          return absl::StrCat(held);
        }
      },
      value.value());
}

// A peer's message cannot break a line or steer a terminal.
std::string OnOneLine(absl::string_view text) {
  std::string line;
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) {
      absl::StrAppend(&line, absl::CEscape(absl::string_view(&c, 1)));
    } else {
      line.push_back(c);
    }
  }
  return line;
}

std::string TextLine(const Event& event) {
  std::string line = absl::StrCat(event.time, " ", NamesOf(event.level).text);
  if (!event.role.empty()) absl::StrAppend(&line, " ", event.role);
  absl::StrAppend(&line, ": ", OnOneLine(event.message));
  for (const LogField& field : event.fields) {
    absl::StrAppend(&line, " ", field.key, "=", TextOf(field.value));
  }
  return line;
}

std::string JsonLine(const Event& event) {
  nlohmann::ordered_json line;
  line["time"] = event.time;
  line["level"] = NamesOf(event.level).json;
  if (!event.role.empty()) line["role"] = std::string(event.role);
  line["message"] = std::string(event.message);
  for (const LogField& field : event.fields) {
    std::visit(
        [&line, &field](const auto& held) {
          using T = std::decay_t<decltype(held)>;
          if constexpr (std::is_same_v<T, absl::string_view>) {
            line[std::string(field.key)] = std::string(held);
          } else {
            line[std::string(field.key)] = held;
          }
        },
        field.value.value());
  }
  // Bytes that are not UTF-8 become replacement characters.
  return line.dump(/*indent=*/-1, ' ', /*ensure_ascii=*/false,
                   nlohmann::ordered_json::error_handler_t::replace);
}

std::shared_ptr<spdlog::logger> LoggerOf(
    std::shared_ptr<spdlog::sinks::sink> sink) {
  auto logger = std::make_shared<spdlog::logger>("sinew", std::move(sink));
  // Levels and layout are ours.
  logger->set_level(spdlog::level::trace);
  logger->set_pattern("%v");
  logger->flush_on(spdlog::level::trace);
  return logger;
}

absl::StatusOr<std::shared_ptr<spdlog::logger>> OpenFile(
    const Logger::Options& options) {
  // Where that fails it says why better than spdlog does.
  SINEW_RETURN_IF_ERROR(AppendToFile(options.file, ""));
  try {
    return LoggerOf(std::make_shared<spdlog::sinks::rotating_file_sink_mt>(
        options.file, options.max_file_bytes, options.max_old_files));
  } catch (const std::exception& error) {
    return absl::InternalError(
        absl::StrCat("cannot log to ", options.file, ": ", error.what()));
  }
}

void WriteTo(spdlog::logger& log, absl::string_view line) {
  log.log(spdlog::level::info, spdlog::string_view_t(line.data(), line.size()));
}

struct ProgramLoggerHolder {
  Mutex mu;
  std::shared_ptr<Logger> logger SINEW_GUARDED_BY(mu);
};

// Never destroyed: threads may log while the program ends.
ProgramLoggerHolder& Holder() {
  static auto* const holder = new ProgramLoggerHolder;
  return *holder;
}

std::shared_ptr<Logger> MakeDefaultLogger() {
  static const auto* const clock = new SystemClock;
  // Cannot fail without a file.
  return *Logger::Create(Logger::Options(), *clock);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Logger>> Logger::Create(const Options& options,
                                                       const Clock& clock) {
  std::shared_ptr<spdlog::logger> file_log;
  if (!options.file.empty()) {
    SINEW_ASSIGN_OR_RETURN(file_log, OpenFile(options));
  }
  return std::unique_ptr<Logger>(new Logger(
      options, clock,
      LoggerOf(std::make_shared<spdlog::sinks::stderr_sink_mt>()), file_log));
}

Logger::Logger(const Options& options, const Clock& clock,
               std::shared_ptr<spdlog::logger> stderr_log,
               std::shared_ptr<spdlog::logger> file_log)
    : options_(options),
      clock_(clock),
      stderr_log_(std::move(stderr_log)),
      file_log_(std::move(file_log)) {}

Logger::~Logger() = default;

void Logger::Write(LogLevel level, absl::string_view message,
                   absl::Span<const LogField> fields) {
  if (!enabled(level)) return;
  const Event event = {
      .time = absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", clock_.WallNow(),
                               absl::UTCTimeZone()),
      .level = level,
      .role = options_.role,
      .message = message,
      .fields = fields,
  };
  if (file_log_ != nullptr) WriteTo(*file_log_, JsonLine(event));
  const std::string line =
      options_.format == Format::kText ? TextLine(event) : JsonLine(event);
  MutexLock lock(mu_);
  if (console_ != nullptr) {
    console_(line);
  } else {
    WriteTo(*stderr_log_, line);
  }
}

void Logger::SetConsole(Console console) {
  MutexLock lock(mu_);
  console_ = std::move(console);
}

void SetProgramLogger(std::shared_ptr<Logger> logger) {
  ProgramLoggerHolder& holder = Holder();
  MutexLock lock(holder.mu);
  holder.logger = std::move(logger);
}

std::shared_ptr<Logger> ProgramLogger() {
  ProgramLoggerHolder& holder = Holder();
  MutexLock lock(holder.mu);
  if (holder.logger == nullptr) holder.logger = MakeDefaultLogger();
  return holder.logger;
}

void LogDebug(absl::string_view message, LogFields fields) {
  ProgramLogger()->Log(LogLevel::kDebug, message, fields);
}

void LogInfo(absl::string_view message, LogFields fields) {
  ProgramLogger()->Log(LogLevel::kInfo, message, fields);
}

void LogWarning(absl::string_view message, LogFields fields) {
  ProgramLogger()->Log(LogLevel::kWarning, message, fields);
}

void LogError(absl::string_view message, LogFields fields) {
  ProgramLogger()->Log(LogLevel::kError, message, fields);
}

}  // namespace sinew
