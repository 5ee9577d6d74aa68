#ifndef SINEW_TOOLS_TRAINING_PROGRESS_H_
#define SINEW_TOOLS_TRAINING_PROGRESS_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/mutex.h"

namespace sinew::tools {

// What a run shows of itself.
struct ProgressState {
  int64_t iteration = 0;
  int64_t samples = 0;
  double samples_per_second = 0;
  double reward = 0;
  // Of a distillation: root mean square of target errors, rad.
  std::optional<double> action_error_rad = std::nullopt;
  // Share of the run that is done, [0, 1], and seconds left; unset: it has no
  // end.
  std::optional<double> share;
  std::optional<double> seconds_left;
  // "12 of 32 starts, 54 mm"; empty: not evaluated yet.
  std::string evaluation;
  // What went wrong so far; empty: nothing.
  std::string trouble;
};

// "4:05", from an hour on "1:02:05"; negative seconds are none. Pure.
std::string TimeText(double seconds);

// One line, without its end: bar, iteration, samples, speed, reward, success,
// time left. Pure.
std::string ProgressText(const ProgressState& state, int bar_width);

// Shows progress on a terminal as a bar that is drawn again and again at the
// bottom, elsewhere as a plain line every `period`; lines of logs go above it.
//
// Thread-safety: yes. Ownership: borrows the clock. Blocking: as its writer
// does. Errors: none.
class Progress {
 public:
  struct Options {
    bool is_terminal = false;
    absl::Duration period = absl::Seconds(10);
    // Takes text as it is to appear; unset: stderr.
    std::function<void(absl::string_view)> write = nullptr;
  };
  Progress(Options options, const Clock& clock);
  // Ends the bar's line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Show(const ProgressState& state) SINEW_EXCLUDES(mu_);
  // The same for work of another kind: a bar of `share` done, [0, 1], and what
  // to say beside it.
  void Show(double share, absl::string_view text) SINEW_EXCLUDES(mu_);
  // A line of text above the bar.
  void Line(absl::string_view text) SINEW_EXCLUDES(mu_);

 private:
  void ShowText(std::string text) SINEW_EXCLUDES(mu_);

  const Options options_;
  const Clock& clock_;
  Mutex mu_;
  std::string bar_ SINEW_GUARDED_BY(mu_);
  Clock::TimePoint next_ SINEW_GUARDED_BY(mu_) = Clock::TimePoint::min();
};

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_PROGRESS_H_
