#ifndef SINEW_LEARNER_EXPERIENCE_TESTING_FAKE_REPLAY_H_
#define SINEW_LEARNER_EXPERIENCE_TESTING_FAKE_REPLAY_H_

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/mutex.h"
#include "common/status_macros.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/replay.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "replay/client/replay.h"

namespace sinew::learner {

// A replay that keeps what it is told, may be away and may lose all.
//
// Thread-safety: any thread. Blocking: as replay::Replay; AwaitCaller for 30 s
// at most. Errors: those that a test asks for; test failures.
class FakeReplay final : public replay::Replay {
 public:
  absl::Status Open(const v1::OpenRequest& request,
                    const std::stop_token& stop) override {
    MutexLock lock(mu_);
    SINEW_RETURN_IF_ERROR(AwaitPeer(stop));
    if (request.reset()) {
      segments_.clear();
      expected_.clear();
      has_run_ = true;
    }
    if (!has_run_) return absl::NotFoundError("run");
    for (const auto& expected : request.expected()) {
      expected_[expected.order_id()] = expected;
    }
    requests_.push_back(request);
    return absl::OkStatus();
  }

  absl::StatusOr<v1::PutSegmentResponse> Put(const std::string&,
                                             int64_t order_id,
                                             absl::string_view bytes,
                                             absl::Duration) override {
    auto segment = std::make_shared<v1::Segment>();
    EXPECT_TRUE(segment->ParseFromString(std::string(bytes)));
    MutexLock lock(mu_);
    v1::PutSegmentResponse response;
    response.set_order_id(order_id);
    response.set_verdict(v1::PutSegmentResponse::VERDICT_UNEXPECTED);
    if (away_ || !expected_.contains(order_id)) return response;
    response.set_verdict(v1::PutSegmentResponse::VERDICT_ACCEPTED);
    if (elsewhere_ > 0) {
      --elsewhere_;
      return response;
    }
    segments_[order_id] = std::move(segment);
    ++accepted_;
    changed_.NotifyAll();
    return response;
  }

  absl::StatusOr<std::vector<replay::SegmentPtr>> Take(
      const std::string&, absl::Span<const int64_t> order_ids,
      absl::Duration timeout, const std::stop_token& stop) override {
    const auto deadline =
        std::chrono::steady_clock::now() + absl::ToChronoNanoseconds(timeout);
    MutexLock lock(mu_);
    const std::set<int64_t> ids(order_ids.begin(), order_ids.end());
    std::vector<replay::SegmentPtr> result;
    for (int64_t id : ids) {
      while (!segments_.contains(id)) {
        if (away_) return absl::UnavailableError("replay: nobody is there");
        if (!expected_.contains(id)) {
          return absl::NotFoundError(absl::StrCat("order ", id));
        }
        if (!changed_.WaitUntil(mu_, deadline, stop)) {
          return absl::DeadlineExceededError(absl::StrCat("order ", id));
        }
      }
      result.push_back(segments_[id]);
    }
    return result;
  }

  absl::StatusOr<v1::GetReplayStatusResponse> GetStatus(
      const std::stop_token& stop) override {
    MutexLock lock(mu_);
    SINEW_RETURN_IF_ERROR(AwaitPeer(stop));
    v1::GetReplayStatusResponse status;
    status.set_accepted(accepted_);
    for (const auto& [id, expected] : expected_) {
      if (!segments_.contains(id)) status.add_missing_order_ids(id);
    }
    return status;
  }

  // Nobody is there, and calls wait for the peer until they are stopped.
  void Hang() {
    MutexLock lock(mu_);
    hangs_ = away_ = true;
    changed_.NotifyAll();
  }
  // Returns once somebody waits so.
  void AwaitCaller() {
    MutexLock lock(mu_);
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (waiting_ == 0 && changed_.WaitUntil(mu_, deadline)) {
    }
    EXPECT_GT(waiting_, 0) << "nobody calls replay";
  }
  void SetAway(bool away) {
    MutexLock lock(mu_);
    away_ = away;
    changed_.NotifyAll();
  }
  // So many segments are put to another replay, which takes them.
  void PutElsewhere(int count) {
    MutexLock lock(mu_);
    elsewhere_ = count;
  }
  void Forget() {
    MutexLock lock(mu_);
    segments_.clear();
    expected_.clear();
    changed_.NotifyAll();
  }
  void Restart() {
    Forget();
    MutexLock lock(mu_);
    has_run_ = false;
  }
  std::vector<v1::OpenRequest> requests() {
    MutexLock lock(mu_);
    return requests_;
  }

 private:
  absl::Status AwaitPeer(const std::stop_token& stop) SINEW_REQUIRES(mu_) {
    if (!away_) return absl::OkStatus();
    ++waiting_;
    changed_.NotifyAll();
    while (hangs_ && changed_.Wait(mu_, stop)) {
    }
    return hangs_ ? absl::CancelledError("replay: cancelled")
                  : absl::UnavailableError("replay: nobody is there");
  }

  Mutex mu_;
  CondVar changed_;
  bool hangs_ SINEW_GUARDED_BY(mu_) = false;
  int waiting_ SINEW_GUARDED_BY(mu_) = 0;
  bool away_ SINEW_GUARDED_BY(mu_) = false;
  bool has_run_ SINEW_GUARDED_BY(mu_) = false;
  int elsewhere_ SINEW_GUARDED_BY(mu_) = 0;
  int64_t accepted_ SINEW_GUARDED_BY(mu_) = 0;
  std::map<int64_t, v1::OpenRequest::Expected> expected_ SINEW_GUARDED_BY(mu_);
  std::map<int64_t, replay::SegmentPtr> segments_ SINEW_GUARDED_BY(mu_);
  std::vector<v1::OpenRequest> requests_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_EXPERIENCE_TESTING_FAKE_REPLAY_H_
