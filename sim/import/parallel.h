#ifndef SINEW_SIM_IMPORT_PARALLEL_H_
#define SINEW_SIM_IMPORT_PARALLEL_H_

#include "absl/functional/function_ref.h"
#include "common/stop.h"

namespace sinew::import {

// Calls task(i) for every i of [0, count), each once, on at most `threads`
// threads that take the next i when they are free; returns when all are done.
// After a request to stop no further task is begun. Tasks of different i run at
// the same time and must not throw.
//
// Thread-safety: yes. Ownership: joins its threads. Blocking: until the last
// task has returned. Errors: none; tasks keep their own.
void ForEachIndex(int count, int threads, const StopToken& stop,
                  absl::FunctionRef<void(int)> task);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_PARALLEL_H_
