#ifndef SINEW_LEARNER_TRAINER_TESTING_FAKE_EXPERIENCE_H_
#define SINEW_LEARNER_TRAINER_TESTING_FAKE_EXPERIENCE_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "learner/ppo/synthetic_segments.h"
#include "learner/trainer/experience.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::learner {

// Experience without actors: a training segment is that of the synthetic
// problem (synthetic_segments.h), acted with the snapshot that the order names;
// end states count steps, every environment ends an episode in each segment,
// in turn for each reason. An evaluation succeeds from snapshot
// `success_version` on.
//
// Like the real ones, segments are a pure function of orders and snapshots;
// only the latest three snapshots are kept. What happens is written down:
//
//   "publish 0" "begin train 0 with 0" "take train 0" "begin evaluate 2 with 2"
//
// Thread-safety: one caller. Blocking: computes. Errors: `next_take` once;
// NOT_FOUND for orders that were not begun, FAILED_PRECONDITION for a snapshot
// that is not there.
class FakeExperience final : public Experience {
 public:
  explicit FakeExperience(const SyntheticProblem& problem)
      : problem_(problem) {}

  absl::Status Publish(const PublishedSnapshot& snapshot) override;
  absl::Status Begin(const std::vector<v1::Order>& orders) override;
  absl::StatusOr<std::vector<v1::Segment>> Take(
      const std::vector<int64_t>& order_ids) override;

  // What the next Take returns if it is an error.
  absl::Status next_take;
  int64_t success_version = 0;
  // Whether every other environment's episodes begin carried on.
  bool carried = false;

  const std::vector<std::string>& log() const { return log_; }
  // All that were begun, in order.
  const std::vector<v1::Order>& orders() const { return orders_; }
  const std::vector<PublishedSnapshot>& published() const { return published_; }

 private:
  v1::Segment Train(const v1::Order& order, const PublishedSnapshot& snapshot);
  v1::Segment Evaluate(const v1::Order& order) const;

  const SyntheticProblem problem_;
  std::vector<std::string> log_;
  std::vector<v1::Order> orders_;
  std::vector<PublishedSnapshot> published_;
  std::map<int64_t, v1::Order> open_;
};

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_TRAINER_TESTING_FAKE_EXPERIENCE_H_
