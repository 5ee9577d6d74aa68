#include "teacher/client/part_queue.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/rpc/status.h"

namespace sinew::teacher {
namespace {

// Wrong answers of one replica to one part that bar it from that part.
constexpr int kWrongAnswers = 3;

// INTERNAL is what gRPC makes of broken connections, among others.
bool IsWrongAnswer(const absl::Status& status) {
  return absl::IsDataLoss(status);
}

// Whether the replica may do better later.
bool MayPass(const absl::Status& status) {
  return rpc::IsTransient(status) || IsWrongAnswer(status) ||
         absl::IsResourceExhausted(status);
}

}  // namespace

PartQueue::PartQueue(const Options& options, Clock& clock)
    : options_(options),
      clock_(clock),
      parts_(options.parts),
      remaining_(options.parts),
      last_success_(clock.SteadyNow()) {
  SINEW_CHECK(options.parts >= 1 && !options.peers.empty());
  for (size_t i = 0; i < options_.peers.size(); ++i) {
    replicas_.push_back({.backoff = rpc::Backoff(options_.backoff, i + 1),
                         .not_before = last_success_});
  }
  for (int64_t part = 0; part < options_.parts; ++part) {
    waiting_.push_back(part);
  }
}

std::optional<int64_t> PartQueue::Take(int replica) {
  MutexLock lock(mu_);
  while (!Ended() && !replicas_[replica].out) {
    Clock::TimePoint wake = replicas_[replica].not_before;
    if (clock_.SteadyNow() >= wake) {
      const int found = Find(replica);
      if (found >= 0) {
        const int64_t part = waiting_[found];
        waiting_.erase(waiting_.begin() + found);
        return part;
      }
      wake = clock_.After(options_.patience);
    }
    clock_.WaitUntil(mu_, changed_, wake, {});
  }
  return std::nullopt;
}

int PartQueue::Find(int replica) const {
  for (size_t i = 0; i < waiting_.size(); ++i) {
    const Part& part = parts_[waiting_[i]];
    if (IsBarred(replica, part)) continue;
    if (part.failed_by != replica || !OtherIsWell(replica, part)) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

bool PartQueue::IsBarred(int replica, const Part& part) const {
  if (part.refused_by.contains(replica)) return true;
  const auto found = part.wrong_answers.find(replica);
  return found != part.wrong_answers.end() && found->second >= kWrongAnswers;
}

bool PartQueue::OtherIsWell(int replica, const Part& part) const {
  for (int i = 0; i < static_cast<int>(replicas_.size()); ++i) {
    const Replica& one = replicas_[i];
    // One that is out may still succeed: with calls from before it was out.
    if (i != replica && one.well && !one.out && !IsBarred(i, part)) return true;
  }
  return false;
}

absl::Status PartQueue::Verdict(const Part& part) const {
  bool all_refused = true;
  for (int i = 0; i < static_cast<int>(replicas_.size()); ++i) {
    if (replicas_[i].out) continue;
    if (!IsBarred(i, part)) return absl::OkStatus();
    all_refused = all_refused && part.refused_by.contains(i);
  }
  if (all_refused) return part.last_refusal;
  return absl::InternalError(
      absl::StrCat("a part has ", kWrongAnswers,
                   " wrong answers from every teacher that there is",
                   part.refused_by.empty() ? "" : " and does not refuse it",
                   ", the last: ", part.last_wrong_answer.message()));
}

void PartQueue::Done(int replica) {
  {
    MutexLock lock(mu_);
    replicas_[replica].well = true;
    replicas_[replica].backoff.Reset();
    last_success_ = clock_.SteadyNow();
    --remaining_;
  }
  changed_.NotifyAll();
}

void PartQueue::Failed(int replica, int64_t part, const absl::Status& status) {
  {
    MutexLock lock(mu_);
    Replica& one = replicas_[replica];
    one.last_error = status;
    one.well = false;
    one.not_before = clock_.After(one.backoff.Next());
    parts_[part].failed_by = replica;
    waiting_.push_front(part);
    const absl::Status judgement = Judge(replica, parts_[part], status);
    if (status_.ok()) status_ = judgement;
  }
  changed_.NotifyAll();
}

void PartQueue::End(const absl::Status& status) {
  {
    MutexLock lock(mu_);
    if (status_.ok()) status_ = status;
  }
  changed_.NotifyAll();
}

absl::Status PartQueue::Judge(int replica, Part& part,
                              const absl::Status& status) {
  if (absl::IsInvalidArgument(status)) {
    part.refused_by.insert(replica);
    part.last_refusal = status;
  } else if (IsWrongAnswer(status)) {
    ++part.wrong_answers[replica];
    part.last_wrong_answer = status;
  } else if (!MayPass(status)) {
    replicas_[replica].out = true;
    const bool others =
        std::any_of(replicas_.begin(), replicas_.end(),
                    [](const Replica& one) { return !one.out; });
    if (!others) return status;
  }
  // Whoever goes out may have been the last that others' parts had.
  for (const int64_t waiting : waiting_) {
    const absl::Status verdict = Verdict(parts_[waiting]);
    if (!verdict.ok()) return verdict;
  }
  return absl::OkStatus();
}

absl::Status PartQueue::Await(const std::stop_token& stop) {
  absl::Status result;
  {
    MutexLock lock(mu_);
    while (!Ended()) {
      const Clock::TimePoint deadline =
          last_success_ + absl::ToChronoNanoseconds(options_.patience);
      if (stop.stop_requested()) {
        status_ = absl::CancelledError("annotating was stopped");
      } else if (clock_.SteadyNow() >= deadline) {
        status_ = OutOfPatience();
      } else {
        clock_.WaitUntil(mu_, changed_, deadline, stop);
      }
    }
    result = status_;
  }
  changed_.NotifyAll();
  return result;
}

absl::Status PartQueue::OutOfPatience() const {
  std::string text = absl::StrCat(
      "no teacher answered within ", absl::FormatDuration(options_.patience),
      ", ", remaining_, " of ", options_.parts, " parts are missing");
  bool late = true;
  for (size_t i = 0; i < replicas_.size(); ++i) {
    const absl::Status& error = replicas_[i].last_error;
    late = late && (error.ok() || absl::IsDeadlineExceeded(error));
    // Errors of a peer begin with its name.
    absl::StrAppend(&text, "; ",
                    error.ok() ? absl::StrCat(options_.peers[i], ": no error")
                               : std::string(error.message()));
  }
  return late ? absl::DeadlineExceededError(text)
              : absl::UnavailableError(text);
}

}  // namespace sinew::teacher
