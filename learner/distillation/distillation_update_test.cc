#include "learner/distillation/distillation_update.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/types/span.h"
#include "common/policy/safetensors.h"
#include "common/random/philox.h"
#include "common/segment/mirror.h"
#include "common/testing/matchers.h"
#include "learner/distillation/student_networks.h"
#include "learner/distillation/testing/student_recipe.h"
#include "learner/torch/runtime.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::testing::Each;

constexpr SequenceShape kShape = {
    .steps = kHorizon, .observation = kObservation, .action = kAction};
constexpr int kSequences = 8, kRows = kSequences * kHorizon;
constexpr float kHuge = 1e30F;  // its square is not finite

// A student and its memory; a minibatch is 8 sequences in two shards.
struct Fixture {
  explicit Fixture(double samples_per_insert, bool prioritised = false,
                   int ranks = 2)
      : recipe(StudentRecipe("distillation { memory { rows: 1024 } }")),
        pool(ranks, UseOneThread),
        memory({.seed = 3,
                .shape = kShape,
                .samples_per_insert = samples_per_insert,
                .recipe = Selecting(prioritised)}) {
    UseOneThread();
    const auto student = MakeStudent(recipe, kObservation, kOwn, kAction);
    EXPECT_THAT(student.status(), IsOk());
    auto created =
        DistillationNetworks::Create(student->graph, student->weights,
                                     {.shards = 2,
                                      .shard_rows = kRows / 2,
                                      .steps = kHorizon,
                                      .form = recipe.distillation().form(),
                                      .action_scale = {0.5, 0.25}});
    EXPECT_THAT(created.status(), IsOk());
    networks = *std::move(created);
  }

  v1::Distillation::Memory Selecting(bool prioritised) const {
    v1::Distillation::Memory memory = recipe.distillation().memory();
    if (prioritised) {
      memory.set_selector(v1::Distillation::Memory::SELECTOR_PRIORITISED);
    }
    return memory;
  }

  // 8 sequences whose rows are all alike; the first column is -1 times the
  // others.
  void InsertAlike(float observation, float label) {
    LabelledSequences all;
    all.order_id = 1;
    all.observation.assign(kRows * kObservation, observation);
    for (int row = 0; row < kRows; ++row) {
      all.observation[row * kObservation] = -observation;
    }
    all.label.assign(kRows * kAction, label);
    all.valid.assign(kRows, 1);
    all.linked.assign(kRows, 0);
    memory.Insert(1, MakeChunk(all, kShape));
  }

  // 8 sequences; the labels of the first `huge` are out of bounds.
  void Insert(int64_t order, float valid = 1, int huge = 0) {
    LabelledSequences all;
    all.order_id = order;
    all.observation.resize(kRows * kObservation);
    all.label.resize(kRows * kAction);
    FillNormal({.seed = static_cast<uint64_t>(order), .step = 1},
               absl::MakeSpan(all.observation));
    FillNormal({.seed = static_cast<uint64_t>(order), .step = 2},
               absl::MakeSpan(all.label));
    for (int i = 0; i < huge * kHorizon * kAction; ++i) all.label[i] = kHuge;
    for (int row = 0; row < kRows; ++row) {
      all.valid.push_back(valid);
      all.linked.push_back(row % kHorizon == 0 ? 0 : valid);
    }
    memory.Insert(order, MakeChunk(all, kShape));
  }

  MinibatchFigures Run(double max_gradient_norm = 50,
                       const SegmentMirror* mirror = nullptr) {
    const DistillationSettings settings = {
        .seed = 7,
        .shape = kShape,
        .minibatch = kRows,
        .shards = 2,
        .learning_rate = 1e-3,
        .max_gradient_norm = max_gradient_norm,
        .kl_weight = 1e-3,
        .continuity_weight = 1e-4,
        .mirror = mirror};
    const auto figures = RunMinibatches(settings, memory, *networks, pool);
    EXPECT_THAT(figures.status(), IsOk());
    return figures.ok() ? *figures : MinibatchFigures();
  }

  std::string Weights() const {
    return SerializeSafetensors(networks->SaveWeights());
  }

  const v1::Recipe recipe;
  RankPool pool;
  Memory memory;
  std::unique_ptr<DistillationNetworks> networks;
};

TEST(RunMinibatches, PassesOverMinibatchesWithoutValidRows) {
  Fixture f(/*samples_per_insert=*/2);
  f.Insert(1, /*valid=*/0);
  const std::string before = f.Weights();

  const MinibatchFigures figures = f.Run();

  EXPECT_EQ(figures.minibatches, 0);
  EXPECT_EQ(figures.non_finite, 0);
  EXPECT_EQ(f.memory.sampled_rows(), 2 * kRows);
  EXPECT_EQ(f.networks->optimiser_steps(), 0);
  EXPECT_EQ(f.Weights(), before);
}

TEST(RunMinibatches, TakesNoStepAlongALossThatIsNotFinite) {
  Fixture f(/*samples_per_insert=*/3);
  f.Insert(1, /*valid=*/1, /*huge=*/kSequences);
  const std::string before = f.Weights();

  const MinibatchFigures figures = f.Run();

  EXPECT_EQ(figures.minibatches, 0);
  EXPECT_EQ(figures.non_finite, 3);
  EXPECT_EQ(figures.loss, 0);
  EXPECT_EQ(f.networks->optimiser_steps(), 0);
  EXPECT_EQ(f.Weights(), before);
}

TEST(RunMinibatches, DoesNotDrawWhatIsNotFiniteAgainAndAgain) {
  Fixture f(/*samples_per_insert=*/16, /*prioritised=*/true);
  f.Insert(1, /*valid=*/1, /*huge=*/1);

  const MinibatchFigures figures = f.Run();

  // One sequence of 8 in 16 minibatches of 8.
  EXPECT_GE(figures.non_finite, 1);
  EXPECT_LE(figures.non_finite, 2);
  EXPECT_EQ(figures.minibatches + figures.non_finite, 16);
  v1::MemoryState state;
  f.memory.Save(state);
  const auto& priorities = state.chunks(0).priorities();
  for (int i = 1; i < kSequences; ++i) {
    EXPECT_LT(priorities[0], 1e-3 * priorities[i]);
  }
}

TEST(RunMinibatches, SaysTheMeansOfItsMinibatches) {
  Fixture one(/*samples_per_insert=*/1), four(/*samples_per_insert=*/4);
  one.Insert(1);
  four.Insert(1);

  const MinibatchFigures single = one.Run(), figures = four.Run();

  ASSERT_EQ(single.minibatches, 1);
  ASSERT_EQ(figures.minibatches, 4);
  // Of the same sequences, and nothing is learnt in four steps: a sum would be
  // four times as much.
  EXPECT_GT(figures.action, single.action / 2);
  EXPECT_LT(figures.action, single.action * 2);
  EXPECT_GT(figures.latent_kl, 0);
  EXPECT_GT(figures.continuity, 0);
  // The weights of Run.
  const double loss =
      figures.action + 1e-3 * figures.latent_kl + 1e-4 * figures.continuity;
  EXPECT_NEAR(figures.loss, loss, 1e-5 * loss);
}

TEST(RunMinibatches, ClipsTheGradientsNorm) {
  constexpr double kLimit = 1e-3;
  Fixture f(/*samples_per_insert=*/1);
  f.Insert(1);

  const MinibatchFigures figures = f.Run(kLimit);

  ASSERT_EQ(figures.minibatches, 1);
  EXPECT_GT(figures.gradient_norm, 10 * kLimit);
  TensorMap moments;
  f.networks->SaveOptimiser(moments);
  double squares = 0;
  for (const auto& [name, tensor] : moments) {
    if (!name.starts_with("adam/first_moment/")) continue;
    for (const float value : tensor.float32()) squares += value * value;
  }
  // A tenth of the first gradient.
  EXPECT_NEAR(std::sqrt(squares), 0.1 * kLimit, 1e-3 * kLimit);
}

// Every column is its own partner, with this sign.
RowMirror MirrorOf(int width, float sign) {
  RowMirror mirror{.source = {}, .sign = std::vector<float>(width, sign)};
  for (int i = 0; i < width; ++i) mirror.source.push_back(i);
  return mirror;
}

TEST(RunMinibatches, LearnsFromMirrorImagesOfHalfItsSequences) {
  const SegmentMirror mirror = {.observation = MirrorOf(kObservation, 1),
                                .action = MirrorOf(kAction, -1)};
  const auto loss_after = [](const SegmentMirror* mirror) {
    Fixture f(/*samples_per_insert=*/200);
    f.InsertAlike(/*observation=*/0.5F, /*label=*/1);
    f.Run(50, mirror);  // 200 minibatches
    f.InsertAlike(0.5F, 1);
    return f.Run(50, mirror).action;
  };

  // One label can be learnt; two that contradict each other cannot.
  const double contradicting = loss_after(&mirror);
  EXPECT_LT(loss_after(nullptr), 0.3 * contradicting);
  // Nor can they where the observation does not change, but they can where it
  // tells which of the two is meant.
  const SegmentMirror telling = {.observation = MirrorOf(kObservation, -1),
                                 .action = MirrorOf(kAction, -1)};
  EXPECT_LT(loss_after(&telling), 0.5 * contradicting);
  // As it does where the first two columns change places.
  SegmentMirror swapping = mirror;
  std::swap(swapping.observation.source[0], swapping.observation.source[1]);
  EXPECT_LT(loss_after(&swapping), 0.8 * contradicting);
}

TEST(RunMinibatches, GivesTheSameWhateverTheNumberOfRanks) {
  std::vector<std::string> weights;
  const SegmentMirror mirror = {.observation = MirrorOf(kObservation, -1),
                                .action = MirrorOf(kAction, 1)};
  for (const int ranks : {1, 2, 3}) {
    Fixture f(/*samples_per_insert=*/4, /*prioritised=*/true, ranks);
    f.Insert(1);
    f.Insert(2);
    EXPECT_EQ(f.Run(50, &mirror).minibatches, 8);
    weights.push_back(f.Weights());
  }
  EXPECT_THAT(weights, Each(weights[0]));
}

}  // namespace
}  // namespace sinew::learner
