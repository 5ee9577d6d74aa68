#ifndef SINEW_COMMON_MUTEX_H_
#define SINEW_COMMON_MUTEX_H_

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <utility>

// Attributes for clang's thread-safety analysis, an error in this code base.
#if defined(__clang__)
#define SINEW_INTERNAL_ATTRIBUTE(x) __attribute__((x))
#else
#define SINEW_INTERNAL_ATTRIBUTE(x)
#endif
#define SINEW_CAPABILITY(x) SINEW_INTERNAL_ATTRIBUTE(capability(x))
#define SINEW_SCOPED_CAPABILITY SINEW_INTERNAL_ATTRIBUTE(scoped_lockable)
// On a member: may be touched only while the mutex is held. On a pointer, the
// second form guards what it points to.
#define SINEW_GUARDED_BY(x) SINEW_INTERNAL_ATTRIBUTE(guarded_by(x))
#define SINEW_PT_GUARDED_BY(x) SINEW_INTERNAL_ATTRIBUTE(pt_guarded_by(x))
// On a function: the caller holds (or must not hold) the mutexes.
#define SINEW_REQUIRES(...) \
  SINEW_INTERNAL_ATTRIBUTE(requires_capability(__VA_ARGS__))
#define SINEW_EXCLUDES(...) \
  SINEW_INTERNAL_ATTRIBUTE(locks_excluded(__VA_ARGS__))
#define SINEW_ACQUIRE(...) \
  SINEW_INTERNAL_ATTRIBUTE(acquire_capability(__VA_ARGS__))
#define SINEW_RELEASE(...) \
  SINEW_INTERNAL_ATTRIBUTE(release_capability(__VA_ARGS__))
#define SINEW_TRY_ACQUIRE(...) \
  SINEW_INTERNAL_ATTRIBUTE(try_acquire_capability(__VA_ARGS__))
#define SINEW_NO_THREAD_SAFETY_ANALYSIS \
  SINEW_INTERNAL_ATTRIBUTE(no_thread_safety_analysis)

namespace sinew {

// std::mutex with annotations: sanitizers see it (Debian's abseil is not
// instrumented, so they see false races through absl::Mutex).
//
// Thread-safety: by nature; not recursive. Ownership: belongs to the class
//   whose members it guards; never passed into another class. Blocking: Lock,
//   as long as others hold it; hold it for microseconds. Errors: none.
class SINEW_CAPABILITY("mutex") Mutex {
 public:
  Mutex() = default;
  Mutex(const Mutex&) = delete;
  Mutex& operator=(const Mutex&) = delete;

  void Lock() SINEW_ACQUIRE() { mu_.lock(); }
  void Unlock() SINEW_RELEASE() { mu_.unlock(); }
  bool TryLock() SINEW_TRY_ACQUIRE(true) { return mu_.try_lock(); }

 private:
  friend class CondVar;

  std::mutex mu_;
};

// Holds a mutex for the length of a block.
class SINEW_SCOPED_CAPABILITY MutexLock {
 public:
  explicit MutexLock(Mutex& mu) SINEW_ACQUIRE(mu) : mu_(mu) { mu_.Lock(); }
  ~MutexLock() SINEW_RELEASE() { mu_.Unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex& mu_;
};

// Waits for a change of what a mutex guards. Every wait has a deadline or a
// stop token, or both; each returns early when spuriously woken, so it stands
// in a loop:
//
//   while (queue_.empty()) {
//     if (!changed_.WaitUntil(mu_, deadline, stop)) break;
//   }
//   if (queue_.empty()) return ...;  // deadline or stop
//
// Code that is tested with simulated time waits through Clock (clock.h).
//
// Thread-safety: by nature. Blocking: as said. Errors: none.
class CondVar {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  CondVar() = default;
  CondVar(const CondVar&) = delete;
  CondVar& operator=(const CondVar&) = delete;

  // Releases `mu`, waits for a notification or for `stop`, locks `mu` again.
  // False once stop is requested.
  bool Wait(Mutex& mu, const std::stop_token& stop) SINEW_REQUIRES(mu) {
    bool waited = false;
    cv_.wait(mu.mu_, stop, [&] { return std::exchange(waited, true); });
    return !stop.stop_requested();
  }

  // Like Wait, but at most until `deadline`. False once the deadline has
  // passed or stop is requested.
  bool WaitUntil(Mutex& mu, TimePoint deadline,
                 const std::stop_token& stop = {}) SINEW_REQUIRES(mu) {
    bool waited = false;
    cv_.wait_until(mu.mu_, stop, deadline,
                   [&] { return std::exchange(waited, true); });
    return !stop.stop_requested() &&
           std::chrono::steady_clock::now() < deadline;
  }

  void NotifyOne() { cv_.notify_one(); }
  void NotifyAll() { cv_.notify_all(); }

 private:
  std::condition_variable_any cv_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_MUTEX_H_
