#include "common/subprocess.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/check.h"
#include "common/mutex.h"
#include "common/stop.h"

namespace sinew {
namespace {

// What a child tells its parent when it cannot become the program.
enum class Step { kFork, kParent, kFolder, kOutput, kProgram };
struct Failure {
  Step step;
  int error;
};

std::vector<char*> Pointers(std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  for (std::string& text : strings) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// This process' environment with `added` on top, as NAME=VALUE.
std::vector<std::string> Environment(
    const std::map<std::string, std::string>& added) {
  std::vector<std::string> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (!added.contains(text.substr(0, text.find('=')))) all.push_back(text);
  }
  for (const auto& [name, value] : added) {
    all.push_back(absl::StrCat(name, "=", value));
  }
  return all;
}

void ResetSignals() {
  for (int signal = 1; signal < NSIG; ++signal) ::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

bool RedirectOutput(const std::string& path) {
  const int fd = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC,
                      S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
  return fd >= 0 && dup2(fd, STDOUT_FILENO) >= 0 &&
         dup2(fd, STDERR_FILENO) >= 0;
}

}  // namespace

// Everything the child needs, made before the fork: between fork and exec only
// async-signal-safe calls are allowed, no allocation among them.
struct Subprocess::Launch {
  explicit Launch(const Options& from)
      : options(from),
        argument_texts(from.argv),
        environment_texts(Environment(from.environment)),
        argv(Pointers(argument_texts)),
        environment(Pointers(environment_texts)) {}

  // Runs in the child; returns only what went wrong.
  Failure BecomeProgram() const;
  // Starts the child; OK once it executes the program.
  absl::Status Fork(pid_t& pid) const;
  absl::Status Error(const Failure& failure) const;

  const Options& options;
  std::vector<std::string> argument_texts;
  std::vector<std::string> environment_texts;
  const std::vector<char*> argv;
  const std::vector<char*> environment;
  const pid_t parent = getpid();
  absl::Status status;
};

Failure Subprocess::Launch::BecomeProgram() const {
  if (!DieWithParent(options.parent_death_signal, parent)) {
    return {Step::kParent, ECHILD};
  }
  if (options.own_process_group) setpgid(0, 0);
  ResetSignals();
  const std::string& folder = options.working_directory;
  if (!folder.empty() && chdir(folder.c_str()) != 0) {
    return {Step::kFolder, errno};
  }
  const int empty = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (empty >= 0) dup2(empty, STDIN_FILENO);
  if (!options.output_file.empty() && !RedirectOutput(options.output_file)) {
    return {Step::kOutput, errno};
  }
  // Libraries do not all open their descriptors with O_CLOEXEC.
  close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
  execvpe(argv[0], argv.data(), environment.data());
  return {Step::kProgram, errno};
}

std::string ExitStatus::ToString() const {
  if (signal == 0) return absl::StrCat("exit code ", code);
  return absl::StrCat("killed by signal ", signal, " (", strsignal(signal),
                      ")");
}

absl::StatusOr<std::unique_ptr<Subprocess>> Subprocess::Start(
    const Options& options) {
  if (options.argv.empty() || options.argv[0].empty()) {
    return absl::InvalidArgumentError("subprocess: argv names no program");
  }
  std::unique_ptr<Subprocess> child(new Subprocess(options));
  Launch launch(options);
  // The kernel's death signal is bound to the thread that forks, so the thread
  // that forks is the one that lives until the child is reaped.
  child->thread_ =
      std::thread([child = child.get(), &launch] { child->Run(launch); });
  {
    MutexLock lock(child->mu_);
    while (!child->launched_) child->changed_.Wait(child->mu_, {});
  }
  if (!launch.status.ok()) return launch.status;
  return child;
}

Subprocess::Subprocess(const Options& options)
    : name_(options.argv[0]),
      grace_(options.grace),
      own_process_group_(options.own_process_group) {}

Subprocess::~Subprocess() {
  if (pid_ > 0) Terminate(grace_);
  thread_.join();
}

absl::Status Subprocess::Launch::Fork(pid_t& pid) const {
  std::array<int, 2> fds;
  if (pipe2(fds.data(), O_CLOEXEC) != 0) return Error({Step::kFork, errno});
  pid = fork();
  Failure failure = {Step::kFork, errno};
  if (pid == 0) {
    failure = BecomeProgram();
    [[maybe_unused]] const ssize_t written =
        write(fds[1], &failure, sizeof(failure));
    _exit(EXIT_FAILURE);
  }
  close(fds[1]);
  // The end of the pipe without a failure: exec has closed it.
  ssize_t got = sizeof(failure);
  if (pid > 0) {
    do {
      got = read(fds[0], &failure, sizeof(failure));
    } while (got < 0 && errno == EINTR);
  }
  close(fds[0]);
  if (got != sizeof(failure)) return absl::OkStatus();
  if (pid > 0) waitpid(pid, nullptr, 0);
  return Error(failure);
}

absl::Status Subprocess::Launch::Error(const Failure& failure) const {
  std::string at;
  if (failure.step == Step::kFolder) {
    at = absl::StrCat("folder ", options.working_directory, ": ");
  } else if (failure.step == Step::kOutput) {
    at = absl::StrCat("output file ", options.output_file, ": ");
  } else if (failure.step == Step::kParent) {
    at = "its parent is gone: ";
  }
  return absl::Status(
      absl::ErrnoToStatusCode(failure.error),
      absl::StrCat("cannot start ", options.argv[0], ": ", at,
                   std::generic_category().message(failure.error)));
}

void Subprocess::Run(Launch& launch) {
  pid_t pid = -1;
  launch.status = launch.Fork(pid);
  const bool started = launch.status.ok();
  if (started) pid_ = pid;
  {
    // From here on Start may return, and `launch` is gone.
    MutexLock lock(mu_);
    launched_ = true;
    changed_.NotifyAll();
  }
  if (started) Reap();
}

void Subprocess::Reap() {
  siginfo_t info;
  // Leaves the zombie, so that the process id stays ours until it is marked.
  while (waitid(P_PID, pid_, &info, WEXITED | WNOWAIT) != 0) {
    SINEW_CHECK(errno == EINTR) << name_ << ": errno " << errno;
  }
  MutexLock lock(mu_);
  // What it left behind goes with it.
  if (own_process_group_) kill(-pid_, SIGKILL);
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0) {
    SINEW_CHECK(errno == EINTR) << name_ << ": errno " << errno;
  }
  exit_status_ = WIFSIGNALED(status)
                     ? ExitStatus{.code = 0, .signal = WTERMSIG(status)}
                     : ExitStatus{.code = WEXITSTATUS(status), .signal = 0};
  changed_.NotifyAll();
}

std::optional<ExitStatus> Subprocess::exit_status() const {
  MutexLock lock(mu_);
  return exit_status_;
}

absl::StatusOr<ExitStatus> Subprocess::Wait(absl::Duration timeout,
                                            const std::stop_token& stop) {
  const auto deadline =
      std::chrono::steady_clock::now() +
      absl::ToChronoNanoseconds(std::min(timeout, absl::Hours(24)));
  MutexLock lock(mu_);
  while (!exit_status_.has_value()) {
    if (!changed_.WaitUntil(mu_, deadline, stop)) break;
  }
  if (exit_status_.has_value()) return *exit_status_;
  if (stop.stop_requested()) {
    return absl::CancelledError(
        absl::StrCat("stopped waiting for ", name_, " (process ", pid_, ")"));
  }
  return absl::DeadlineExceededError(
      absl::StrCat(name_, " (process ", pid_, ") still runs after ",
                   absl::FormatDuration(timeout)));
}

void Subprocess::Signal(int signal) {
  MutexLock lock(mu_);
  if (exit_status_.has_value()) return;
  kill(own_process_group_ ? -pid_ : pid_, signal);
}

ExitStatus Subprocess::Terminate(absl::Duration grace) {
  Signal(SIGTERM);
  const absl::StatusOr<ExitStatus> in_order = Wait(grace);
  if (in_order.ok()) return *in_order;
  Signal(SIGKILL);
  MutexLock lock(mu_);
  // Nothing survives SIGKILL, so this wait ends.
  while (!exit_status_.has_value()) changed_.Wait(mu_, {});
  return *exit_status_;
}

}  // namespace sinew
