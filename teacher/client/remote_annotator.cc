#include "teacher/client/remote_annotator.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/logging.h"
#include "common/mutex.h"
#include "common/status_macros.h"
#include "teacher/client/answers.h"
#include "teacher/client/introductions.h"
#include "teacher/client/part_queue.h"
#include "teacher/client/replica.h"
#include "teacher/client/replica_health.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {
namespace {

using Replicas = std::vector<std::unique_ptr<Replica>>;
using Introductions = std::vector<std::optional<Introduction>>;

// What errors call that which all replicas must be.
constexpr char kTeacher[] = "the run's teacher";

class RemoteAnnotator final : public Annotator {
 public:
  // `teacher`: what all replicas must be. Those without an introduction did not
  // answer.
  RemoteAnnotator(RemoteAnnotatorOptions options, Replicas replicas,
                  Introduction teacher, const Introductions& introductions);
  ~RemoteAnnotator() override { end_.request_stop(); }

  const v1::DescribeTeacherResponse& description() const override {
    return teacher_.description;
  }
  absl::Span<const double> spread() const override { return teacher_.spread; }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override
      SINEW_EXCLUDES(mu_);

 private:
  // One batch, divided.
  struct Batch {
    const Rows& rows;
    absl::Span<double> targets;
    int64_t count;
    int64_t part_rows;

    int64_t First(int64_t part) const { return part * part_rows; }
    int64_t Count(int64_t part) const {
      return std::min(part_rows, count - First(part));
    }
  };

  // Until all parts are answered, or all ends.
  absl::Status Run(const Batch& batch, int64_t parts, PartQueue& queue);
  // Serves one replica until the queue has no more for it.
  void Work(int replica, const Batch& batch, PartQueue& queue,
            const std::stop_token& cancel);
  // Beside the batches, until the end: introduces a replica that is away.
  void KeepIntroducing(int replica) SINEW_EXCLUDES(mu_);
  // Whether a replica is the teacher. Later its answers say so.
  absl::Status Verify(const Replica& replica, const std::stop_token& cancel);
  // `targets`: of the part.
  absl::Status Ask(const Replica& replica, const Batch& batch, int64_t part,
                   const std::stop_token& cancel,
                   std::vector<double>& targets) const;
  // Once per replica.
  void WarnOfAnother(int replica, const absl::Status& status);

  const RemoteAnnotatorOptions options_;
  const Replicas replicas_;
  const Introduction teacher_;
  // By replica: whether the log says that it is another teacher.
  std::vector<std::atomic<bool>> warned_;
  SystemClock clock_;
  ReplicaHealth health_;
  // Ends introductions.
  std::stop_source end_;
  const std::stop_callback<std::function<void()>> stopped_;

  Mutex mu_;
  // Of batches that are under way.
  std::set<PartQueue*> queues_ SINEW_GUARDED_BY(mu_);

  std::vector<std::jthread> introducers_;  // joined first
};

RemoteAnnotator::RemoteAnnotator(RemoteAnnotatorOptions options,
                                 Replicas replicas, Introduction teacher,
                                 const Introductions& introductions)
    : options_(std::move(options)),
      replicas_(std::move(replicas)),
      teacher_(std::move(teacher)),
      warned_(replicas_.size()),
      health_({.replicas = static_cast<int>(replicas_.size()),
               .backoff = options_.backoff,
               .late_factor = options_.late_factor,
               .late_floor = options_.late_floor},
              clock_),
      stopped_(options_.stop, [this] { end_.request_stop(); }) {
  for (int i = 0; i < static_cast<int>(replicas_.size()); ++i) {
    if (introductions[i].has_value()) health_.Introduced(i);
    introducers_.emplace_back([this, i] { KeepIntroducing(i); });
  }
}

absl::Status RemoteAnnotator::Annotate(const Rows& rows,
                                       absl::Span<double> targets) {
  SINEW_ASSIGN_OR_RETURN(const int64_t count,
                         CountRows(description(), rows, targets));
  if (count == 0) return absl::OkStatus();
  const auto replicas = static_cast<int64_t>(replicas_.size());
  const int64_t most =
      std::min<int64_t>(options_.max_rows, description().max_rows());
  const int64_t part_rows = std::min(most, (count + replicas - 1) / replicas);
  const Batch batch = {
      .rows = rows, .targets = targets, .count = count, .part_rows = part_rows};
  PartQueue::Options queue_options;
  queue_options.parts = (count + part_rows - 1) / part_rows;
  for (const auto& replica : replicas_) {
    queue_options.peers.push_back(replica->peer());
  }
  queue_options.patience = options_.patience;
  PartQueue queue(queue_options, health_, clock_);
  {
    MutexLock lock(mu_);
    queues_.insert(&queue);
  }
  absl::Status status = Run(batch, queue_options.parts, queue);
  MutexLock lock(mu_);
  queues_.erase(&queue);
  return status;
}

absl::Status RemoteAnnotator::Run(const Batch& batch, int64_t parts,
                                  PartQueue& queue) {
  std::stop_source cancel;
  std::vector<std::jthread> workers;
  const auto replicas = static_cast<int64_t>(replicas_.size());
  const auto each = std::min<int64_t>(options_.calls_in_flight, parts);
  for (int64_t i = 0; i < each * replicas; ++i) {
    workers.emplace_back([&, replica = static_cast<int>(i % replicas)] {
      Work(replica, batch, queue, cancel.get_token());
    });
  }
  absl::Status status = queue.Await(options_.stop);
  cancel.request_stop();
  return status;  // the workers are joined first
}

void RemoteAnnotator::Work(int replica, const Batch& batch, PartQueue& queue,
                           const std::stop_token& cancel) {
  std::vector<double> targets;  // of a part
  while (const std::optional<int64_t> part = queue.Take(replica)) {
    const int64_t first = batch.First(*part);
    const absl::Status finite =
        CheckFinite(description(), batch.rows, first, batch.Count(*part));
    if (!finite.ok()) {
      queue.End(finite);
      return;
    }
    const absl::Status status =
        Ask(*replicas_[replica], batch, *part, cancel, targets);
    if (status.ok()) {
      // Nobody else writes there, and the batch ends when all workers have.
      if (queue.Done(replica, *part)) {
        std::ranges::copy(targets, batch.targets.begin() +
                                       first * description().action_width());
      }
      continue;
    }
    // All is over: the call was cut off, which says nothing of the replica.
    if (cancel.stop_requested()) return;
    WarnOfAnother(replica, status);
    queue.Failed(replica, *part, status);
  }
}

void RemoteAnnotator::WarnOfAnother(int replica, const absl::Status& status) {
  if (!absl::IsFailedPrecondition(status)) return;
  if (warned_[replica].exchange(true)) return;
  LogWarning("a teacher is left out", {{"error", status.message()}});
}

void RemoteAnnotator::KeepIntroducing(int replica) {
  const Replica& one = *replicas_[replica];
  const std::stop_token end = end_.get_token();
  // Whether the log says that it is away.
  bool said = !health_.ReadyFrom(replica).has_value();
  while (health_.AwaitTurn(replica, end)) {
    const absl::Status status = Verify(one, end);
    if (end.stop_requested()) return;
    if (status.ok()) {
      health_.Introduced(replica);
      if (said) LogInfo("a teacher has come", {{"peer", one.peer()}});
    } else {
      health_.Failed(replica, status);
      WarnOfAnother(replica, status);
      if (!said && !absl::IsFailedPrecondition(status)) {
        LogWarning("a teacher does not answer; it gets no rows until it does",
                   {{"error", status.message()}});
      }
    }
    said = !status.ok();
    MutexLock lock(mu_);
    for (PartQueue* queue : queues_) queue->Introduced(replica, status);
  }
}

absl::Status RemoteAnnotator::Verify(const Replica& replica,
                                     const std::stop_token& cancel) {
  SINEW_ASSIGN_OR_RETURN(
      const Introduction found,
      Introduce(replica, [this] { return options_.call_timeout; }, cancel));
  SINEW_RETURN_IF_ERROR(
      CheckSameTeacher(teacher_, kTeacher, found, replica.peer()));
  if (found.description.max_rows() < description().max_rows()) {
    return absl::FailedPreconditionError(
        absl::StrCat(replica.peer(), ": max_rows: expected ",
                     description().max_rows(), " or more, as ", kTeacher,
                     " has, found ", found.description.max_rows()));
  }
  return absl::OkStatus();
}

absl::Status RemoteAnnotator::Ask(const Replica& replica, const Batch& batch,
                                  int64_t part, const std::stop_token& cancel,
                                  std::vector<double>& targets) const {
  const int64_t count = batch.Count(part);
  const int64_t width = description().action_width();
  SINEW_ASSIGN_OR_RETURN(const v1::AnnotateResponse answer,
                         replica.Annotate(MakeRequest(description(), batch.rows,
                                                      batch.First(part), count),
                                          options_.call_timeout, cancel));
  targets.resize(count * width);
  std::vector<double> spread(width);
  SINEW_RETURN_IF_ERROR(ReadAnswer(description(), answer, replica.peer(),
                                   absl::MakeSpan(targets),
                                   absl::MakeSpan(spread)));
  if (spread == teacher_.spread) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      replica.peer(), ": spread: expected what it was, found other numbers"));
}

absl::Status CheckOptions(const RemoteAnnotatorOptions& options) {
  const auto wrong = [](const char* option, const char* expected, auto found) {
    return absl::InvalidArgumentError(
        absl::StrCat(option, ": expected ", expected, ", found ", found));
  };
  if (options.addresses.empty()) return wrong("teachers", "an address", "none");
  if (options.max_rows < 1) return wrong("max_rows", ">= 1", options.max_rows);
  if (options.calls_in_flight < 1) {
    return wrong("calls_in_flight", ">= 1", options.calls_in_flight);
  }
  if (!(options.late_factor >= 1)) {
    return wrong("late_factor", ">= 1", options.late_factor);
  }
  for (const auto& [name, value] :
       {std::pair("call_timeout", options.call_timeout),
        std::pair("patience", options.patience),
        std::pair("late_floor", options.late_floor)}) {
    if (value <= absl::ZeroDuration()) {
      return wrong(name, "> 0", absl::FormatDuration(value));
    }
  }
  if (options.late_floor == absl::InfiniteDuration()) {
    return wrong("late_floor", "an end", "none");
  }
  return absl::OkStatus();
}

// Whether all that answer are one teacher; then what it is, and takes.
absl::StatusOr<Introduction> CommonIntroduction(
    const Replicas& replicas, const Introductions& introductions) {
  const auto first = static_cast<size_t>(
      std::ranges::find_if(introductions,
                           [](const auto& one) { return one.has_value(); }) -
      introductions.begin());
  Introduction result = *introductions[first];
  for (size_t i = first + 1; i < replicas.size(); ++i) {
    if (!introductions[i].has_value()) continue;
    SINEW_RETURN_IF_ERROR(CheckSameTeacher(result, replicas[first]->peer(),
                                           *introductions[i],
                                           replicas[i]->peer()));
    result.description.set_max_rows(
        std::min(result.description.max_rows(),
                 introductions[i]->description.max_rows()));
  }
  return result;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Annotator>> ConnectAnnotator(
    const RemoteAnnotatorOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckOptions(options));
  Replicas replicas;
  for (const std::string& address : options.addresses) {
    SINEW_ASSIGN_OR_RETURN(auto replica,
                           Replica::Create(address, options.security));
    replicas.push_back(std::move(replica));
  }
  SystemClock clock;
  SINEW_ASSIGN_OR_RETURN(const Introductions introductions,
                         IntroduceAll(replicas,
                                      {.stop = options.stop,
                                       .call_timeout = options.call_timeout,
                                       .patience = options.patience,
                                       .wait_for_all = options.wait_for_all,
                                       .backoff = options.backoff},
                                      clock));
  SINEW_ASSIGN_OR_RETURN(Introduction teacher,
                         CommonIntroduction(replicas, introductions));
  for (size_t i = 0; i < replicas.size(); ++i) {
    if (introductions[i].has_value()) continue;
    LogWarning("a teacher does not answer; going on with others",
               {{"peer", replicas[i]->peer()}});
  }
  return std::make_unique<RemoteAnnotator>(options, std::move(replicas),
                                           std::move(teacher), introductions);
}

}  // namespace sinew::teacher
