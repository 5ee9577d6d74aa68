#include "tools/training/actor_processes.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "common/files.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "tools/training/process_cpu.h"

namespace sinew::tools {
namespace {

constexpr size_t kTailLines = 12;
// A wait of a watcher; it is ended by the process or by stop.
constexpr absl::Duration kLong = absl::Hours(24);

std::string Tail(const std::string& file) {
  const auto text = ReadFile(file);
  if (!text.ok()) return std::string(text.status().message());
  std::vector<std::string> lines =
      absl::StrSplit(*text, '\n', absl::SkipEmpty());
  if (lines.size() > kTailLines) {
    lines.erase(lines.begin(), lines.end() - kTailLines);
  }
  return absl::StrJoin(lines, "\n");
}

}  // namespace

ActorProcesses::ActorProcesses(Options options)
    : options_(std::move(options)) {}

absl::StatusOr<std::unique_ptr<ActorProcesses>> ActorProcesses::Start(
    Options options) {
  if (options.count < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("actors: expected >= 1, found ", options.count));
  }
  std::unique_ptr<ActorProcesses> result(
      new ActorProcesses(std::move(options)));
  const int count = result->options_.count;
  SINEW_RETURN_IF_ERROR(MakeDirectories(result->options_.log_folder));
  for (int i = 0; i < count; ++i) {
    SINEW_RETURN_IF_ERROR(WriteFileAtomically(result->LogFile(i), ""));
    SINEW_ASSIGN_OR_RETURN(std::unique_ptr<Subprocess> process,
                           result->StartOne(i));
    MutexLock lock(result->mu_);
    result->processes_.push_back(std::move(process));
  }
  for (int i = 0; i < count; ++i) {
    result->watchers_.emplace_back(
        [self = result.get(), i] { self->Watch(i); });
  }
  return result;
}

ActorProcesses::~ActorProcesses() { BeginStop(); }

std::string ActorProcesses::LogFile(int index) const {
  return JoinPath(options_.log_folder, absl::StrCat("actor-", index, ".log"));
}

absl::StatusOr<std::unique_ptr<Subprocess>> ActorProcesses::StartOne(
    int index) const {
  Subprocess::Options options;
  for (const std::string& argument : options_.argv) {
    options.argv.push_back(
        absl::StrReplaceAll(argument, {{"{index}", absl::StrCat(index)}}));
  }
  options.output_file = LogFile(index);
  options.grace = options_.grace;
  return Subprocess::Start(options);
}

void ActorProcesses::Watch(int index) {
  const std::stop_token stop = stop_.get_token();
  rpc::Backoff backoff(options_.backoff, static_cast<uint64_t>(index));
  int failures = 0;
  while (true) {
    Subprocess* process = nullptr;
    {
      MutexLock lock(mu_);
      process = processes_[index].get();
    }
    const auto start = std::chrono::steady_clock::now();
    absl::Status end;
    if (process != nullptr) {
      const auto status = process->Wait(kLong, stop);
      if (stop.stop_requested()) return;
      if (!status.ok()) continue;  // it runs on
      end = absl::UnavailableError(status->ToString());
      if (std::chrono::steady_clock::now() - start >
          absl::ToChronoNanoseconds(options_.stable_after)) {
        failures = 0;
        backoff.Reset();
      }
    }
    if (!MayRestart(index, end, ++failures)) return;
    if (!rpc::WaitFor(backoff.Next(), stop)) return;
    auto next = StartOne(index);
    if (!next.ok()) {
      LogError("an actor cannot be started",
               {{"actor", index}, {"error", next.status().message()}});
    }
    MutexLock lock(mu_);
    if (stop.stop_requested()) return;
    processes_[index] = next.ok() ? *std::move(next) : nullptr;
    ++restarts_;
  }
}

bool ActorProcesses::MayRestart(int index, const absl::Status& end,
                                int failures) {
  LogWarning("an actor has ended",
             {{"actor", index}, {"how", end.message()}, {"times", failures}});
  if (failures < options_.max_failures) return true;
  MutexLock lock(mu_);
  failure_.Update(absl::UnavailableError(
      absl::StrCat("actor ", index, " has ended ", failures,
                   " times, last with ", end.message(), "; the end of ",
                   LogFile(index), ":\n", Tail(LogFile(index)))));
  return false;
}

absl::Status ActorProcesses::check() const {
  MutexLock lock(mu_);
  return failure_;
}

int64_t ActorProcesses::restarts() const {
  MutexLock lock(mu_);
  return restarts_;
}

std::vector<pid_t> ActorProcesses::pids() const {
  MutexLock lock(mu_);
  std::vector<pid_t> result;
  for (const auto& process : processes_) {
    if (process == nullptr || process->exit_status()) continue;
    result.push_back(process->pid());
  }
  return result;
}

double ActorProcesses::CpuSeconds() const {
  double sum = 0;
  for (const pid_t pid : pids()) sum += ProcessCpuSeconds(pid);
  return sum;
}

void ActorProcesses::BeginStop() {
  stop_.request_stop();
  MutexLock lock(mu_);
  for (const auto& process : processes_) {
    if (process != nullptr) process->Signal(SIGTERM);
  }
}

}  // namespace sinew::tools
