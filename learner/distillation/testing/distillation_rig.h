#ifndef SINEW_LEARNER_DISTILLATION_TESTING_DISTILLATION_RIG_H_
#define SINEW_LEARNER_DISTILLATION_TESTING_DISTILLATION_RIG_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "common/segment/mirror.h"
#include "learner/distillation/distillation_learner.h"
#include "learner/distillation/testing/student_recipe.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/teacher.pb.h"
#include "teacher/client/annotator.h"

namespace sinew::learner {

// A teacher whose target is base + 0.3 tanh(W observation'), with a fixed W and
// the standardised observation'. Any thread.
class SyntheticTeacher : public teacher::Annotator {
 public:
  SyntheticTeacher();

  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return spread_; }
  absl::Status Annotate(const teacher::Rows& rows,
                        absl::Span<double> targets) override;

  v1::DescribeTeacherResponse& mutable_description() { return description_; }

  // What it answers from now on: an error, or this number in all targets.
  absl::Status failure;
  std::optional<double> answers;
  std::atomic<int64_t> rows_seen = 0;
  std::atomic<int64_t> calls = 0;

 private:
  v1::DescribeTeacherResponse description_;
  const std::vector<double> spread_;
};

// Of segments with the columns that distillations add.
v1::SegmentLayout StudentLayout();

// The segments of an iteration: observations are drawn anew for every step from
// N(3, 2^2); episodes end, and rows are not valid, at random.
struct Visited {
  uint64_t seed = 1;
  int orders = 4;
  int environments = 4;
  double terminated_share = 0.05;
  double invalid_share = 0.05;  // also terminated
};
std::vector<v1::Segment> MakeVisited(int64_t iteration,
                                     const Visited& visited = {});
std::vector<const v1::Segment*> SegmentPointers(
    const std::vector<v1::Segment>& segments);

std::unique_ptr<DistillationLearner> MakeStudentLearner(
    const v1::Recipe& recipe, teacher::Annotator& teacher, int ranks = 2,
    const std::optional<SegmentMirror>& mirror = std::nullopt);

// Radians per unit of action.
std::vector<double> StudentScale();

// Digest of all bits of a learner.
std::string Bits(const Learner& learner);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_DISTILLATION_TESTING_DISTILLATION_RIG_H_
