#include "learner/distillation/labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "common/segment/episode_actor.h"
#include "common/segment/segment_layout.h"
#include "common/testing/matchers.h"
#include "learner/distillation/testing/zero_columns.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int64_t kSteps = 3, kEnvironments = 2;

LabelOptions Options() {
  return {.layout = MakeSegmentLayout(1, 1, /*distillation=*/true),
          .shape = {.steps = kSteps, .observation = 1, .action = 1},
          .action_scale = {0.5}};
}

template <typename T>
void SetColumn(const char* name, const std::vector<T>& values,
               v1::Segment& segment) {
  v1::Tensor* column = FindColumn(segment, name);
  ASSERT_NE(column, nullptr) << name;
  column->set_data(std::string(reinterpret_cast<const char*>(values.data()),
                               values.size() * sizeof(T)));
}

// Rows i = 0 ... 5, one step's two environments after another's, all valid:
// observation i, teacher's base i / 2, student's base 1.
v1::Segment MakeSegment(int64_t order_id) {
  v1::Segment segment;
  segment.set_order_id(order_id);
  AddZeroColumns(Options().layout, kSteps, kEnvironments, segment);
  SetColumn<float>("observation", {0, 1, 2, 3, 4, 5}, segment);
  SetColumn<double>("teacher_base", {0, 0.5, 1, 1.5, 2, 2.5}, segment);
  SetColumn<double>("base", {1, 1, 1, 1, 1, 1}, segment);
  SetColumn<uint8_t>("valid", {1, 1, 1, 1, 1, 1}, segment);
  return segment;
}

// Its target is twice the observation more than the base.
class Doubling : public teacher::Annotator {
 public:
  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return spread_; }
  absl::Status Annotate(const teacher::Rows& rows,
                        absl::Span<double> targets) override {
    seen.insert(seen.end(), rows.observations.begin(), rows.observations.end());
    clips.insert(clips.end(), rows.clips.begin(), rows.clips.end());
    for (size_t i = 0; i < targets.size(); ++i) {
      targets[i] = rows.bases[i] + 2 * rows.observations[i];
    }
    return absl::OkStatus();
  }

  std::vector<float> seen;
  std::vector<int32_t> clips;

 private:
  v1::DescribeTeacherResponse description_;
  const std::vector<double> spread_ = {0.01};
};

SegmentView View(const v1::Segment& segment) {
  const auto view = ViewForLabels(segment, Options());
  EXPECT_THAT(view.status(), IsOk());
  return view.ok() ? *view : SegmentView();
}

// Of one segment.
LabelledSequences Label(const v1::Segment& segment) {
  Doubling teacher;
  const SegmentView view = View(segment);
  const auto targets = AskTargets({&segment}, {view}, Options(), teacher);
  EXPECT_THAT(targets.status(), IsOk());
  const auto labelled = LabelSegment(segment, view, Options(), *targets);
  EXPECT_THAT(labelled.status(), IsOk());
  return labelled.ok() ? *labelled : LabelledSequences();
}

TEST(Labels, AreInTheStudentsUnitsSequenceAfterSequence) {
  const LabelledSequences labelled = Label(MakeSegment(7));

  EXPECT_EQ(labelled.order_id, 7);
  EXPECT_THAT(labelled.observation, ElementsAre(0, 2, 4, 1, 3, 5));
  // (2.5 i - 1) / 0.5.
  EXPECT_THAT(labelled.label, ElementsAre(-2, 8, 18, 3, 13, 23));
  EXPECT_THAT(labelled.valid, ElementsAre(1, 1, 1, 1, 1, 1));
  EXPECT_THAT(labelled.linked, ElementsAre(0, 1, 1, 0, 1, 1));
}

TEST(Labels, AreLinkedNeitherAcrossEpisodesNorToRowsThatAreNotValid) {
  v1::Segment ended = MakeSegment(7);
  SetColumn<uint8_t>("terminated", {1, 0, 0, 0, 0, 0}, ended);
  EXPECT_THAT(Label(ended).linked, ElementsAre(0, 0, 1, 0, 1, 1));

  v1::Segment invalid = MakeSegment(7);
  SetColumn<uint8_t>("valid", {1, 1, 1, 0, 1, 1}, invalid);
  const LabelledSequences labelled = Label(invalid);
  EXPECT_THAT(labelled.linked, ElementsAre(0, 1, 1, 0, 0, 0));
  EXPECT_THAT(labelled.valid, ElementsAre(1, 1, 1, 1, 0, 1));
  EXPECT_THAT(labelled.label, ElementsAre(-2, 8, 18, 3, 0, 23));
}

TEST(Labels, AreNotLinkedAcrossATruncation) {
  const v1::Segment segment = MakeSegment(7);
  const std::vector<uint8_t> truncated = {0, 1, 0, 0, 0, 0};
  SegmentView view = View(segment);
  view.truncated = truncated;

  const auto labelled =
      LabelSegment(segment, view, Options(), std::vector<double>(6, 1.0));

  ASSERT_THAT(labelled.status(), IsOk());
  EXPECT_THAT(labelled->linked, ElementsAre(0, 1, 1, 0, 0, 1));
}

TEST(Labels, OfSeveralSegmentsAreAskedForInOneCallWithoutInvalidRows) {
  v1::Segment one = MakeSegment(7), two = MakeSegment(8);
  SetColumn<uint8_t>("valid", {1, 0, 1, 1, 1, 1}, one);
  SetColumn<uint8_t>("valid", {0, 1, 1, 1, 0, 1}, two);
  SetColumn<float>("observation", {10, 11, 12, 13, 14, 15}, two);
  SetColumn<int32_t>("clip", {0, 1, 2, 3, 4, 5}, one);
  SetColumn<int32_t>("clip", {6, 7, 8, 9, 10, 11}, two);
  Doubling teacher;

  const auto targets =
      AskTargets({&one, &two}, {View(one), View(two)}, Options(), teacher);

  ASSERT_THAT(targets.status(), IsOk());
  EXPECT_THAT(teacher.seen, ElementsAre(0, 2, 3, 4, 5, 11, 12, 13, 15));
  EXPECT_THAT(teacher.clips, ElementsAre(0, 2, 3, 4, 5, 7, 8, 9, 11));
  const auto labelled = LabelSegment(
      two, View(two), Options(),
      absl::MakeConstSpan(*targets).subspan(CountValid(View(one))));
  ASSERT_THAT(labelled.status(), IsOk());
  // (2 (10 + i) + i / 2 - 1) / 0.5.
  EXPECT_THAT(labelled->label, ElementsAre(0, 48, 0, 43, 53, 63));
}

// Environments 10 and 11; the first begins another episode at its last step.
TEST(NormaliserRows, AreValidAndNotOfThePrior) {
  v1::Segment segment = MakeSegment(7);
  SetColumn<uint8_t>("terminated", {0, 0, 1, 0, 0, 0}, segment);
  SetColumn<uint8_t>("valid", {1, 1, 1, 1, 1, 0}, segment);
  segment.add_end_states()->set_episode(6);
  segment.add_end_states()->set_episode(2);
  LabelOptions options = Options();
  EXPECT_THAT(NormaliserRows(segment, View(segment), 10, options),
              IsOkAndHolds(ElementsAre(1, 1, 1, 1, 1, 0)));
  options.distillation.set_prior_share(0.5);
  std::set<std::vector<uint8_t>> seen;

  for (options.seed = 0; options.seed < 64; ++options.seed) {
    const auto student = [&](int64_t environment, int64_t episode) {
      return WhoActs(options.distillation, options.seed, environment,
                     episode) != EpisodeActor::kPrior;
    };
    const auto counts = NormaliserRows(segment, View(segment), 10, options);
    ASSERT_THAT(counts.status(), IsOk());
    EXPECT_THAT(*counts,
                ElementsAre(student(10, 5), student(11, 2), student(10, 5),
                            student(11, 2), student(10, 6), false));
    seen.insert(*counts);
  }
  EXPECT_EQ(seen.size(), 8);
}

TEST(NormaliserRows, RefuseEndStatesThatDoNotFit) {
  const v1::Segment segment = MakeSegment(7);  // has none
  LabelOptions options = Options();
  options.distillation.set_prior_share(0.5);

  EXPECT_THAT(NormaliserRows(segment, View(segment), 0, options).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("order 7: end_states: expected 2")));
}

TEST(Labels, AreRefusedWhereFloat32HasNoSuchNumber) {
  const v1::Segment segment = MakeSegment(7);
  std::vector<double> targets(6, 1.0);
  targets[4] = 1e300;

  EXPECT_THAT(LabelSegment(segment, View(segment), Options(), targets).status(),
              StatusIs(absl::StatusCode::kInternal,
                       AllOf(HasSubstr("order 7: row 4, joint 0"),
                             HasSubstr("float32"))));
}

TEST(Labels, NeedFiniteObservationsAndBases) {
  v1::Segment blind = MakeSegment(7), lost = MakeSegment(8);
  SetColumn<float>("observation",
                   {0, 1, std::numeric_limits<float>::infinity(), 3, 4, 5},
                   blind);
  SetColumn<double>(
      "base", {1, 1, 1, std::numeric_limits<double>::quiet_NaN(), 1, 1}, lost);

  EXPECT_THAT(
      ViewForLabels(blind, Options()).status(),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("order 7: segment column observation: row 2")));
  EXPECT_THAT(ViewForLabels(lost, Options()).status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("order 8: segment column base: row 3")));
}

}  // namespace
}  // namespace sinew::learner
