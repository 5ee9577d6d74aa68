#include "teacher/client/remote_annotator.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "teacher/client/answers.h"
#include "teacher/client/part_queue.h"
#include "teacher/client/replica.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {
namespace {

using Replicas = std::vector<std::unique_ptr<Replica>>;

class RemoteAnnotator final : public Annotator {
 public:
  RemoteAnnotator(RemoteAnnotatorOptions options, Replicas replicas,
                  v1::DescribeTeacherResponse description,
                  std::vector<double> spread)
      : options_(std::move(options)),
        replicas_(std::move(replicas)),
        description_(std::move(description)),
        spread_(std::move(spread)) {}

  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return spread_; }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override;

 private:
  // One batch, divided.
  struct Batch {
    const Rows& rows;
    absl::Span<double> targets;
    int64_t count;
    int64_t part_rows;
  };

  // Serves one replica until the queue has no more for it.
  void Work(int replica, const Batch& batch, PartQueue& queue,
            const std::stop_token& cancel) const;
  absl::Status Verify(const Replica& replica,
                      const std::stop_token& cancel) const;
  absl::Status Ask(const Replica& replica, const Batch& batch, int64_t part,
                   const std::stop_token& cancel) const;

  const RemoteAnnotatorOptions options_;
  const Replicas replicas_;
  const v1::DescribeTeacherResponse description_;
  const std::vector<double> spread_;
};

absl::Status RemoteAnnotator::Annotate(const Rows& rows,
                                       absl::Span<double> targets) {
  SINEW_ASSIGN_OR_RETURN(const int64_t count,
                         CheckRows(description_, rows, targets));
  if (count == 0) return absl::OkStatus();
  const auto replicas = static_cast<int64_t>(replicas_.size());
  const int64_t most =
      std::min<int64_t>(options_.max_rows, description_.max_rows());
  const int64_t part_rows = std::min(most, (count + replicas - 1) / replicas);
  const Batch batch = {
      .rows = rows, .targets = targets, .count = count, .part_rows = part_rows};
  PartQueue::Options queue_options;
  queue_options.parts = (count + part_rows - 1) / part_rows;
  for (const auto& replica : replicas_) {
    queue_options.peers.push_back(replica->peer());
  }
  queue_options.backoff = options_.backoff;
  queue_options.patience = options_.patience;
  SystemClock clock;
  PartQueue queue(queue_options, clock);
  std::stop_source cancel;
  std::vector<std::jthread> workers;
  const auto each =
      std::min<int64_t>(options_.calls_in_flight, queue_options.parts);
  for (int64_t i = 0; i < each * replicas; ++i) {
    workers.emplace_back([&, replica = static_cast<int>(i % replicas)] {
      Work(replica, batch, queue, cancel.get_token());
    });
  }
  const absl::Status status = queue.Await(options_.stop);
  cancel.request_stop();
  return status;  // the workers are joined first
}

void RemoteAnnotator::Work(int replica, const Batch& batch, PartQueue& queue,
                           const std::stop_token& cancel) const {
  const Replica& one = *replicas_[replica];
  bool verified = false;
  while (const std::optional<int64_t> part = queue.Take(replica)) {
    absl::Status status = verified ? absl::OkStatus() : Verify(one, cancel);
    if (status.ok()) status = Ask(one, batch, *part, cancel);
    verified = status.ok();
    if (status.ok()) {
      queue.Done(replica);
    } else {
      queue.Failed(replica, *part, status);
    }
  }
}

absl::Status RemoteAnnotator::Verify(const Replica& replica,
                                     const std::stop_token& cancel) const {
  SINEW_ASSIGN_OR_RETURN(const v1::DescribeTeacherResponse found,
                         replica.Describe({}, options_.call_timeout, cancel));
  SINEW_RETURN_IF_ERROR(
      CheckAlike(description_, "the run's teacher", found, replica.peer()));
  if (found.max_rows() >= description_.max_rows()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      replica.peer(), ": max_rows: expected ", description_.max_rows(),
      " as it had, found ", found.max_rows()));
}

absl::Status RemoteAnnotator::Ask(const Replica& replica, const Batch& batch,
                                  int64_t part,
                                  const std::stop_token& cancel) const {
  const int64_t first = part * batch.part_rows;
  const int64_t count = std::min(batch.part_rows, batch.count - first);
  const int64_t width = description_.action_width();
  SINEW_ASSIGN_OR_RETURN(
      const v1::AnnotateResponse answer,
      replica.Annotate(MakeRequest(description_, batch.rows, first, count),
                       options_.call_timeout, cancel));
  std::vector<double> spread(width);
  SINEW_RETURN_IF_ERROR(
      ReadAnswer(description_, answer, replica.peer(),
                 batch.targets.subspan(first * width, count * width),
                 absl::MakeSpan(spread)));
  if (spread == spread_) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      replica.peer(), ": spread: expected what it was, found other numbers"));
}

// What a replica says of itself and of a sample row.
struct Introduction {
  v1::DescribeTeacherResponse description;
  std::vector<double> targets, spread;
};

// An observation by which policies show how they differ: zeros would ask only
// for their biases.
std::vector<float> SampleRow(int64_t width) {
  std::vector<float> row(width);
  for (int64_t i = 0; i < width; ++i) {
    row[i] = 0.1F * static_cast<float>(i % 7 - 3);
  }
  return row;
}

absl::StatusOr<Introduction> Introduce(const RemoteAnnotatorOptions& options,
                                       const Clock& clock,
                                       Clock::TimePoint deadline,
                                       const Replica& replica) {
  const auto timeout = [&] {
    return std::min(options.call_timeout,
                    absl::FromChrono(deadline - clock.SteadyNow()));
  };
  v1::DescribeTeacherRequest request;
  request.set_with_provenance(true);
  Introduction result;
  SINEW_ASSIGN_OR_RETURN(result.description,
                         replica.Describe(request, timeout(), options.stop));
  SINEW_RETURN_IF_ERROR(CheckDescription(result.description, replica.peer()));
  const std::vector<float> observations =
      SampleRow(result.description.observation_width());
  const std::vector<double> bases(result.description.action_width(), 0.0);
  SINEW_ASSIGN_OR_RETURN(
      const v1::AnnotateResponse answer,
      replica.Annotate(
          MakeRequest(result.description,
                      {.observations = observations, .bases = bases}, 0, 1),
          timeout(), options.stop));
  result.targets.resize(bases.size());
  result.spread.resize(bases.size());
  SINEW_RETURN_IF_ERROR(ReadAnswer(result.description, answer, replica.peer(),
                                   absl::MakeSpan(result.targets),
                                   absl::MakeSpan(result.spread)));
  return result;
}

// Introduce until it works: replicas may still be starting.
absl::StatusOr<Introduction> AwaitIntroduction(
    const RemoteAnnotatorOptions& options, const Clock& clock,
    Clock::TimePoint deadline, const Replica& replica) {
  absl::StatusOr<Introduction> result;
  const absl::Status status = rpc::Retry(
      options.backoff, std::numeric_limits<int>::max(),
      [&](absl::Duration wait) {
        return clock.After(wait) < deadline && rpc::WaitFor(wait, options.stop);
      },
      [&] {
        result = Introduce(options, clock, deadline, replica);
        // A full queue empties.
        return absl::IsResourceExhausted(result.status())
                   ? absl::UnavailableError(result.status().message())
                   : result.status();
      });
  if (options.stop.stop_requested()) {
    return absl::CancelledError(
        absl::StrCat("connecting to ", replica.peer(), " was stopped"));
  }
  if (absl::IsCancelled(status)) {
    return WithContext(result.status(),
                       absl::StrCat("no answer within ",
                                    absl::FormatDuration(options.patience)));
  }
  if (!status.ok()) return status;
  return result;
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
  for (const auto& [name, value] :
       {std::pair("call_timeout", options.call_timeout),
        std::pair("patience", options.patience)}) {
    if (value <= absl::ZeroDuration()) {
      return wrong(name, "> 0", absl::FormatDuration(value));
    }
  }
  return absl::OkStatus();
}

// Whether all are one teacher; then what every one of them takes.
absl::StatusOr<v1::DescribeTeacherResponse> CommonDescription(
    const Replicas& replicas, absl::Span<const Introduction> introductions) {
  const Introduction& first = introductions.front();
  v1::DescribeTeacherResponse result = first.description;
  for (size_t i = 1; i < replicas.size(); ++i) {
    const Introduction& other = introductions[i];
    SINEW_RETURN_IF_ERROR(CheckAlike(first.description, replicas[0]->peer(),
                                     other.description, replicas[i]->peer()));
    if (other.targets != first.targets || other.spread != first.spread) {
      return absl::FailedPreconditionError(absl::StrCat(
          replicas[i]->peer(), ": expected the same answer to a sample row ",
          "as ", replicas[0]->peer(), " gives, found another"));
    }
    result.set_max_rows(
        std::min(result.max_rows(), other.description.max_rows()));
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
  const SystemClock clock;
  const Clock::TimePoint deadline = clock.After(options.patience);
  std::vector<Introduction> introductions;
  for (const auto& replica : replicas) {
    SINEW_ASSIGN_OR_RETURN(
        Introduction one,
        AwaitIntroduction(options, clock, deadline, *replica));
    introductions.push_back(std::move(one));
  }
  SINEW_ASSIGN_OR_RETURN(v1::DescribeTeacherResponse description,
                         CommonDescription(replicas, introductions));
  return std::make_unique<RemoteAnnotator>(
      options, std::move(replicas), std::move(description),
      std::move(introductions.front().spread));
}

}  // namespace sinew::teacher
