#include "deploy/checkpoint/testing/faulty_disk.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>

namespace sinew::checkpoint {
namespace {

std::atomic<bool> armed = false;
std::atomic<DiskFault> kind = DiskFault::kKill;
std::atomic<int> fault_at = 0;
std::atomic<int> calls = 0;

enum class Verdict { kGoOn, kFault, kFirstFault };

Verdict Judge() {
  if (!armed) return Verdict::kGoOn;
  const int call = calls.fetch_add(1);
  if (call < fault_at) return Verdict::kGoOn;
  return call == fault_at ? Verdict::kFirstFault : Verdict::kFault;
}

[[noreturn]] void Die() {
  kill(getpid(), SIGKILL);
  while (true) pause();
}

// True if the call is to fail for want of room.
bool LacksRoom() {
  const Verdict verdict = Judge();
  if (verdict == Verdict::kGoOn) return false;
  if (kind == DiskFault::kKill) Die();
  errno = ENOSPC;
  return true;
}

// For calls that need no room.
void MayDie() {
  if (Judge() == Verdict::kFirstFault && kind == DiskFault::kKill) Die();
}

}  // namespace

void ArmDiskFault(DiskFault fault, int at) {
  kind = fault;
  fault_at = at;
  calls = 0;
  armed = true;
}

int DisarmDiskFault() {
  armed = false;
  return calls;
}

}  // namespace sinew::checkpoint

// NOLINTBEGIN: the C library's own signatures.
extern "C" {

int open(const char* path, int flags, ...) {
  mode_t mode = 0;
  if (flags & O_CREAT) {
    va_list arguments;
    va_start(arguments, flags);
    mode = va_arg(arguments, mode_t);
    va_end(arguments);
    if (sinew::checkpoint::LacksRoom()) return -1;
  }
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

ssize_t write(int fd, const void* bytes, size_t size) {
  using namespace sinew::checkpoint;
  const Verdict verdict = fd > 2 ? Judge() : Verdict::kGoOn;
  if (verdict == Verdict::kGoOn) return syscall(SYS_write, fd, bytes, size);
  ssize_t written = -1;
  errno = ENOSPC;
  if (verdict == Verdict::kFirstFault && size > 1) {
    written = syscall(SYS_write, fd, bytes, size / 2);
  }
  if (kind == DiskFault::kKill) Die();
  return written;
}

int fsync(int fd) {
  if (sinew::checkpoint::LacksRoom()) return -1;
  return static_cast<int>(syscall(SYS_fsync, fd));
}

int mkdir(const char* path, mode_t mode) noexcept {
  if (sinew::checkpoint::LacksRoom()) return -1;
  return static_cast<int>(syscall(SYS_mkdirat, AT_FDCWD, path, mode));
}

int rename(const char* from, const char* to) noexcept {
  sinew::checkpoint::MayDie();
  return static_cast<int>(
      syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int unlink(const char* path) noexcept {
  sinew::checkpoint::MayDie();
  return static_cast<int>(syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}

int remove(const char* path) noexcept {
  sinew::checkpoint::MayDie();
  const long file = syscall(SYS_unlinkat, AT_FDCWD, path, 0);
  if (file == 0 || errno != EISDIR) return static_cast<int>(file);
  return static_cast<int>(syscall(SYS_unlinkat, AT_FDCWD, path, AT_REMOVEDIR));
}

int unlinkat(int folder, const char* path, int flags) noexcept {
  sinew::checkpoint::MayDie();
  return static_cast<int>(syscall(SYS_unlinkat, folder, path, flags));
}

}  // extern "C"
// NOLINTEND
