#include "teacher/clip_annotator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "common/testing/matchers.h"
#include "teacher/local_annotator.h"
#include "teacher/testing/toy_teacher.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MakeToyRows;
using testing::MakeToyTeacher;
using testing::ToyRows;

constexpr int kNone = ClipAnnotator::kNone;

TeacherPolicy Toy(uint64_t seed) {
  TeacherPolicy policy = MakeToyTeacher(seed);
  policy.manifest.set_manifest_sha256(
      std::string(64, static_cast<char>('a' + seed)));
  return policy;
}

// A teacher that is only described.
class Described final : public Annotator {
 public:
  Described(const std::string& bundle, int64_t observation_width,
            int32_t max_rows, std::vector<double> spread)
      : spread_(std::move(spread)) {
    description_.set_bundle_sha256(bundle);
    description_.set_observation_width(observation_width);
    description_.set_action_width(static_cast<int64_t>(spread_.size()));
    description_.set_max_rows(max_rows);
  }
  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return spread_; }
  absl::Status Annotate(const Rows&, absl::Span<double>) override {
    return absl::UnavailableError("teacher away");
  }

 private:
  v1::DescribeTeacherResponse description_;
  const std::vector<double> spread_;
};

absl::StatusOr<std::unique_ptr<ClipAnnotator>> MakeDescribed(
    std::unique_ptr<Described> first, std::unique_ptr<Described> second) {
  std::vector<ClipTeacher> teachers;
  teachers.push_back({std::move(first)});
  teachers.push_back({std::move(second)});
  return ClipAnnotator::Create(std::move(teachers), {0, 1});
}

std::vector<double> Answers(Annotator& annotator, const Rows& rows) {
  std::vector<double> targets(rows.bases.size());
  EXPECT_THAT(annotator.Annotate(rows, absl::MakeSpan(targets)), IsOk());
  return targets;
}

// Two teachers: of clips 0 and 3, and of clip 1; nobody labels clip 2.
std::unique_ptr<ClipAnnotator> MakeTwo() {
  std::vector<ClipTeacher> teachers;
  for (const uint64_t seed : {1, 2}) {
    teachers.push_back({LocalAnnotator::Create(Toy(seed), 1).value()});
  }
  return ClipAnnotator::Create(std::move(teachers), {0, 1, kNone, 0}).value();
}

TEST(ClipAnnotator, GivesEveryRowTheAnswerOfItsClipsTeacher) {
  const ToyRows toy = MakeToyRows(7);
  const std::vector<int32_t> clips = {1, 0, 3, 1, 1, 3, 0};
  Rows rows = toy.rows();
  rows.clips = clips;
  const auto first = LocalAnnotator::Create(Toy(1), 1).value();
  const auto second = LocalAnnotator::Create(Toy(2), 1).value();
  const std::vector<double> of_first = Answers(*first, toy.rows());
  const std::vector<double> of_second = Answers(*second, toy.rows());
  ASSERT_NE(of_first, of_second);

  const std::vector<double> found = Answers(*MakeTwo(), rows);

  for (size_t r = 0; r < clips.size(); ++r) {
    const std::vector<double>& expected = clips[r] == 1 ? of_second : of_first;
    for (size_t j = 3 * r; j < 3 * r + 3; ++j) {
      EXPECT_EQ(found[j], expected[j]) << "row " << r;
    }
  }
}

// How many teachers have been asked.
struct Asked {
  Mutex mu;
  CondVar changed;
  int count SINEW_GUARDED_BY(mu) = 0;
};

// Answers with a row's base and a step of its own, once two are asked.
class Sociable final : public Annotator {
 public:
  Sociable(double step, Asked& asked) : step_(step), asked_(asked) {
    description_.set_observation_width(1);
    description_.set_action_width(1);
    description_.set_max_rows(8);
  }
  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return spread_; }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override {
    for (size_t i = 0; i < targets.size(); ++i) {
      targets[i] = rows.bases[i] + step_;
    }
    MutexLock lock(asked_.mu);
    ++asked_.count;
    asked_.changed.NotifyAll();
    const Clock::TimePoint deadline = clock_.After(absl::Seconds(30));
    while (asked_.count < 2 && clock_.SteadyNow() < deadline) {
      clock_.WaitUntil(asked_.mu, asked_.changed, deadline, {});
    }
    if (asked_.count == 2) return absl::OkStatus();
    return absl::DeadlineExceededError("nobody else is asked");
  }

 private:
  const double step_;
  Asked& asked_;
  SystemClock clock_;
  v1::DescribeTeacherResponse description_;
  const std::vector<double> spread_ = {0.5};
};

// What two teachers say of clips 0 and 1; the second is elsewhere.
absl::StatusOr<std::vector<double>> AskBoth(std::unique_ptr<Annotator> first,
                                            std::unique_ptr<Annotator> second) {
  std::vector<ClipTeacher> teachers;
  teachers.push_back({.annotator = std::move(first)});
  teachers.push_back({.annotator = std::move(second), .elsewhere = true});
  const auto annotator =
      ClipAnnotator::Create(std::move(teachers), {0, 1}).value();
  const std::vector<float> observations = {0, 0, 0, 0};
  const std::vector<double> bases = {1, 2, 3, 4};
  const std::vector<int32_t> clips = {1, 0, 0, 1};
  std::vector<double> targets(4);
  const absl::Status asked = annotator->Annotate(
      {.observations = observations, .bases = bases, .clips = clips},
      absl::MakeSpan(targets));
  if (!asked.ok()) return asked;
  return targets;
}

TEST(ClipAnnotator, AsksThoseElsewhereBesideThoseHere) {
  Asked asked;

  EXPECT_THAT(AskBoth(std::make_unique<Sociable>(10, asked),
                      std::make_unique<Sociable>(20, asked)),
              IsOkAndHolds(ElementsAre(21, 12, 13, 24)));
}

TEST(ClipAnnotator, FailsWhereEitherOfTwoDoes) {
  const auto away = [] {
    return std::make_unique<Described>("away", 1, 8, std::vector{0.5});
  };
  const auto there = [](Asked& asked) {
    MutexLock lock(asked.mu);
    asked.count = 1;  // it need not wait
    return std::make_unique<Sociable>(10, asked);
  };
  Asked first, second;

  EXPECT_THAT(AskBoth(away(), there(first)),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr("2 rows"), HasSubstr("teacher away"))));
  EXPECT_THAT(
      AskBoth(there(second), away()),
      StatusIs(absl::StatusCode::kUnavailable, HasSubstr("teacher away")));
}

// They share threads: the second is not asked where the first fails.
TEST(ClipAnnotator, AsksThoseHereOneAfterTheOther) {
  Asked asked;
  std::vector<ClipTeacher> teachers;
  teachers.push_back(
      {std::make_unique<Described>("away", 1, 8, std::vector{0.5})});
  teachers.push_back({std::make_unique<Sociable>(10, asked)});
  const auto annotator =
      ClipAnnotator::Create(std::move(teachers), {0, 1}).value();
  const std::vector<float> observations = {0, 0};
  const std::vector<double> bases = {1, 2};
  const std::vector<int32_t> clips = {1, 0};
  std::vector<double> targets(2);

  EXPECT_THAT(
      annotator->Annotate(
          {.observations = observations, .bases = bases, .clips = clips},
          absl::MakeSpan(targets)),
      StatusIs(absl::StatusCode::kUnavailable, HasSubstr("teacher away")));
  MutexLock lock(asked.mu);
  EXPECT_EQ(asked.count, 0);
}

TEST(ClipAnnotator, RefusesRowsThatNobodyLabels) {
  const auto annotator = MakeTwo();
  const ToyRows toy = MakeToyRows(2);
  std::vector<double> targets(toy.bases.size());
  const auto annotate = [&](const std::vector<int32_t>& clips) {
    Rows rows = toy.rows();
    rows.clips = clips;
    return annotator->Annotate(rows, absl::MakeSpan(targets));
  };

  EXPECT_THAT(annotate({0, 1}), IsOk());
  for (const int32_t clip : {2, 4, -1}) {
    EXPECT_THAT(annotate({0, clip}),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("row 1"),
                               HasSubstr(absl::StrCat("clip ", clip)))));
  }
  EXPECT_THAT(annotate({}), StatusIs(absl::StatusCode::kInvalidArgument,
                                     HasSubstr("expected one of each of 2")));
}

TEST(ClipAnnotator, IsAnotherTeacherWhereOneOfThemIs) {
  const auto two = MakeTwo();
  std::vector<ClipTeacher> others;
  for (const uint64_t seed : {1, 3}) {
    others.push_back({LocalAnnotator::Create(Toy(seed), 1).value()});
  }
  const auto other = ClipAnnotator::Create(std::move(others), {0, 1}).value();

  EXPECT_NE(two->description().bundle_sha256(),
            other->description().bundle_sha256());
  EXPECT_EQ(two->description().bundle_sha256(),
            MakeTwo()->description().bundle_sha256());
  EXPECT_EQ(two->description().observation_width(), 21);
  EXPECT_FALSE(two->description().has_provenance());
  EXPECT_EQ(two->spread().size(), 3u);
}

TEST(ClipAnnotator, HasTheLargestSpreadAndTheFewestRowsOfItsTeachers) {
  const auto annotator = MakeDescribed(
      std::make_unique<Described>("a", 5, 64, std::vector<double>{0.1, 0.4}),
      std::make_unique<Described>("b", 5, 32, std::vector<double>{0.3, 0.2}));

  ASSERT_THAT(annotator, IsOk());
  EXPECT_THAT((*annotator)->spread(), ElementsAre(0.3, 0.4));
  EXPECT_EQ((*annotator)->description().max_rows(), 32);
}

TEST(ClipAnnotator, SaysWhoseRowsWereNotLabelled) {
  const auto annotator = MakeDescribed(
      std::make_unique<Described>("a", 1, 64, std::vector<double>{0.1}),
      std::make_unique<Described>("b", 1, 64, std::vector<double>{0.1}));
  ASSERT_THAT(annotator, IsOk());
  const std::vector<float> observations(3);
  const std::vector<double> bases(3);
  const std::vector<int32_t> clips = {1, 0, 1};
  std::vector<double> targets(3);

  EXPECT_THAT(
      (*annotator)
          ->Annotate(
              {.observations = observations, .bases = bases, .clips = clips},
              absl::MakeSpan(targets)),
      StatusIs(absl::StatusCode::kUnavailable,
               "of the 1 rows of its clips: teacher away"));
}

TEST(ClipAnnotator, RefusesTeachersOfDifferentWidths) {
  const std::vector<double> spread(3, 0.1);

  EXPECT_THAT(
      MakeDescribed(std::make_unique<Described>("wide", 21, 64, spread),
                    std::make_unique<Described>("narrow", 20, 64, spread)),
      StatusIs(absl::StatusCode::kInvalidArgument,
               AllOf(HasSubstr("teacher narrow"),
                     HasSubstr("expected 21 observation and 3 action"),
                     HasSubstr("found 20 and 3"))));
}

TEST(ClipAnnotator, RefusesTablesThatNameNoTeacher) {
  EXPECT_THAT(ClipAnnotator::Create({}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("teachers: expected some")));
  for (const int teacher : {1, -2}) {
    std::vector<ClipTeacher> one;
    one.push_back({LocalAnnotator::Create(Toy(1), 1).value()});
    EXPECT_THAT(ClipAnnotator::Create(std::move(one), {0, teacher}),
                StatusIs(absl::StatusCode::kInvalidArgument,
                         AllOf(HasSubstr("clip 1"),
                               HasSubstr(absl::StrCat("index ", teacher)))));
  }
}

}  // namespace
}  // namespace sinew::teacher
