#include "teacher/service/batcher.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {
namespace {

// How soon a call that waits sees that nobody waits for it.
constexpr absl::Duration kLook = absl::Milliseconds(100);
// An idle thread is woken by calls and by the end.
constexpr absl::Duration kIdle = absl::Hours(1);

absl::Status Expired() {
  return absl::DeadlineExceededError("the call waited too long in the queue");
}

// Of a message's field, which is aligned for them.
template <typename T>
absl::Span<const T> Numbers(absl::string_view bytes) {
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

}  // namespace

Batcher::Batcher(Annotator& annotator, const Options& options, Clock& clock,
                 TeacherMetrics& metrics)
    : annotator_(annotator),
      options_(options),
      clock_(clock),
      metrics_(metrics),
      thread_([this](const std::stop_token& stop) { Work(stop); }) {
  metrics_.queue_limit_rows.Set(static_cast<double>(options_.queue_rows));
}

Batcher::~Batcher() { Close(); }

void Batcher::Close() {
  {
    MutexLock lock(mu_);
    closed_ = true;
  }
  changed_.NotifyAll();
}

absl::StatusOr<std::string> Batcher::Annotate(const Call& call) {
  Pending pending = {.call = &call, .since = clock_.SteadyNow()};
  {
    MutexLock lock(mu_);
    SINEW_RETURN_IF_ERROR(Enqueue(pending));
    changed_.NotifyAll();
    AwaitAnswer(pending);
  }
  SINEW_RETURN_IF_ERROR(pending.status);
  return std::move(pending.targets);
}

absl::Status Batcher::Enqueue(Pending& pending) {
  if (closed_) return absl::UnavailableError("the teacher is shutting down");
  const int64_t rows = pending.call->rows;
  if (queue_rows_ + rows > options_.queue_rows) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the queue is full: expected at most ", options_.queue_rows,
        " rows, found ", queue_rows_, " and ", rows, " more"));
  }
  queue_.push_back(&pending);
  queue_rows_ += rows;
  metrics_.queue_rows.Set(static_cast<double>(queue_rows_));
  return absl::OkStatus();
}

void Batcher::AwaitAnswer(Pending& pending) {
  while (pending.state != State::kDone) {
    const Clock::TimePoint now = clock_.SteadyNow();
    Clock::TimePoint wake = clock_.After(kLook);
    if (pending.state == State::kWaiting) {
      const Call& call = *pending.call;
      if (now >= call.deadline) {
        Remove(pending, Expired());
        continue;
      }
      if (call.cancelled()) {
        Remove(pending, absl::CancelledError("the caller went away"));
        continue;
      }
      wake = std::min(wake, call.deadline);
    }
    clock_.WaitUntil(mu_, changed_, wake, {});
  }
}

void Batcher::Remove(Pending& pending, absl::Status status) {
  queue_.erase(std::find(queue_.begin(), queue_.end(), &pending));
  queue_rows_ -= pending.call->rows;
  metrics_.queue_rows.Set(static_cast<double>(queue_rows_));
  pending.state = State::kDone;
  pending.status = std::move(status);
}

void Batcher::Work(const std::stop_token& stop) {
  while (true) {
    std::vector<Pending*> batch;
    {
      MutexLock lock(mu_);
      if (!AwaitBatch(stop)) return;
      batch = TakeBatch();
    }
    Compute(batch);
    {
      MutexLock lock(mu_);
      for (Pending* pending : batch) pending->state = State::kDone;
    }
    changed_.NotifyAll();
  }
}

bool Batcher::AwaitBatch(const std::stop_token& stop) {
  while (true) {
    DropExpired();
    if (queue_.empty()) {
      if (stop.stop_requested()) return false;
      clock_.WaitUntil(mu_, changed_, clock_.After(kIdle), stop);
      continue;
    }
    const Clock::TimePoint due =
        queue_.front()->since + absl::ToChronoNanoseconds(options_.batch_delay);
    if (closed_ || stop.stop_requested() ||
        queue_rows_ >= options_.max_batch_rows || clock_.SteadyNow() >= due) {
      return true;
    }
    clock_.WaitUntil(mu_, changed_, due, stop);
  }
}

void Batcher::DropExpired() {
  const Clock::TimePoint now = clock_.SteadyNow();
  std::vector<Pending*> expired;
  for (Pending* pending : queue_) {
    if (now >= pending->call->deadline) expired.push_back(pending);
  }
  for (Pending* pending : expired) Remove(*pending, Expired());
  if (!expired.empty()) changed_.NotifyAll();
}

std::vector<Batcher::Pending*> Batcher::TakeBatch() {
  std::vector<Pending*> batch;
  int64_t rows = 0;
  while (!queue_.empty()) {
    Pending* next = queue_.front();
    if (!batch.empty() && rows + next->call->rows > options_.max_batch_rows) {
      break;
    }
    rows += next->call->rows;
    next->state = State::kComputing;
    batch.push_back(next);
    queue_.pop_front();
  }
  queue_rows_ -= rows;
  metrics_.queue_rows.Set(static_cast<double>(queue_rows_));
  return batch;
}

void Batcher::Compute(absl::Span<Pending* const> batch) {
  const double begin = clock_.SteadySeconds();
  const absl::Status status = Label(batch);
  for (size_t i = 0; i < batch.size(); ++i) {
    batch[i]->status =
        status.ok() || batch.size() == 1 ? status : Label(batch.subspan(i, 1));
  }
  metrics_.annotate_seconds.Increment(clock_.SteadySeconds() - begin);
}

absl::Status Batcher::Label(absl::Span<Pending* const> batch) {
  int64_t rows = 0;
  for (const Pending* pending : batch) rows += pending->call->rows;
  metrics_.batch_rows.Observe(static_cast<double>(rows));
  SINEW_RETURN_IF_ERROR(batch.size() == 1 ? LabelOne(*batch.front())
                                          : LabelTogether(rows, batch));
  metrics_.rows.Increment(static_cast<double>(rows));
  return absl::OkStatus();
}

absl::Status Batcher::LabelOne(Pending& pending) {
  const Call& call = *pending.call;
  pending.targets.resize(call.bases.size());
  return annotator_.Annotate({.observations = Numbers<float>(call.observations),
                              .bases = Numbers<double>(call.bases),
                              .known_finite = true},
                             {reinterpret_cast<double*>(pending.targets.data()),
                              pending.targets.size() / sizeof(double)});
}

absl::Status Batcher::LabelTogether(int64_t rows,
                                    absl::Span<Pending* const> batch) {
  const v1::DescribeTeacherResponse& teacher = annotator_.description();
  observations_.resize(rows * teacher.observation_width());
  bases_.resize(rows * teacher.action_width());
  targets_.resize(bases_.size());
  float* observation = observations_.data();
  double* base = bases_.data();
  for (const Pending* pending : batch) {
    const Call& call = *pending->call;
    std::memcpy(observation, call.observations.data(),
                call.observations.size());
    std::memcpy(base, call.bases.data(), call.bases.size());
    observation += call.observations.size() / sizeof(float);
    base += call.bases.size() / sizeof(double);
  }
  SINEW_RETURN_IF_ERROR(annotator_.Annotate(
      {.observations = observations_, .bases = bases_, .known_finite = true},
      absl::MakeSpan(targets_)));
  absl::string_view rest = Bytes<double>(targets_);
  for (Pending* pending : batch) {
    const size_t size = pending->call->bases.size();
    pending->targets.assign(rest.data(), size);
    rest.remove_prefix(size);
  }
  return absl::OkStatus();
}

}  // namespace sinew::teacher
