#ifndef SINEW_TOOLS_TRAINING_PROCESS_CPU_H_
#define SINEW_TOOLS_TRAINING_PROCESS_CPU_H_

#include <sys/types.h>

namespace sinew::tools {

// Processor seconds that a process has used so far, user and system; 0 if it
// is gone. Thread-safe; blocks for microseconds.
double ProcessCpuSeconds(pid_t pid);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROCESS_CPU_H_
