#ifndef SINEW_TOOLS_TRAINING_ACTOR_PROCESSES_H_
#define SINEW_TOOLS_TRAINING_ACTOR_PROCESSES_H_

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/mutex.h"
#include "common/rpc/retry.h"
#include "common/stop.h"
#include "common/subprocess.h"

namespace sinew::tools {

// Child processes that are kept running: one that ends is started again after
// a back-off. One that has ended `max_failures` times in a row, each time
// within `stable_after` of its start, is given up: check() fails from then on
// with the end of its log. None outlives this object or this process.
//
// Thread-safety: any thread. Ownership: owns the processes and a thread for
// each. Blocking: the destructor, up to `grace`. Errors: Start (the program or
// a log cannot be used), check().
class ActorProcesses {
 public:
  struct Options {
    // Program and arguments of each; "{index}" in one stands for the number of
    // the actor, from 0.
    std::vector<std::string> argv;
    int count = 1;
    // Its stdout and stderr go to LOG_FOLDER/actor-INDEX.log, begun anew.
    std::string log_folder;
    int max_failures = 5;
    absl::Duration stable_after = absl::Seconds(30);
    rpc::BackoffOptions backoff = {};
    absl::Duration grace = absl::Seconds(10);
  };

  static absl::StatusOr<std::unique_ptr<ActorProcesses>> Start(Options options);
  ~ActorProcesses();
  ActorProcesses(const ActorProcesses&) = delete;
  ActorProcesses& operator=(const ActorProcesses&) = delete;

  // OK while all are well, or may become so.
  absl::Status check() const SINEW_EXCLUDES(mu_);
  // Restarts so far.
  int64_t restarts() const SINEW_EXCLUDES(mu_);
  // Process ids of those that run.
  std::vector<pid_t> pids() const SINEW_EXCLUDES(mu_);
  // Processor seconds that those that run have used so far.
  double CpuSeconds() const SINEW_EXCLUDES(mu_);

  // Sends SIGTERM and starts none again.
  void BeginStop() SINEW_EXCLUDES(mu_);

 private:
  explicit ActorProcesses(Options options);

  std::string LogFile(int index) const;
  absl::StatusOr<std::unique_ptr<Subprocess>> StartOne(int index) const;
  void Watch(int index) SINEW_EXCLUDES(mu_);
  // Notes an end; false: no further start.
  bool MayRestart(int index, const absl::Status& end, int failures)
      SINEW_EXCLUDES(mu_);

  const Options options_;
  StopSource stop_;
  mutable Mutex mu_;
  absl::Status failure_ SINEW_GUARDED_BY(mu_);
  int64_t restarts_ SINEW_GUARDED_BY(mu_) = 0;
  std::vector<std::unique_ptr<Subprocess>> processes_ SINEW_GUARDED_BY(mu_);
  // Last: the threads use all of the above.
  std::vector<std::jthread> watchers_;
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_ACTOR_PROCESSES_H_
