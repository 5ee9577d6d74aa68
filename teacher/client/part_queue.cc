#include "teacher/client/part_queue.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/rpc/status.h"
#include "common/status_macros.h"

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

PartQueue::PartQueue(const Options& options, ReplicaHealth& health,
                     Clock& clock)
    : options_(options),
      health_(health),
      clock_(clock),
      out_(options.peers.size()),
      parts_(options.parts),
      remaining_(options.parts),
      last_success_(clock.SteadyNow()) {
  SINEW_CHECK(options.parts >= 1 && !options.peers.empty());
  for (int64_t part = 0; part < options_.parts; ++part) {
    waiting_.push_back(part);
  }
}

std::optional<int64_t> PartQueue::Take(int replica) {
  MutexLock lock(mu_);
  while (!Ended() && !out_[replica]) {
    const Clock::TimePoint now = clock_.SteadyNow();
    Clock::TimePoint wake = clock_.After(options_.patience);
    const std::optional<Clock::TimePoint> ready = health_.ReadyFrom(replica);
    if (ready.has_value() && now < *ready) {
      wake = *ready;
    } else if (ready.has_value()) {
      int64_t part = TakeWaiting(replica);
      if (part < 0) part = TakeLate(replica, wake);
      if (part >= 0) {
        parts_[part].holders.push_back({.replica = replica, .since = now});
        return part;
      }
    }
    clock_.WaitUntil(mu_, changed_, wake, {});
  }
  return std::nullopt;
}

int64_t PartQueue::TakeWaiting(int replica) {
  for (auto it = waiting_.begin(); it != waiting_.end(); ++it) {
    const int64_t result = *it;
    const Part& part = parts_[result];
    if (IsBarred(replica, part)) continue;
    if (part.failed_by == replica && OtherIsWell(replica, part)) continue;
    waiting_.erase(it);
    return result;
  }
  return -1;
}

int64_t PartQueue::TakeLate(int replica, Clock::TimePoint& wake) {
  const auto late = absl::ToChronoNanoseconds(health_.LateAfter(replica));
  const Clock::TimePoint now = clock_.SteadyNow();
  for (int64_t i = 0; i < options_.parts; ++i) {
    const Part& part = parts_[i];
    if (part.done || part.holders.empty() || IsBarred(replica, part)) continue;
    Clock::TimePoint since = part.holders[0].since;
    bool own = false;
    for (const Holder& holder : part.holders) {
      since = std::max(since, holder.since);
      own = own || holder.replica == replica;
    }
    if (own) continue;
    if (now < since + late) {
      wake = std::min(wake, since + late);
      continue;
    }
    for (const Holder& holder : part.holders) MarkLate(holder);
    // What those who were late failed at need no longer be left to them.
    changed_.NotifyAll();
    return i;
  }
  return -1;
}

void PartQueue::MarkLate(const Holder& holder) {
  // Once is enough: each failure makes it wait longer.
  if (!health_.ReadyFrom(holder.replica).has_value()) return;
  const absl::Duration age =
      absl::FromChrono(clock_.SteadyNow() - holder.since);
  health_.Failed(holder.replica,
                 absl::DeadlineExceededError(absl::StrCat(
                     options_.peers[holder.replica], ": no answer after ",
                     absl::FormatDuration(age), ", which is late")));
}

absl::Duration PartQueue::Release(int replica, Part& part) {
  const auto holder =
      std::ranges::find(part.holders, replica, &Holder::replica);
  SINEW_CHECK(holder != part.holders.end());
  const Clock::TimePoint since = holder->since;
  part.holders.erase(holder);
  return absl::FromChrono(clock_.SteadyNow() - since);
}

bool PartQueue::IsBarred(int replica, const Part& part) const {
  if (part.refused_by.contains(replica)) return true;
  const auto found = part.wrong_answers.find(replica);
  return found != part.wrong_answers.end() && found->second >= kWrongAnswers;
}

bool PartQueue::OtherIsWell(int replica, const Part& part) const {
  for (int i = 0; i < static_cast<int>(out_.size()); ++i) {
    // One that is out may still succeed: with calls from before it was out.
    if (i != replica && !out_[i] && !IsBarred(i, part) && health_.IsWell(i)) {
      return true;
    }
  }
  return false;
}

absl::Status PartQueue::Verdict(const Part& part) const {
  bool all_refused = true;
  for (int i = 0; i < static_cast<int>(out_.size()); ++i) {
    if (out_[i]) continue;
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

bool PartQueue::Done(int replica, int64_t part) {
  bool first = false;
  {
    MutexLock lock(mu_);
    Part& one = parts_[part];
    health_.Answered(replica, Release(replica, one));
    first = !std::exchange(one.done, true);
    if (first) {
      last_success_ = clock_.SteadyNow();
      --remaining_;
    }
  }
  changed_.NotifyAll();
  return first;
}

void PartQueue::Failed(int replica, int64_t part, const absl::Status& status) {
  {
    MutexLock lock(mu_);
    Part& one = parts_[part];
    Release(replica, one);
    health_.Failed(replica, status);
    one.failed_by = replica;
    if (!one.done && one.holders.empty()) waiting_.push_front(part);
    absl::Status judgement = absl::OkStatus();
    if (Judge(replica, one, status)) judgement = PutOut(replica, status);
    if (judgement.ok()) judgement = VerdictOnAll();
    if (status_.ok()) status_ = judgement;
  }
  changed_.NotifyAll();
}

void PartQueue::Introduced(int replica, const absl::Status& status) {
  {
    MutexLock lock(mu_);
    if (!status.ok() && !MayPass(status)) {
      absl::Status judgement = PutOut(replica, status);
      if (judgement.ok()) judgement = VerdictOnAll();
      if (status_.ok()) status_ = judgement;
    }
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

bool PartQueue::Judge(int replica, Part& part, const absl::Status& status) {
  if (absl::IsInvalidArgument(status)) {
    part.refused_by.insert(replica);
    part.last_refusal = status;
  } else if (IsWrongAnswer(status)) {
    ++part.wrong_answers[replica];
    part.last_wrong_answer = status;
  } else {
    return !MayPass(status);
  }
  return false;
}

absl::Status PartQueue::PutOut(int replica, const absl::Status& status) {
  out_[replica] = true;
  return std::ranges::find(out_, false) == out_.end() ? status
                                                      : absl::OkStatus();
}

absl::Status PartQueue::VerdictOnAll() const {
  // Whoever goes out may have been the last that others' parts had.
  for (const int64_t waiting : waiting_) {
    SINEW_RETURN_IF_ERROR(Verdict(parts_[waiting]));
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
  for (size_t i = 0; i < options_.peers.size(); ++i) {
    const absl::Status error = health_.LastError(static_cast<int>(i));
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
