#ifndef SINEW_COMMON_STOP_SIGNAL_H_
#define SINEW_COMMON_STOP_SIGNAL_H_

namespace sinew {

// From the first call on, SIGINT and SIGTERM ask the process to stop instead of
// killing it; a second signal quits at once with status 130. Once per process,
// from main.
void CatchStopSignals();

// True once a stop was asked for. Any thread; never blocks.
bool StopRequested();

}  // namespace sinew

#endif  // SINEW_COMMON_STOP_SIGNAL_H_
