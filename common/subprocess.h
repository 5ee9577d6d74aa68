#ifndef SINEW_COMMON_SUBPROCESS_H_
#define SINEW_COMMON_SUBPROCESS_H_

#include <sys/types.h>

#include <csignal>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/mutex.h"

namespace sinew {

// How a process ended.
struct ExitStatus {
  // Exit code; meaningful if signal is 0.
  int code = 0;
  // Signal that killed it, or 0.
  int signal = 0;

  bool ok() const { return code == 0 && signal == 0; }
  // "exit code 2", "killed by signal 9 (Killed)".
  std::string ToString() const;
};

// A child process that cannot outlive its owner: it dies with this object, and
// the kernel kills it should this process die, however that happens.
//
//   SINEW_ASSIGN_OR_RETURN(auto child, Subprocess::Start({.argv = {...}}));
//   ... child->Terminate(absl::Seconds(5)) ...
//
// Thread-safety: yes. Ownership: owns the child and one thread that waits for
//   it. Blocking: Wait, Terminate and the destructor, as said. Errors: Start
//   and Wait.
class Subprocess {
 public:
  struct Options {
    // Program (looked up in PATH unless it has a slash) and arguments; not
    // empty.
    std::vector<std::string> argv;
    // Variables on top of this process' environment.
    std::map<std::string, std::string> environment = {};
    // Where it runs; empty: here.
    std::string working_directory = {};
    // File that its stdout and stderr are appended to; empty: this process'.
    std::string output_file = {};
    // True: a process group of its own: Ctrl-C in a terminal reaches only this
    // process, which ends its children in order, and signals that are sent to
    // the child reach what it started, too.
    bool own_process_group = true;
    // What the kernel sends to it when this process dies.
    int parent_death_signal = SIGKILL;
    // Patience of the destructor between SIGTERM and SIGKILL.
    absl::Duration grace = absl::Seconds(5);
  };

  // Standard input is empty, descriptors above 2 are closed, signals are as
  // at start-up. NOT_FOUND, PERMISSION_DENIED ...: naming the program (or
  // folder, or file) and the reason.
  static absl::StatusOr<std::unique_ptr<Subprocess>> Start(
      const Options& options);

  // Terminates, waits `grace`, kills.
  ~Subprocess();
  Subprocess(const Subprocess&) = delete;
  Subprocess& operator=(const Subprocess&) = delete;

  pid_t pid() const { return pid_; }

  // Unset while it runs.
  std::optional<ExitStatus> exit_status() const SINEW_EXCLUDES(mu_);

  // Waits for its end. DEADLINE_EXCEEDED, CANCELLED (stop was requested):
  // naming the program; it runs on.
  absl::StatusOr<ExitStatus> Wait(absl::Duration timeout,
                                  const std::stop_token& stop = {})
      SINEW_EXCLUDES(mu_);

  // Sends a signal, unless it has ended.
  void Signal(int signal) SINEW_EXCLUDES(mu_);

  // SIGTERM, then SIGKILL if it has not ended after `grace`. Returns how it
  // ended. Blocks at most `grace` and the kernel's time to kill.
  ExitStatus Terminate(absl::Duration grace) SINEW_EXCLUDES(mu_);

 private:
  struct Launch;

  explicit Subprocess(const Options& options);
  // The thread: starts the child, reports through `launch`, reaps it.
  void Run(Launch& launch) SINEW_EXCLUDES(mu_);
  void Reap() SINEW_EXCLUDES(mu_);

  const std::string name_;
  const absl::Duration grace_;
  const bool own_process_group_;
  // Set before Start returns.
  pid_t pid_ = -1;

  mutable Mutex mu_;
  CondVar changed_;
  bool launched_ SINEW_GUARDED_BY(mu_) = false;
  std::optional<ExitStatus> exit_status_ SINEW_GUARDED_BY(mu_);

  std::thread thread_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_SUBPROCESS_H_
