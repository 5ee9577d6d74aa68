#ifndef SINEW_LEARNER_TORCH_RUNTIME_H_
#define SINEW_LEARNER_TORCH_RUNTIME_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace sinew::learner {

// libtorch's process-wide and per-thread settings, without its headers.
//
// Thread-safety: any thread. Blocking: PlainMatmulFlops computes for about a
// second. Errors: as said.

// Every operation of the calling thread runs on that thread alone, numbers too
// small for a normal float32 count as zero, and results do not depend on what
// other threads do at that moment: what libtorch finds out about the CPU at its
// first call has been found out. Call it first thing in each thread that
// computes.
void UseOneThread();

// OK for "", "cpu", and for "cuda" if this build of libtorch has it and there
// is a device. INVALID_ARGUMENT for other names, FAILED_PRECONDITION for
// "cuda" in vain; the message says what was asked and found.
absl::Status CheckDevice(const std::string& device);

// What matters of a CPU for bfloat16 products.
struct CpuFeatures {
  bool avx512_bf16 = false;
  bool amx_bf16 = false;
};
CpuFeatures DetectCpu();

// OK if the CPU multiplies bfloat16 itself, or the device is "cuda".
// FAILED_PRECONDITION else, with the recipe's `field` that asked: emulation
// would be many times slower than float32.
absl::Status CheckBfloat16(const CpuFeatures& cpu, const std::string& device,
                           absl::string_view field);

// Best plain float32 matrix product of this library on the calling thread,
// FLOP/s: the largest over a few square and tall shapes, each timed several
// times. For benchmarks. Precondition: UseOneThread.
double PlainMatmulFlops();

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TORCH_RUNTIME_H_
