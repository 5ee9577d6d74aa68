#ifndef SINEW_TESTS_TESTING_TRAINING_RIG_H_
#define SINEW_TESTS_TESTING_TRAINING_RIG_H_

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "common/subprocess.h"
#include "learner/trainer/trainer.h"
#include "sim/world/testing/toy_world.h"

namespace sinew::tests {

// Exit codes of the program (tools/sinew/command.h).
inline constexpr int kFailed = 1;
inline constexpr int kMisused = 2;

// The `sinew` program on a toy body, library and recipe that train within a
// second, in fresh folders.
//
// Thread-safety: one caller. Ownership: owns the folders. Blocking: members
// wait for processes or files, two minutes at most. Errors: test failures.
class TrainingRig {
 public:
  using Arguments = std::vector<std::string>;

  TrainingRig();

  // Path of a run directory (not made yet), or of any other file.
  std::string Path(const std::string& name) const;
  std::string ToyFile(const std::string& name) const;

  // "train --recipe ... --run RUN --iterations N", and what follows.
  Arguments Train(const std::string& run, int iterations,
                  const Arguments& more = {}) const;
  // The same for "learner".
  Arguments Learner(const std::string& run, int iterations,
                    const Arguments& more = {}) const;

  // Starts `sinew ARGUMENTS`; its output goes to Path(name + ".out").
  std::unique_ptr<Subprocess> Start(const std::string& name,
                                    const Arguments& arguments) const;
  // Runs it to its end, which must come within two minutes.
  ExitStatus Run(const std::string& name, const Arguments& arguments) const;
  // Runs it and expects it to end well.
  void MustRun(const std::string& name, const Arguments& arguments) const;

  std::string Output(const std::string& name) const;
  // Where a role says that it listens.
  std::string AwaitAddress(Subprocess& process, const std::string& name) const;

  // The latest state in a run's folder, and its fingerprint.
  learner::Trainer::State StateOf(const std::string& run) const;
  std::string FingerprintOf(const std::string& run) const;
  // SHA-256 of its tensors alone: equal for runs that learnt the same, whatever
  // their recipes and teachers say.
  std::string TensorsOf(const std::string& run) const;

  // Rows of a run's metrics.jsonl.
  int Rows(const std::string& run) const;
  // Waits for so many rows; the process must be running.
  void AwaitRows(Subprocess& process, const std::string& run, int rows) const;
  // Lets a run, begun or gone on with by `arguments`, reach so many rows and
  // kills it a moment later, wherever it is then; it must be running. A run
  // that goes on may begin by dropping rows.
  void KillAfter(const std::string& run, int rows, absl::Duration moment,
                 const Arguments& arguments) const;

 private:
  world::testing::ToyWorld toy_;
};

// The address in the first line of a log that holds `message`; empty: there is
// no whole such line yet.
std::string AddressIn(const std::string& log, const std::string& message);

// Waits until `holds`: for what other processes do, which nothing announces.
void AwaitTrue(const std::function<bool()>& holds);
// The same, while `process` runs.
void Await(Subprocess& process, const std::function<bool()>& holds);

// The latest state in a store's folder.
learner::Trainer::State LatestState(const std::string& folder);

// All of a state that must not depend on who ran what and when: SHA-256 over
// tensors, snapshots and counters, without seconds.
std::string Fingerprint(const learner::Trainer::State& state);

// Processes whose parent is `pid`.
std::vector<pid_t> ChildrenOf(pid_t pid);
bool IsRunning(pid_t pid);

}  // namespace sinew::tests

#endif  // SINEW_TESTS_TESTING_TRAINING_RIG_H_
