#include "teacher/client/introductions.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/mutex.h"
#include "common/rpc/status.h"
#include "common/status_macros.h"
#include "teacher/client/answers.h"

namespace sinew::teacher {
namespace {

// An observation by which policies show how they differ: zeros would ask only
// for their biases.
std::vector<float> SampleRow(int64_t width) {
  std::vector<float> row(width);
  for (int64_t i = 0; i < width; ++i) {
    row[i] = 0.1F * static_cast<float>(i % 7 - 3);
  }
  return row;
}

// Whether the replica may still come: a full queue empties.
bool MayCome(const absl::Status& status) {
  return rpc::IsTransient(status) || absl::IsResourceExhausted(status);
}

// Introduce until it works, or fails for good, or time is up; the last error.
absl::StatusOr<Introduction> AwaitIntroduction(
    const Replica& replica, const IntroductionOptions& options,
    const Clock& clock, Clock::TimePoint deadline,
    const std::stop_token& cancel) {
  const auto timeout = [&] {
    return std::min(options.call_timeout,
                    absl::FromChrono(deadline - clock.SteadyNow()));
  };
  const auto wait = [&](absl::Duration duration) {
    return clock.After(duration) < deadline && rpc::WaitFor(duration, cancel);
  };
  absl::StatusOr<Introduction> result;
  (void)rpc::Retry(
      rpc::Backoff(options.backoff, rpc::FreshSeed()),
      std::numeric_limits<int>::max(), wait, [&] {
        result = Introduce(replica, timeout, cancel);
        return MayCome(result.status())
                   ? absl::UnavailableError(result.status().message())
                   : result.status();
      });
  return result;
}

using Answers = std::vector<std::optional<absl::StatusOr<Introduction>>>;

// Whether there is nothing more to wait for.
bool IsSettled(const Answers& answers, bool one_will_do) {
  bool all = true, any = false;
  for (const auto& answer : answers) {
    if (answer.has_value() && !answer->ok() && !MayCome(answer->status())) {
      return true;
    }
    all = all && answer.has_value();
    any = any || (answer.has_value() && answer->ok());
  }
  return all || (any && one_will_do);
}

// Asks with a thread for each replica; an answer of each, if only that it was
// cut off.
Answers Gather(absl::Span<const std::unique_ptr<Replica>> replicas,
               const IntroductionOptions& options, Clock& clock) {
  const Clock::TimePoint deadline = clock.After(options.patience);
  const Clock::TimePoint one_will_do = clock.After(options.wait_for_all);
  std::stop_source cancel;
  const std::stop_callback stop(options.stop, [&] { cancel.request_stop(); });
  Mutex mu;
  CondVar changed;
  Answers answers(replicas.size());
  {
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < replicas.size(); ++i) {
      threads.emplace_back([&, i] {
        auto answer = AwaitIntroduction(*replicas[i], options, clock, deadline,
                                        cancel.get_token());
        {
          MutexLock lock(mu);
          answers[i] = std::move(answer);
        }
        changed.NotifyAll();
      });
    }
    {
      MutexLock lock(mu);
      // Each thread ends by itself, at the deadline or when stopped.
      while (true) {
        const bool late = clock.SteadyNow() >= one_will_do;
        if (IsSettled(answers, late)) break;
        const Clock::TimePoint wake =
            late ? clock.After(options.patience) : one_will_do;
        clock.WaitUntil(mu, changed, wake, {});
      }
    }
    cancel.request_stop();
  }
  return answers;
}

}  // namespace

absl::StatusOr<Introduction> Introduce(
    const Replica& replica, absl::FunctionRef<absl::Duration()> timeout,
    const std::stop_token& stop) {
  v1::DescribeTeacherRequest request;
  request.set_with_provenance(true);
  Introduction result;
  SINEW_ASSIGN_OR_RETURN(result.description,
                         replica.Describe(request, timeout(), stop));
  SINEW_RETURN_IF_ERROR(CheckDescription(result.description, replica.peer()));
  const std::vector<float> observations =
      SampleRow(result.description.observation_width());
  const std::vector<double> bases(result.description.action_width(), 0.0);
  SINEW_ASSIGN_OR_RETURN(
      const v1::AnnotateResponse answer,
      replica.Annotate(
          MakeRequest(result.description,
                      {.observations = observations, .bases = bases}, 0, 1),
          timeout(), stop));
  result.targets.resize(bases.size());
  result.spread.resize(bases.size());
  SINEW_RETURN_IF_ERROR(ReadAnswer(result.description, answer, replica.peer(),
                                   absl::MakeSpan(result.targets),
                                   absl::MakeSpan(result.spread)));
  return result;
}

absl::Status CheckSameTeacher(const Introduction& expected,
                              const std::string& expected_peer,
                              const Introduction& found,
                              const std::string& found_peer) {
  SINEW_RETURN_IF_ERROR(CheckAlike(expected.description, expected_peer,
                                   found.description, found_peer));
  if (found.targets == expected.targets && found.spread == expected.spread) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(
      absl::StrCat(found_peer, ": expected the same answer to a sample row as ",
                   expected_peer, " gives, found another"));
}

absl::StatusOr<std::vector<std::optional<Introduction>>> IntroduceAll(
    absl::Span<const std::unique_ptr<Replica>> replicas,
    const IntroductionOptions& options, Clock& clock) {
  Answers answers = Gather(replicas, options, clock);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("connecting to teachers was stopped");
  }
  std::vector<std::optional<Introduction>> result(replicas.size());
  std::string text =
      absl::StrCat("no answer within ", absl::FormatDuration(options.patience));
  bool any = false, late = true;
  for (size_t i = 0; i < answers.size(); ++i) {
    const absl::Status status = answers[i]->status();
    if (status.ok()) {
      result[i] = **std::move(answers[i]);
      any = true;
    } else if (MayCome(status)) {
      absl::StrAppend(&text, "; ", status.message());
      late = late && absl::IsDeadlineExceeded(status);
    } else {
      return status;
    }
  }
  if (any) return result;
  return late ? absl::DeadlineExceededError(text)
              : absl::UnavailableError(text);
}

}  // namespace sinew::teacher
