#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/policy/safetensors.h"
#include "common/segment/mirror.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "learner/distillation/distillation_learner.h"
#include "learner/distillation/testing/distillation_rig.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A learner after one update.
class DistillationInput : public ::testing::Test {
 protected:
  void SetUp() override {
    learner_ = MakeStudentLearner(StudentRecipe(), teacher_);
    ASSERT_NE(learner_, nullptr);
    const auto segments = MakeVisited(0);
    ASSERT_THAT(learner_->Update(SegmentPointers(segments), 0).status(),
                IsOk());
    bits_ = Bits(*learner_);
  }

  absl::Status Update(const std::vector<v1::Segment>& segments) {
    return learner_->Update(SegmentPointers(segments), 1).status();
  }

  SyntheticTeacher teacher_;
  std::unique_ptr<DistillationLearner> learner_;
  std::string bits_;
};

TEST_F(DistillationInput, StaysAsItWasWhereTheTeacherFailsAndGoesOnAfterwards) {
  const auto segments = MakeVisited(1);
  teacher_.failure = absl::UnavailableError("peer unix:/none: refused");

  EXPECT_THAT(
      learner_->Prepare(SegmentPointers(segments)),
      StatusIs(absl::StatusCode::kUnavailable,
               AllOf(HasSubstr("orders 10 to 13"), HasSubstr("unix:/none"))));
  EXPECT_THAT(Update(segments), StatusIs(absl::StatusCode::kUnavailable));
  EXPECT_EQ(Bits(*learner_), bits_);

  teacher_.failure = absl::OkStatus();
  EXPECT_THAT(Update(segments), IsOk());
  EXPECT_NE(Bits(*learner_), bits_);
}

TEST_F(DistillationInput, RefusesLabelsThatAreNotFinite) {
  teacher_.answers = std::numeric_limits<double>::quiet_NaN();

  EXPECT_THAT(Update(MakeVisited(1)),
              StatusIs(absl::StatusCode::kInternal,
                       AllOf(HasSubstr("teacher synthetic"),
                             HasSubstr("expected a finite target"))));
  EXPECT_EQ(Bits(*learner_), bits_);
}

TEST_F(DistillationInput, RefusesLabelsThatFloat32HasNot) {
  teacher_.answers = 1e300;

  EXPECT_THAT(Update(MakeVisited(1)),
              StatusIs(absl::StatusCode::kInternal,
                       AllOf(HasSubstr("order 10: row "),
                             HasSubstr("the range of float32"))));
  EXPECT_EQ(Bits(*learner_), bits_);
}

TEST_F(DistillationInput, RefusesAStateThatFailsLateAndStaysAsItWas) {
  const auto other = MakeStudentLearner(StudentRecipe("seed: 8"), teacher_);
  const auto segments = MakeVisited(5);
  ASSERT_THAT(other->Update(SegmentPointers(segments), 0).status(), IsOk());
  v1::TrainingState state;
  other->SaveCounters(state);
  const std::vector<StateChunk> chunks = other->SaveChunks();

  TensorMap lacks = other->SaveTensors();
  lacks.erase("adam/second_moment/decoder/action/weight");
  EXPECT_FALSE(learner_->Load(lacks, state, chunks).ok());
  EXPECT_EQ(Bits(*learner_), bits_);

  EXPECT_THAT(learner_->Load(other->SaveTensors(), state, {}),
              StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_EQ(Bits(*learner_), bits_);
}

TEST_F(DistillationInput, RefusesSegmentsOfAnotherLayoutOrLength) {
  auto without = MakeVisited(1);
  without[2].mutable_columns(0)->set_name("another");
  auto shorter = MakeVisited(1);
  shorter[1].clear_columns();

  EXPECT_THAT(Update(without), StatusIs(absl::StatusCode::kInvalidArgument,
                                        HasSubstr("order 12")));
  EXPECT_THAT(Update(shorter), StatusIs(absl::StatusCode::kInvalidArgument,
                                        HasSubstr("order 11")));
  EXPECT_THAT(Update({}), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(Bits(*learner_), bits_);
}

TEST_F(DistillationInput, RefusesEndStatesThatDoNotFitBeforeItAsksForLabels) {
  const auto learner = MakeStudentLearner(
      StudentRecipe("distillation { prior_share: 0.5 }"), teacher_);
  const int64_t calls = teacher_.calls;
  const auto segments = MakeVisited(1);  // have no end states

  EXPECT_THAT(learner->Prepare(SegmentPointers(segments)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("order 10: end_states: expected 4")));
  EXPECT_EQ(teacher_.calls, calls);
}

TEST_F(DistillationInput, RefusesAStateThatIsDamagedAndStaysAsItWas) {
  v1::TrainingState state;
  learner_->SaveCounters(state);
  const TensorMap tensors = learner_->SaveTensors();
  std::vector<StateChunk> chunks = learner_->SaveChunks();

  TensorMap infinite = tensors;
  infinite.at("encoder/mean/bias").mutable_float32()[0] =
      std::numeric_limits<float>::infinity();
  EXPECT_THAT(learner_->Load(infinite, state, chunks),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("encoder/mean/bias")));
  TensorMap missing = tensors;
  missing.erase("normaliser_sums/mean");
  EXPECT_THAT(learner_->Load(missing, state, chunks),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("normaliser_sums/mean")));
  chunks[0].bytes = std::make_shared<const std::string>("another");
  EXPECT_THAT(learner_->Load(tensors, state, chunks),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("memory-" + chunks[0].sha256)));
  EXPECT_EQ(Bits(*learner_), bits_);
}

TEST(DistillationOptions, AreRefusedByNameWhereTheyDoNotFit) {
  SyntheticTeacher teacher;
  const DistillationLearner::Options good = {.observation_width = kObservation,
                                             .self_observation_width = kOwn,
                                             .action_width = kAction,
                                             .ranks = 1,
                                             .annotator = &teacher,
                                             .layout = StudentLayout(),
                                             .action_scale = StudentScale()};
  const auto create = [](const DistillationLearner::Options& options) {
    return DistillationLearner::Create(StudentRecipe(), options).status();
  };
  ASSERT_THAT(create(good), IsOk());

  auto no_ranks = good;
  no_ranks.ranks = 0;
  EXPECT_THAT(create(no_ranks),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("ranks")));
  auto no_teacher = good;
  no_teacher.annotator = nullptr;
  EXPECT_THAT(create(no_teacher), StatusIs(absl::StatusCode::kInvalidArgument,
                                           HasSubstr("no teacher")));
  auto no_base = good;
  for (auto& one : *no_base.layout.mutable_columns()) {
    if (one.name() == column::kBase) one.set_name("another");
  }
  EXPECT_THAT(create(no_base), StatusIs(absl::StatusCode::kInvalidArgument,
                                        HasSubstr("column base")));
  auto no_scale = good;
  no_scale.action_scale[1] = 0;
  EXPECT_THAT(create(no_scale), StatusIs(absl::StatusCode::kInvalidArgument,
                                         HasSubstr("action_scale")));
  teacher.mutable_description().set_observation_width(9);
  EXPECT_THAT(create(good), StatusIs(absl::StatusCode::kInvalidArgument,
                                     AllOf(HasSubstr("teacher synthetic"),
                                           HasSubstr("found 9"))));
}

TEST(DistillationInputs, OfMirrorImagesAreTheTasksMirror) {
  SyntheticTeacher teacher;
  const auto create = [&](const std::optional<SegmentMirror>& mirror) {
    return DistillationLearner::Create(
               StudentRecipe("distillation { mirror: true }"),
               {.observation_width = kObservation,
                .self_observation_width = kOwn,
                .action_width = kAction,
                .annotator = &teacher,
                .layout = StudentLayout(),
                .action_scale = StudentScale(),
                .mirror = mirror})
        .status();
  };

  EXPECT_THAT(create(std::nullopt),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("recipe field distillation.mirror")));
  EXPECT_THAT(create(SegmentMirror{.observation = {{0}, {1}},
                                   .action = {{1, 0}, {1, 1}}}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected 6 observation and 2 action columns, "
                                 "found 1 and 2")));
}

}  // namespace
}  // namespace sinew::learner
