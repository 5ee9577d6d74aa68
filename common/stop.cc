#include "common/stop.h"

#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <memory>
#include <thread>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/check.h"
#include "common/mutex.h"

namespace sinew {
namespace {

constexpr int kQuitStatus = 130;  // shells' status after an interrupt
constexpr uint64_t kSignalled = 1;
// Added by the destructor; the sum of both may be read at once.
constexpr uint64_t kEnd = uint64_t{1} << 32;

// What the handler may touch: lock-free atomics only.
std::atomic<int> handler_event_fd = -1;
std::atomic<int> signals_seen = 0;
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void HandleStopSignal(int /*signal*/) {
  const int saved_errno = errno;
  if (signals_seen.fetch_add(1) > 0) _exit(kQuitStatus);
  const uint64_t one = kSignalled;
  // Cannot fail: the counter is far from its limit.
  [[maybe_unused]] const ssize_t written =
      write(handler_event_fd.load(), &one, sizeof(one));
  errno = saved_errno;
}

}  // namespace

struct SignalStop::FormerHandlers {
  struct sigaction interrupt;
  struct sigaction terminate;
};

absl::StatusOr<std::unique_ptr<SignalStop>> SignalStop::Install() {
  const int fd = eventfd(0, EFD_CLOEXEC);
  if (fd < 0) return absl::InternalError("cannot make an eventfd for signals");
  int none = -1;
  if (!handler_event_fd.compare_exchange_strong(none, fd)) {
    close(fd);
    return absl::FailedPreconditionError(
        "SIGINT and SIGTERM are handled by another SignalStop already");
  }
  return std::unique_ptr<SignalStop>(new SignalStop(fd));
}

SignalStop::SignalStop(int event_fd)
    : event_fd_(event_fd), former_(std::make_unique<FormerHandlers>()) {
  signals_seen = 0;
  watcher_ = std::thread([this] { Watch(); });
  struct sigaction action = {};
  action.sa_handler = HandleStopSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  SINEW_CHECK(sigaction(SIGINT, &action, &former_->interrupt) == 0);
  SINEW_CHECK(sigaction(SIGTERM, &action, &former_->terminate) == 0);
}

SignalStop::~SignalStop() {
  sigaction(SIGINT, &former_->interrupt, nullptr);
  sigaction(SIGTERM, &former_->terminate, nullptr);
  const uint64_t end = kEnd;
  SINEW_CHECK(write(event_fd_, &end, sizeof(end)) == sizeof(end));
  watcher_.join();
  handler_event_fd = -1;
  close(event_fd_);
}

void SignalStop::Watch() {
  uint64_t events = 0;
  while (events < kEnd) {
    if (read(event_fd_, &events, sizeof(events)) != sizeof(events)) {
      SINEW_CHECK(errno == EINTR) << "errno " << errno;
      continue;
    }
    if (events % kEnd > 0) source_.request_stop();
  }
}

void AwaitStop(const StopToken& stop) {
  Mutex mu;
  CondVar never_notified;
  MutexLock lock(mu);
  while (never_notified.Wait(mu, stop)) {
  }
}

bool DieWithParent(int signal, pid_t parent) {
  if (prctl(PR_SET_PDEATHSIG, signal) != 0) return false;
  return getppid() == parent;
}

}  // namespace sinew
