#include "teacher/local_annotator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "common/build_info.h"
#include "common/cpu.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "teacher/testing/toy_teacher.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using testing::MakeToyRows;
using testing::MakeToyStudent;
using testing::MakeToyTeacher;
using testing::ToyRows;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::unique_ptr<LocalAnnotator> Create(const TeacherPolicy& policy,
                                       int threads = 1) {
  auto annotator = LocalAnnotator::Create(policy, threads);
  EXPECT_THAT(annotator, IsOk());
  return std::move(annotator).value();
}

std::vector<double> Annotate(Annotator& annotator, const Rows& rows) {
  std::vector<double> targets(rows.bases.size());
  EXPECT_THAT(annotator.Annotate(rows, absl::MakeSpan(targets)), IsOk());
  return targets;
}

// One row of several.
Rows Row(const ToyRows& rows, int64_t r, int64_t count = 1) {
  return {
      .observations =
          absl::MakeConstSpan(rows.observations).subspan(r * 21, count * 21),
      .bases = absl::MakeConstSpan(rows.bases).subspan(r * 3, count * 3)};
}

// The formula by hand: the executor for the mean, then the law's last line.
TEST(LocalAnnotator, AnswersWithTheTargetsOfThePolicysMean) {
  const TeacherPolicy policy = MakeToyTeacher();
  const ToyRows rows = MakeToyRows(5);
  const auto pack = policy::PackWeights(policy.graph, "policy", policy.weights);
  ASSERT_THAT(pack, IsOk());
  const auto executor = policy::Executor::Create(*pack, 5).value();
  std::copy(rows.observations.begin(), rows.observations.end(),
            executor->input(executor->input_index("observation")).begin());
  executor->Run(5);
  const auto mean = executor->tap(executor->tap_index("mean"));
  // Shares of 80 and 40 Nm at 100 Nm/rad; joint b has a scale of its own.
  const double scales[] = {0.25 * 0.8, 0.5, 0.25 * 0.4};

  const std::vector<double> targets = Annotate(*Create(policy), rows.rows());

  for (size_t i = 0; i < targets.size(); ++i) {
    const size_t j = i % 3;
    const double unit = std::clamp<double>(mean[i], -8, 8);
    double want = rows.bases[i] + scales[j] * unit;
    if (j != 1) want = std::clamp(want, -2.5, 2.5);  // range 1, margin 1.5
    EXPECT_NEAR(targets[i], want, 1e-14) << i;
  }
}

TEST(LocalAnnotator, DescribesTheBundle) {
  const TeacherPolicy policy = MakeToyTeacher();
  const auto annotator = Create(policy);

  const v1::DescribeTeacherResponse& found = annotator->description();

  EXPECT_EQ(found.bundle_sha256(), policy.manifest.manifest_sha256());
  EXPECT_EQ(found.character_sha256(), policy.manifest.character_sha256());
  EXPECT_EQ(found.build(), BuildIdentity());
  EXPECT_EQ(found.cpu_class(), CpuClass());
  EXPECT_EQ(found.observation_width(), 21);
  EXPECT_EQ(found.action_width(), 3);
  EXPECT_EQ(found.action().strength_scale(), 0.25);
  EXPECT_EQ(found.action().clip(), 8);  // the default
}

TEST(LocalAnnotator, SpreadsByThePolicysStandardDeviation) {
  TeacherPolicy policy = MakeToyTeacher();
  const std::vector<float> std = {0.5F, 0.25F, 0.125F};
  policy.weights["policy/std"] = HostTensor::Float32({3}, std);

  const auto annotator = Create(policy);

  EXPECT_THAT(annotator->spread(),
              ::testing::ElementsAre(::testing::DoubleEq(0.2 * 0.5),
                                     ::testing::DoubleEq(0.5 * 0.25),
                                     ::testing::DoubleEq(0.1 * 0.125)));
}

// The posterior's mean of the encoder alone, seen by the decoder alone.
TEST(LocalAnnotator, TakesAStudentWithALatentAtItsMean) {
  const TeacherPolicy policy = MakeToyStudent();
  const auto annotator = Create(policy);
  const ToyRows rows = MakeToyRows(4);
  const auto make = [&](const char* graph) {
    return policy::Executor::Create(
               policy::PackWeights(policy.graph, graph, policy.weights).value(),
               1)
        .value();
  };
  const auto encoder = make("encoder"), decoder = make("decoder");
  const auto seen = encoder->input(encoder->input_index("observation"));
  const auto own = decoder->input(decoder->input_index("self_observation"));
  const auto latent = decoder->input(decoder->input_index("latent"));
  const auto mean = encoder->tap(encoder->tap_index("mean"));
  const auto action = decoder->tap(decoder->tap_index("action"));

  const std::vector<double> targets = Annotate(*annotator, rows.rows());

  for (int64_t r = 0; r < 4; ++r) {
    const Rows row = Row(rows, r);
    std::copy(row.observations.begin(), row.observations.end(), seen.begin());
    encoder->Run(1);
    std::copy_n(row.observations.begin(), own.size(), own.begin());
    std::copy(mean.begin(), mean.end(), latent.begin());
    decoder->Run(1);
    const absl::Span<const double> target =
        absl::MakeConstSpan(targets).subspan(r * 3, 3);
    // Joint b is not limited.
    EXPECT_NEAR(target[1],
                row.bases[1] + 0.5 * std::clamp<double>(action[1], -8, 8), 1e-5)
        << r;
  }
  EXPECT_EQ(targets, Annotate(*annotator, rows.rows()));
  EXPECT_NE(targets, rows.bases);
  EXPECT_THAT(annotator->spread(), ::testing::Each(0.0));
}

TEST(LocalAnnotator, GivesTheSameBytesWhateverThreadsAndBatches) {
  constexpr int64_t kRows = 301;  // full blocks and an odd rest
  const ToyRows rows = MakeToyRows(kRows);
  const auto one = Create(MakeToyTeacher(), 1);
  const std::vector<double> expected = Annotate(*one, rows.rows());

  for (const int threads : {2, 3, 8}) {
    EXPECT_EQ(Annotate(*Create(MakeToyTeacher(), threads), rows.rows()),
              expected)
        << threads;
  }
  for (const int64_t batch : {1, 7, 128, 129}) {
    for (int64_t r = 0; r < kRows; r += batch) {
      const int64_t count = std::min(batch, kRows - r);
      const std::vector<double> want(expected.begin() + r * 3,
                                     expected.begin() + (r + count) * 3);
      ASSERT_EQ(Annotate(*one, Row(rows, r, count)), want) << r;
    }
  }
}

TEST(LocalAnnotator, SharesItsThreadsWithThoseBesideIt) {
  const ToyRows rows = MakeToyRows(301);
  const std::vector<double> of_first =
      Annotate(*Create(MakeToyTeacher(1)), rows.rows());
  const std::vector<double> of_second =
      Annotate(*Create(MakeToyTeacher(2)), rows.rows());
  ASSERT_NE(of_first, of_second);
  auto first = Create(MakeToyTeacher(1), 3);
  auto beside = LocalAnnotator::CreateBeside(*first, MakeToyTeacher(2));
  ASSERT_THAT(beside, IsOk());

  {
    const std::jthread other([&] {
      for (int i = 0; i < 20; ++i) {
        EXPECT_EQ(Annotate(*first, rows.rows()), of_first);
      }
    });
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(Annotate(**beside, rows.rows()), of_second);
    }
  }
  first.reset();
  EXPECT_EQ(Annotate(**beside, rows.rows()), of_second);
}

TEST(LocalAnnotator, TakesNoRowsAtAll) {
  EXPECT_THAT(Create(MakeToyTeacher(), 2)->Annotate({}, {}), IsOk());
}

TEST(LocalAnnotator, RefusesRowsThatDoNotFit) {
  const auto annotator = Create(MakeToyTeacher());
  const ToyRows rows = MakeToyRows(2);
  std::vector<double> targets(6);

  EXPECT_THAT(
      annotator->Annotate(
          {.observations = absl::MakeConstSpan(rows.observations).subspan(1),
           .bases = rows.bases},
          absl::MakeSpan(targets)),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("21 columns, found 41 numbers")));
  EXPECT_THAT(
      annotator->Annotate({.observations = rows.observations,
                           .bases = absl::MakeConstSpan(rows.bases).first(3)},
                          absl::MakeSpan(targets)),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("bases: expected 6 numbers, found 3")));
  EXPECT_THAT(
      annotator->Annotate(rows.rows(), absl::MakeSpan(targets).first(3)),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("targets")));
}

TEST(LocalAnnotator, NamesNumbersThatAreNotFinite) {
  const auto annotator = Create(MakeToyTeacher());
  std::vector<double> targets(6);
  ToyRows rows = MakeToyRows(2);
  rows.observations[21 + 4] = kNan;
  EXPECT_THAT(annotator->Annotate(rows.rows(), absl::MakeSpan(targets)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("observations: expected finite numbers, "
                                 "found nan in row 1, column 4")));

  rows = MakeToyRows(2);
  rows.bases[2] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(annotator->Annotate(rows.rows(), absl::MakeSpan(targets)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("bases: expected finite numbers, found inf "
                                 "in row 0, column 2")));
}

// Products of finite numbers overflow in float32.
TEST(LocalAnnotator, SaysSoWhenThePolicysAnswerIsNotFinite) {
  TeacherPolicy policy = MakeToyStudent();
  const auto fill = [&](const char* name, float value) {
    for (float& w : policy.weights.at(name).mutable_float32()) w = value;
  };
  fill("decoder/linear_0/bias", 3e38F);
  fill("decoder/action/weight", 1);  // sums 24 of these
  const auto annotator = Create(policy);
  const ToyRows rows = MakeToyRows(1);
  std::vector<double> targets(3);

  EXPECT_THAT(annotator->Annotate(rows.rows(), absl::MakeSpan(targets)),
              StatusIs(absl::StatusCode::kInternal,
                       HasSubstr("row 0, joint 0: expected a finite target")));
}

TEST(LocalAnnotator, RefusesPoliciesThatDoNotFitTheirManifest) {
  TeacherPolicy policy = MakeToyTeacher();
  policy.manifest.set_observation_width(22);
  EXPECT_THAT(LocalAnnotator::Create(policy, 1),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("observation_width: expected 21")));

  policy = MakeToyTeacher();
  policy.weights["policy/std"].mutable_float32()[0] = kNan;
  EXPECT_THAT(LocalAnnotator::Create(policy, 1),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("weights of the teacher: tensor "
                                 "\"policy/std\": element 0")));

  EXPECT_THAT(LocalAnnotator::Create(MakeToyTeacher(), 0),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("threads: expected >= 1, found 0")));
}

}  // namespace
}  // namespace sinew::teacher
