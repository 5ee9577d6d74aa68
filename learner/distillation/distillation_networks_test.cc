#include "learner/distillation/distillation_networks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"
#include "common/testing/matchers.h"
#include "learner/distillation/student_networks.h"
#include "learner/distillation/testing/student_recipe.h"
#include "learner/torch/runtime.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

constexpr int kRows = 2 * kHorizon;  // of a shard

std::vector<float> Draw(uint64_t seed, int64_t size) {
  std::vector<float> values(size);
  FillNormal({.seed = seed}, absl::MakeSpan(values));
  return values;
}

// Two shards of two sequences each.
struct Fixture {
  explicit Fixture(const v1::Recipe& recipe,
                   const std::vector<double>& action_scale = {0.5, 0.25},
                   bool bfloat16 = false)
      : student(*MakeStudent(recipe, kObservation, kOwn, kAction)) {
    UseOneThread();
    auto created =
        DistillationNetworks::Create(student.graph, student.weights,
                                     {.shards = 2,
                                      .shard_rows = kRows,
                                      .steps = kHorizon,
                                      .form = recipe.distillation().form(),
                                      .bfloat16 = bfloat16,
                                      .action_scale = action_scale});
    EXPECT_THAT(created.status(), IsOk());
    networks = *std::move(created);
    valid.assign(2 * kRows, 1);
    linked.assign(2 * kRows, 1);
    for (int row = 0; row < 2 * kRows; row += kHorizon) linked[row] = 0;
    valid[5] = linked[5] = linked[6] = 0;
  }

  DistillationNetworks::Rows Rows(int shard) const {
    const auto part = [&](const std::vector<float>& all, int width) {
      return absl::MakeConstSpan(all).subspan(shard * kRows * width,
                                              kRows * width);
    };
    return {.observation = part(observation, kObservation),
            .noise = part(noise, networks->latent_width()),
            .label = part(label, kAction),
            .valid = part(valid, 1),
            .linked = part(linked, 1)};
  }

  // Both shards' gradients; the loss of all.
  double Loss() {
    double loss = 0;
    for (int shard = 0; shard < 2; ++shard) {
      const auto figures =
          networks->Gradient(shard, Rows(shard),
                             {.kl = 0.1,
                              .continuity = 0.1,
                              .row_scale = 1.0 / (2 * kRows - 1),
                              .pair_scale = 1.0 / (2 * kRows - 6)});
      EXPECT_THAT(figures.status(), IsOk());
      loss += figures->loss;
    }
    return loss;
  }

  Student student;
  std::unique_ptr<DistillationNetworks> networks;
  std::vector<float> observation = Draw(1, 2 * kRows * kObservation);
  std::vector<float> noise = Draw(2, 2 * kRows * kLatent);
  std::vector<float> label = Draw(3, 2 * kRows * kAction);
  std::vector<float> valid, linked;
};

// Of each parameter tensor, the slope along its own gradient is the gradient's
// norm: central differences of the loss.
void ExpectGradientsOfDifferences(const v1::Recipe& recipe) {
  Fixture fixture(recipe);
  fixture.Loss();
  ASSERT_THAT(fixture.networks->SumGradients().status(), IsOk());
  const TensorMap gradient = fixture.networks->gradient();
  ASSERT_FALSE(gradient.empty());
  for (const auto& [name, tensor] : gradient) {
    double squares = 0;
    for (const float value : tensor.float32()) squares += value * value;
    const double norm = std::sqrt(squares);
    ASSERT_TRUE(std::isfinite(norm)) << name;
    if (norm < 1e-3) continue;
    // Steps of this length: rounding is 1e-6 / 2e-2, curvature a few 1e-4.
    constexpr double kStep = 1e-2;
    double sides[2];
    for (int side = 0; side < 2; ++side) {
      TensorMap moved = fixture.student.weights;
      for (int64_t i = 0; i < tensor.num_elements(); ++i) {
        moved.at(name).mutable_float32()[i] += static_cast<float>(
            (side == 0 ? kStep : -kStep) * tensor.float32()[i] / norm);
      }
      ASSERT_THAT(fixture.networks->LoadWeights(moved), IsOk());
      sides[side] = fixture.Loss();
    }
    EXPECT_NEAR((sides[0] - sides[1]) / (2 * kStep), norm, 0.01 * norm + 5e-4)
        << name;
  }
}

TEST(DistillationNetworks, HaveTheGradientOfDifferencesWithALatent) {
  ExpectGradientsOfDifferences(StudentRecipe());
}

TEST(DistillationNetworks, HaveTheGradientOfDifferencesInCodeForm) {
  ExpectGradientsOfDifferences(
      StudentRecipe("distillation { form: FORM_CODE }"));
}

TEST(DistillationNetworks, HaveTheGradientOfDifferencesWithoutALatent) {
  ExpectGradientsOfDifferences(PlainStudentRecipe());
}

// Cosine of the angle between two gradients.
double Alignment(const TensorMap& a, const TensorMap& b) {
  double product = 0, squares_a = 0, squares_b = 0;
  for (const auto& [name, tensor] : a) {
    const absl::Span<const float> other = b.at(name).float32();
    for (int64_t i = 0; i < tensor.num_elements(); ++i) {
      const double first = tensor.float32()[i];
      const double second = other[i];
      product += first * second;
      squares_a += first * first;
      squares_b += second * second;
    }
  }
  return product / std::sqrt(squares_a * squares_b);
}

// Where the CPU lacks it, that it is refused.
void ExpectNearlyTheSameGradientInBfloat16(const v1::Recipe& recipe) {
  const std::vector<double> scale = {0.5, 0.25};
  const absl::Status has_bfloat16 =
      CheckBfloat16(DetectCpu(), "cpu", "distillation.bfloat16");
  if (!has_bfloat16.ok()) {
    const Student student = *MakeStudent(recipe, kObservation, kOwn, kAction);
    EXPECT_EQ(DistillationNetworks::Create(student.graph, student.weights,
                                           {.shard_rows = kRows,
                                            .steps = kHorizon,
                                            .bfloat16 = true,
                                            .action_scale = scale})
                  .status(),
              has_bfloat16);
    return;
  }
  Fixture exact(recipe, scale);
  Fixture rounded(recipe, scale, /*bfloat16=*/true);

  const double loss = exact.Loss();
  EXPECT_NEAR(rounded.Loss(), loss, 0.01 * loss);
  ASSERT_THAT(exact.networks->SumGradients().status(), IsOk());
  ASSERT_THAT(rounded.networks->SumGradients().status(), IsOk());

  const double alignment =
      Alignment(exact.networks->gradient(), rounded.networks->gradient());
  EXPECT_GT(alignment, 0.999);
  EXPECT_LT(alignment, 1 - 1e-7);  // it is not float32
}

TEST(DistillationNetworks, HaveNearlyTheSameGradientInBfloat16WithALatent) {
  ExpectNearlyTheSameGradientInBfloat16(StudentRecipe());
}

TEST(DistillationNetworks, HaveNearlyTheSameGradientInBfloat16WithoutALatent) {
  ExpectNearlyTheSameGradientInBfloat16(PlainStudentRecipe());
}

TEST(DistillationNetworks, TrainEncoderPriorAndDecoder) {
  Fixture fixture(StudentRecipe());
  fixture.Loss();
  ASSERT_THAT(fixture.networks->SumGradients().status(), IsOk());
  ASSERT_THAT(fixture.networks->Step(1e-3, 1), IsOk());

  const TensorMap after = fixture.networks->SaveWeights();

  for (const char* name :
       {"encoder/linear_0/weight", "encoder/mean/weight",
        "encoder/log_variance/weight", "prior/linear_0/weight",
        "prior/mean/weight", "decoder/linear_0/weight",
        "decoder/action/weight"}) {
    EXPECT_NE(after.at(name).data, fixture.student.weights.at(name).data)
        << name;
  }
  EXPECT_EQ(after.at("normaliser/own/mean").data,
            fixture.student.weights.at("normaliser/own/mean").data);
}

TEST(DistillationNetworks, SayWhatEachSequenceLost) {
  Fixture fixture(StudentRecipe());
  const auto figures = fixture.networks->Gradient(
      0, fixture.Rows(0), {.row_scale = 1.0 / (kRows - 1), .pair_scale = 1});
  ASSERT_THAT(figures.status(), IsOk());

  ASSERT_EQ(figures->sequence_loss.size(), 2u);
  // 7 valid rows in the first sequence, 8 in the second.
  EXPECT_NEAR(
      (7 * figures->sequence_loss[0] + 8 * figures->sequence_loss[1]) / 15,
      figures->action, 1e-5);
}

TEST(DistillationNetworks, MeasureErrorsInRadians) {
  Fixture fixture(StudentRecipe(), /*action_scale=*/{0.5, 0.5});

  const auto figures = fixture.networks->Gradient(
      0, fixture.Rows(0), {.row_scale = 1.0 / (kRows - 1), .pair_scale = 1});

  ASSERT_THAT(figures.status(), IsOk());
  // The paper's form is the mean over rows of squares in units of action.
  const double squares = 0.5 * 0.5 * figures->action * (kRows - 1);
  EXPECT_NEAR(figures->squared_error_rad2, squares, 1e-5 * squares);
}

TEST(DistillationNetworks, RefuseScalesThatAreNotOnePerAction) {
  const auto student =
      MakeStudent(StudentRecipe(), kObservation, kOwn, kAction);
  ASSERT_THAT(student, IsOk());

  EXPECT_THAT(DistillationNetworks::Create(
                  student->graph, student->weights,
                  {.shard_rows = 8, .steps = 8, .action_scale = {1}})
                  .status(),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("expected 2 numbers")));
}

}  // namespace
}  // namespace sinew::learner
