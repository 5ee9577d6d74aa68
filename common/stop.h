#ifndef SINEW_COMMON_STOP_H_
#define SINEW_COMMON_STOP_H_

#include <sys/types.h>

#include <memory>
#include <stop_token>
#include <thread>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sinew {

// How a program is told to end. Waits take a StopToken (see mutex.h); whoever
// owns the work owns the StopSource.
using StopToken = std::stop_token;
using StopSource = std::stop_source;

// SIGINT and SIGTERM as a request to stop: the first signal requests stop, so
// that the program saves and ends in order; the second ends it at once with
// status 130, even if the program hangs.
//
// Thread-safety: token() from any thread. Ownership: one object per process at
//   a time, made in main before other threads; restores the former handlers
//   when destroyed. Blocking: never (callbacks of the token run on a thread of
//   this object's own). Errors: Install.
class SignalStop {
 public:
  // FAILED_PRECONDITION: another one is installed. INTERNAL: no descriptors.
  static absl::StatusOr<std::unique_ptr<SignalStop>> Install();
  ~SignalStop();
  SignalStop(const SignalStop&) = delete;
  SignalStop& operator=(const SignalStop&) = delete;

  StopToken token() const { return source_.get_token(); }

 private:
  struct FormerHandlers;

  explicit SignalStop(int event_fd);
  void Watch();

  const int event_fd_;
  StopSource source_;
  std::unique_ptr<FormerHandlers> former_;
  std::thread watcher_;
};

// Blocks until stop is requested: what a program does that serves on others'
// threads.
void AwaitStop(const StopToken& stop);

// Asks the kernel to send `signal` to this process when the thread that
// started it ends, and returns false if the parent is no longer `parent` (it
// died before it could be watched): the caller then exits. Survives exec. May
// be called between fork and exec.
bool DieWithParent(int signal, pid_t parent);

}  // namespace sinew

#endif  // SINEW_COMMON_STOP_H_
