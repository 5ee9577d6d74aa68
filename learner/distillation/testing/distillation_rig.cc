#include "learner/distillation/testing/distillation_rig.h"

#include <cmath>
#include <map>
#include <utility>

#include "common/digest.h"
#include "common/random/philox.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "learner/distillation/testing/zero_columns.h"
#include "learner/learner.h"
#include "proto/sinew/v1/training_state.pb.h"

namespace sinew::learner {
namespace {

constexpr float kShift = 3, kSpread = 2;

std::vector<float> Normal(uint64_t seed, uint64_t step, int64_t size) {
  std::vector<float> values(size);
  FillNormal({.seed = seed, .step = step}, absl::MakeSpan(values));
  return values;
}

template <typename T>
std::string Bytes(const std::vector<T>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()),
                     values.size() * sizeof(T));
}

using Columns = std::map<std::string, std::string>;

// Bytes of the columns that are not 0, by name.
Columns DrawColumns(const Visited& visited, uint64_t seed) {
  const int64_t rows = int64_t{kHorizon} * visited.environments;
  std::vector<float> observations = Normal(seed, 1, rows * kObservation);
  for (float& value : observations) value = kShift + kSpread * value;
  std::vector<double> teacher_base, base;
  for (const float value : Normal(seed, 2, rows * kAction)) {
    teacher_base.push_back(0.1 * value);
    base.push_back(0.1 * value - 0.2);
  }
  std::vector<float> uniform(rows);
  FillUniform({.seed = seed, .step = 3}, absl::MakeSpan(uniform));
  std::vector<uint8_t> valid, terminated;
  for (const float u : uniform) {
    valid.push_back(u >= visited.invalid_share);
    terminated.push_back(u < visited.invalid_share + visited.terminated_share);
  }
  return {{"observation", Bytes(observations)},
          {"teacher_base", Bytes(teacher_base)},
          {"base", Bytes(base)},
          {"reward", Bytes(std::vector<float>(rows, 0.5F))},
          {"valid", Bytes(valid)},
          {"terminated", Bytes(terminated)}};
}

v1::Segment MakeSegment(const Visited& visited, int64_t iteration, int order) {
  const Columns data =
      DrawColumns(visited, visited.seed + 1000 * iteration + order);
  v1::Segment segment;
  segment.set_order_id(10 * iteration + order);
  segment.set_kind(v1::Order::KIND_TRAIN);
  segment.set_iteration(iteration);
  AddZeroColumns(StudentLayout(), kHorizon, visited.environments, segment);
  for (v1::Tensor& column : *segment.mutable_columns()) {
    const auto found = data.find(column.name());
    if (found != data.end()) column.set_data(found->second);
  }
  return segment;
}

}  // namespace

SyntheticTeacher::SyntheticTeacher() : spread_(kAction, 0.01) {
  description_.set_bundle_sha256("synthetic");
  description_.set_observation_width(kObservation);
  description_.set_action_width(kAction);
}

absl::Status SyntheticTeacher::Annotate(const teacher::Rows& rows,
                                        absl::Span<double> targets) {
  if (!failure.ok()) return failure;
  const int64_t count = static_cast<int64_t>(targets.size()) / kAction;
  rows_seen += count;
  ++calls;
  const std::vector<float> w = Normal(99, 0, kAction * kObservation);
  for (int64_t r = 0; r < count; ++r) {
    for (int64_t a = 0; a < kAction; ++a) {
      double sum = 0;
      for (int64_t o = 0; o < kObservation; ++o) {
        sum += w[a * kObservation + o] *
               (rows.observations[r * kObservation + o] - kShift) / kSpread;
      }
      targets[r * kAction + a] =
          answers ? *answers
                  : rows.bases[r * kAction + a] +
                        0.3 * std::tanh(sum / std::sqrt(kObservation));
    }
  }
  return absl::OkStatus();
}

v1::SegmentLayout StudentLayout() {
  return MakeSegmentLayout(kObservation, kAction, /*distillation=*/true);
}

std::vector<v1::Segment> MakeVisited(int64_t iteration,
                                     const Visited& visited) {
  std::vector<v1::Segment> segments;
  for (int order = 0; order < visited.orders; ++order) {
    segments.push_back(MakeSegment(visited, iteration, order));
  }
  return segments;
}

std::vector<const v1::Segment*> SegmentPointers(
    const std::vector<v1::Segment>& segments) {
  std::vector<const v1::Segment*> pointers;
  for (const v1::Segment& segment : segments) pointers.push_back(&segment);
  return pointers;
}

std::vector<double> StudentScale() { return {0.5, 0.25}; }

std::unique_ptr<DistillationLearner> MakeStudentLearner(
    const v1::Recipe& recipe, teacher::Annotator& teacher, int ranks,
    const std::optional<SegmentMirror>& mirror) {
  auto learner =
      DistillationLearner::Create(recipe, {.observation_width = kObservation,
                                           .self_observation_width = kOwn,
                                           .action_width = kAction,
                                           .ranks = ranks,
                                           .annotator = &teacher,
                                           .layout = StudentLayout(),
                                           .action_scale = StudentScale(),
                                           .mirror = mirror});
  EXPECT_THAT(learner.status(), sinew::testing::IsOk());
  return learner.ok() ? *std::move(learner) : nullptr;
}

std::string Bits(const Learner& learner) {
  v1::TrainingState state;
  learner.SaveCounters(state);
  std::string all = SerializeSafetensors(learner.SaveTensors()) +
                    SerializeDeterministically(state);
  for (const StateChunk& chunk : learner.SaveChunks()) all += chunk.sha256;
  return Sha256Hex(all);
}

}  // namespace sinew::learner
