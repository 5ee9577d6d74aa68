#ifndef SINEW_TEACHER_SERVICE_BATCHER_H_
#define SINEW_TEACHER_SERVICE_BATCHER_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "teacher/client/annotator.h"
#include "teacher/service/teacher_metrics.h"

namespace sinew::teacher {

// Puts the rows of many calls into batches for one annotator.
//
//   Annotate: queue -> wait                        (one thread per call)
//   batcher:  wait for rows: a full batch of them, the oldest's batch_delay,
//             or the end -> drop what has expired -> annotate -> answer
//
// First come, first served; a call's rows stay together. A row's answer does
// not depend on what shares its batch: if a batch fails, its calls are computed
// one by one, so that one's error is not another's.
//
// Thread-safety: any thread. Ownership: borrows annotator, clock and metrics;
//   owns one thread, which answers all that waits before it ends. Blocking:
//   Annotate, until answered, at most its deadline (a call that is being
//   computed is waited for); sees cancellation within 100 ms. Errors: Annotate.
class Batcher {
 public:
  struct Options {
    // Rows of a batch, >= 1; also of one call.
    int64_t max_batch_rows = 1024;
    // How long the first rows of a batch wait for others, >= 0.
    absl::Duration batch_delay = absl::Milliseconds(1);
    // Rows that may wait, >= max_batch_rows.
    int64_t queue_rows = 16384;
  };

  // A call; borrowed until answered. Sizes fit, numbers are finite and
  // aligned.
  struct Call {
    int64_t rows = 0;                // 1 to max_batch_rows
    absl::string_view observations;  // as in v1::AnnotateRequest
    absl::string_view bases;
    Clock::TimePoint deadline;
    // Whether nobody waits for the answer any more.
    std::function<bool()> cancelled;
  };

  Batcher(Annotator& annotator, const Options& options, Clock& clock,
          TeacherMetrics& metrics);
  // No call may be waiting.
  ~Batcher();
  Batcher(const Batcher&) = delete;
  Batcher& operator=(const Batcher&) = delete;

  // The targets, as in v1::AnnotateResponse. RESOURCE_EXHAUSTED: the queue is
  // full; DEADLINE_EXCEEDED, CANCELLED: while it waited; UNAVAILABLE: closed;
  // else the annotator's.
  absl::StatusOr<std::string> Annotate(const Call& call) SINEW_EXCLUDES(mu_);

  // No new calls; those that wait are answered without further delay.
  void Close() SINEW_EXCLUDES(mu_);

 private:
  enum class State { kWaiting, kComputing, kDone };

  // One call on its way; on the stack of its Annotate. While it is computed,
  // call, targets and status belong to the batcher's thread, else to mu_.
  struct Pending {
    const Call* call;
    Clock::TimePoint since;
    State state = State::kWaiting;
    absl::Status status = absl::OkStatus();
    std::string targets = {};
  };

  absl::Status Enqueue(Pending& pending) SINEW_REQUIRES(mu_);
  void AwaitAnswer(Pending& pending) SINEW_REQUIRES(mu_);
  void Remove(Pending& pending, absl::Status status) SINEW_REQUIRES(mu_);

  void Work(const std::stop_token& stop) SINEW_EXCLUDES(mu_);
  // Waits until a batch is due; false at the end.
  bool AwaitBatch(const std::stop_token& stop) SINEW_REQUIRES(mu_);
  void DropExpired() SINEW_REQUIRES(mu_);
  std::vector<Pending*> TakeBatch() SINEW_REQUIRES(mu_);
  void Compute(absl::Span<Pending* const> batch) SINEW_EXCLUDES(mu_);
  absl::Status Label(absl::Span<Pending* const> batch) SINEW_EXCLUDES(mu_);
  // Without copies, from the call's bytes into its answer's.
  absl::Status LabelOne(Pending& pending) SINEW_EXCLUDES(mu_);
  absl::Status LabelTogether(int64_t rows, absl::Span<Pending* const> batch)
      SINEW_EXCLUDES(mu_);

  Annotator& annotator_;
  const Options options_;
  Clock& clock_;
  TeacherMetrics& metrics_;

  Mutex mu_;
  CondVar changed_;
  std::deque<Pending*> queue_ SINEW_GUARDED_BY(mu_);
  int64_t queue_rows_ SINEW_GUARDED_BY(mu_) = 0;
  bool closed_ SINEW_GUARDED_BY(mu_) = false;

  // Of the thread: a batch's rows.
  std::vector<float> observations_;
  std::vector<double> bases_;
  std::vector<double> targets_;

  // Last: it uses all of the above.
  std::jthread thread_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_SERVICE_BATCHER_H_
