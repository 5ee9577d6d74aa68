#include "learner/state/state_saver.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/logging.h"
#include "learner/learner.h"
#include "learner/state/state_store.h"

namespace sinew::learner {
namespace {

int64_t BytesOf(const Trainer::State& state) {
  int64_t bytes = static_cast<int64_t>(state.counters.ByteSizeLong());
  for (const auto& [name, tensor] : state.tensors) {
    bytes += static_cast<int64_t>(tensor.data.size());
  }
  for (const std::string& snapshot : state.snapshots) {
    bytes += static_cast<int64_t>(snapshot.size());
  }
  for (const StateChunk& chunk : state.chunks) {
    bytes += static_cast<int64_t>(chunk.bytes->size());
  }
  return bytes;
}

}  // namespace

StateSaver::StateSaver(checkpoint::ArtifactStore& store, int keep, Clock& clock,
                       SaveMetrics& metrics)
    : store_(store),
      keep_(keep),
      clock_(clock),
      metrics_(metrics),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

bool StateSaver::Start(Trainer::State state) {
  MutexLock lock(mu_);
  if (state_.has_value()) return false;
  state_ = std::move(state);
  changed_.NotifyAll();
  return true;
}

bool StateSaver::idle() const {
  MutexLock lock(mu_);
  return !state_.has_value();
}

std::optional<StateSaver::Result> StateSaver::TakeResult() {
  MutexLock lock(mu_);
  return std::exchange(result_, std::nullopt);
}

absl::Status StateSaver::Flush(absl::Duration timeout,
                               const std::stop_token& stop) {
  const Clock::TimePoint deadline = clock_.After(timeout);
  MutexLock lock(mu_);
  while (state_.has_value()) {
    if (!clock_.WaitUntil(mu_, changed_, deadline, stop)) break;
  }
  if (!state_.has_value()) return absl::OkStatus();
  return absl::DeadlineExceededError(absl::StrCat(
      "the training state of iteration ", state_->counters.iteration(),
      " is still being saved after ", absl::FormatDuration(timeout)));
}

void StateSaver::Run(const std::stop_token& stop) {
  while (true) {
    const Trainer::State* state = nullptr;
    {
      MutexLock lock(mu_);
      while (!state_.has_value() && changed_.Wait(mu_, stop)) {
      }
      if (!state_.has_value()) return;
      // Nobody changes it while it is in flight.
      state = &*state_;
    }
    Result result = Save(*state);
    MutexLock lock(mu_);
    result_ = std::move(result);
    state_.reset();
    changed_.NotifyAll();
  }
}

StateSaver::Result StateSaver::Save(const Trainer::State& state) {
  const double begin = clock_.SteadySeconds();
  Result result;
  result.iteration = state.counters.iteration();
  result.bytes = BytesOf(state);
  result.status = SaveState(store_, state, keep_);
  result.seconds = clock_.SteadySeconds() - begin;
  metrics_.seconds.Observe(result.seconds);
  if (result.status.ok()) {
    metrics_.saves.Increment();
    metrics_.bytes.Set(static_cast<double>(result.bytes));
    metrics_.last_success_timestamp_seconds.Set(clock_.WallSeconds());
  } else {
    metrics_.failures.Increment();
    LogError(
        "cannot save the training state",
        {{"iteration", result.iteration}, {"reason", result.status.message()}});
  }
  return result;
}

}  // namespace sinew::learner
