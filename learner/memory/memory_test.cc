#include "learner/memory/memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "common/testing/matchers.h"
#include "learner/memory/memory_chunk.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::EqualsProto;
using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr SequenceShape kShape = {.steps = 2, .observation = 1, .action = 1};

Memory::Options MakeOptions(int64_t rows, bool prioritised = false) {
  Memory::Options options;
  options.seed = 3;
  options.shape = kShape;
  options.samples_per_insert = 4;
  options.recipe.set_rows(rows);
  options.recipe.set_selector(
      prioritised ? v1::Distillation::Memory::SELECTOR_PRIORITISED
                  : v1::Distillation::Memory::SELECTOR_UNIFORM);
  options.recipe.set_priority_exponent(0.5);
  return options;
}

// A chunk of two sequences of two steps whose observations are `value`; the
// second one may lack valid rows.
StateChunk MakeTwo(float value, bool second_is_valid = true) {
  const float valid = second_is_valid ? 1.0F : 0.0F;
  return MakeChunk({.order_id = static_cast<int64_t>(value),
                    .observation = std::vector<float>(4, value),
                    .label = std::vector<float>(4, -value),
                    .valid = {1, 1, valid, valid},
                    .linked = {0, 1, 0, valid}},
                   kShape);
}

std::vector<float> Observations(const Memory& memory, uint64_t draw,
                                int64_t count = 64) {
  std::vector<float> observations;
  for (const auto reference : memory.Select(count, draw)) {
    observations.push_back(memory.At(reference).observation[0]);
  }
  return observations;
}

// Share of draws that are this sequence.
double Share(const Memory& memory, Memory::Reference sequence) {
  constexpr int kDraws = 4096;
  double count = 0;
  for (const auto& reference : memory.Select(kDraws, /*draw=*/9)) {
    count += reference.chunk == sequence.chunk &&
             reference.sequence == sequence.sequence;
  }
  return count / kDraws;
}

TEST(Memory, DropsTheOldestChunksBeyondItsRows) {
  Memory memory(MakeOptions(/*rows=*/8));
  for (int i = 1; i <= 3; ++i) memory.Insert(i, MakeTwo(i));

  EXPECT_EQ(memory.rows(), 8);  // of 12 inserted
  EXPECT_EQ(memory.inserted_rows(), 12);
  ASSERT_EQ(memory.chunks().size(), 2u);
  EXPECT_EQ(memory.chunks()[0].sha256, MakeTwo(2).sha256);
}

TEST(Memory, GivesWholeSequences) {
  Memory memory(MakeOptions(8));
  memory.Insert(1, MakeTwo(1));

  const Memory::Sequence sequence = memory.At({.chunk = 0, .sequence = 1});

  EXPECT_THAT(sequence.observation, ::testing::ElementsAre(1, 1));
  EXPECT_THAT(sequence.label, ::testing::ElementsAre(-1, -1));
  EXPECT_THAT(sequence.valid, ::testing::ElementsAre(1, 1));
  EXPECT_THAT(sequence.linked, ::testing::ElementsAre(0, 1));
}

TEST(Memory, CountsWhatTheSamplesToInsertRatioAllows) {
  Memory memory(MakeOptions(8));
  EXPECT_EQ(memory.DueMinibatches(6), 0);
  memory.Insert(1, MakeTwo(1));

  // 4 rows inserted, 4 samples each: 16 rows, two minibatches of 6.
  EXPECT_EQ(memory.DueMinibatches(6), 2);
  memory.CountSampled(12);
  EXPECT_EQ(memory.DueMinibatches(6), 0);
  // 16 more: 20 are left, three minibatches.
  memory.Insert(2, MakeTwo(2));
  EXPECT_EQ(memory.DueMinibatches(6), 3);
}

TEST(Memory, DrawsTheSameForTheSameDrawAlone) {
  Memory memory(MakeOptions(100));
  for (int i = 1; i <= 8; ++i) memory.Insert(i, MakeTwo(i));

  EXPECT_EQ(Observations(memory, 1), Observations(memory, 1));
  EXPECT_NE(Observations(memory, 1), Observations(memory, 2));
}

TEST(Memory, DrawsEverySequenceAlikeIfUniform) {
  Memory memory(MakeOptions(100));
  for (int i = 1; i <= 2; ++i) memory.Insert(i, MakeTwo(i));
  memory.SetPriority({.chunk = 0, .sequence = 0}, 100);

  // A quarter; 4 standard deviations of 4096 draws are 0.027.
  EXPECT_NEAR(Share(memory, {.chunk = 0, .sequence = 0}), 0.25, 0.027);
  EXPECT_NEAR(Share(memory, {.chunk = 1, .sequence = 1}), 0.25, 0.027);
}

TEST(Memory, DrawsByThePowerOfPriorities) {
  Memory memory(MakeOptions(100, /*prioritised=*/true));
  memory.Insert(1, MakeTwo(1));
  memory.SetPriority({.chunk = 0, .sequence = 0}, 9);
  memory.SetPriority({.chunk = 0, .sequence = 1}, 1);

  // 9 ^ 0.5 : 1 ^ 0.5.
  EXPECT_NEAR(Share(memory, {.chunk = 0, .sequence = 0}), 0.75, 0.027);
}

TEST(Memory, GivesANewSequenceTheLargestPriorityAndOneWithoutRowsNone) {
  Memory memory(MakeOptions(100, /*prioritised=*/true));
  memory.Insert(1, MakeTwo(1));
  memory.SetPriority({.chunk = 0, .sequence = 0}, 4);
  memory.Insert(2, MakeTwo(2, /*second_is_valid=*/false));

  v1::MemoryState state;
  memory.Save(state);

  EXPECT_THAT(state.chunks(1).priorities(), ::testing::ElementsAre(4, 0));
  EXPECT_EQ(Share(memory, {.chunk = 1, .sequence = 1}), 0);
}

TEST(Memory, DrawsNothingFromNothing) {
  EXPECT_THAT(Memory(MakeOptions(8)).Select(3, 0), IsEmpty());
}

TEST(Memory, GoesOnAfterARestoreAsIfItHadNotStopped) {
  Memory memory(MakeOptions(12, /*prioritised=*/true));
  for (int i = 1; i <= 3; ++i) memory.Insert(i, MakeTwo(i));
  memory.SetPriority({.chunk = 1, .sequence = 0}, 7);
  memory.CountSampled(4);
  v1::MemoryState state;
  memory.Save(state);

  Memory restored(MakeOptions(12, /*prioritised=*/true));
  ASSERT_THAT(restored.Restore(state, memory.chunks()), IsOk());

  for (Memory* one : {&memory, &restored}) one->Insert(4, MakeTwo(4));
  v1::MemoryState expected, found;
  memory.Save(expected);
  restored.Save(found);
  EXPECT_THAT(found, EqualsProto(expected));
  EXPECT_EQ(Observations(restored, 5), Observations(memory, 5));
  EXPECT_EQ(restored.DueMinibatches(2), memory.DueMinibatches(2));
}

TEST(Memory, RefusesAStateThatDoesNotFitItsChunksAndStaysAsItWas) {
  Memory memory(MakeOptions(12));
  memory.Insert(1, MakeTwo(1));
  v1::MemoryState good;
  memory.Save(good);
  const std::vector<StateChunk> chunks = memory.chunks();

  v1::MemoryState other_digest = good;
  other_digest.mutable_chunks(0)->set_sha256("another");
  v1::MemoryState other_count = good;
  other_count.mutable_chunks(0)->set_sequences(3);
  v1::MemoryState bad_priority = good;
  bad_priority.mutable_chunks(0)->set_priorities(0, -1);
  v1::MemoryState negative = good;
  negative.set_sampled_rows(-1);
  Memory restored(MakeOptions(12));
  restored.Insert(2, MakeTwo(2));
  const std::pair<v1::MemoryState, std::string> cases[] = {
      {other_digest, "SHA-256 another"},
      {other_count, "expected 2 sequences, found 3"},
      {bad_priority, "finite priorities >= 0"},
      {negative, "sampled_rows"}};
  for (const auto& [state, message] : cases) {
    EXPECT_THAT(restored.Restore(state, chunks),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)));
  }
  EXPECT_THAT(restored.Restore(good, {}),
              StatusIs(absl::StatusCode::kDataLoss,
                       HasSubstr("expected 1 chunks, found 0")));
  EXPECT_THAT(Observations(restored, 0), Each(2.0F));
}

}  // namespace
}  // namespace sinew::learner
