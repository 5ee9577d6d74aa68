#ifndef SINEW_DEPLOY_CHECKPOINT_TESTING_FAULTY_DISK_H_
#define SINEW_DEPLOY_CHECKPOINT_TESTING_FAULTY_DISK_H_

namespace sinew::checkpoint {

// A program that links this calls the C library's functions that change a disk
// (creating open, write, fsync, rename, unlink, mkdir) through a counter, which
// can make them fail.
//
// Thread-safety: counts any thread's calls; Arm and Disarm while none is made.
enum class DiskFault {
  // SIGKILL to this process, in place of the call; a write has half happened.
  kKill,
  // From that call on, what needs room fails with ENOSPC; the first write has
  // half happened.
  kNoSpace,
};

// Counts from 0 and lets the fault happen at call `at`.
void ArmDiskFault(DiskFault fault, int at);

// No faults any more. Returns how many calls there were since it was armed.
int DisarmDiskFault();

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_TESTING_FAULTY_DISK_H_
