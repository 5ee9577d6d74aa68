#include "learner/memory/memory_chunk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/digest.h"
#include "common/policy/safetensors.h"
#include "common/testing/matchers.h"

namespace sinew::learner {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

constexpr SequenceShape kShape = {.steps = 2, .observation = 3, .action = 1};

// Two sequences of two steps.
LabelledSequences MakeSequences() {
  return {.order_id = 5,
          .observation = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11},
          .label = {-1, -2, -3, 0},
          .valid = {1, 1, 1, 0},
          .linked = {0, 1, 0, 0}};
}

// A chunk of other bytes, with their digest.
StateChunk Chunk(std::string bytes) {
  StateChunk chunk;
  chunk.sha256 = Sha256Hex(bytes);
  chunk.bytes = std::make_shared<const std::string>(std::move(bytes));
  return chunk;
}

// The chunk with one of its arrays replaced.
StateChunk With(const std::string& name, const HostTensor& tensor) {
  TensorMap tensors =
      *ParseSafetensors(*MakeChunk(MakeSequences(), kShape).bytes, "chunk");
  tensors[name] = tensor;
  return Chunk(SerializeSafetensors(tensors));
}

TEST(MemoryChunk, HoldsWhatWasPutIntoIt) {
  const LabelledSequences sequences = MakeSequences();
  const StateChunk chunk = MakeChunk(sequences, kShape);

  const auto view = ViewChunk(chunk, kShape);

  ASSERT_THAT(view, IsOk());
  EXPECT_EQ(view->sequences, 2);
  EXPECT_THAT(view->observation, ElementsAreArray(sequences.observation));
  EXPECT_THAT(view->label, ElementsAre(-1, -2, -3, 0));
  EXPECT_THAT(view->valid, ElementsAre(1, 1, 1, 0));
  EXPECT_THAT(view->linked, ElementsAre(0, 1, 0, 0));
}

TEST(MemoryChunk, HasTheSameBytesForTheSameSequencesAlone) {
  LabelledSequences other = MakeSequences();
  other.order_id = 6;

  EXPECT_EQ(MakeChunk(MakeSequences(), kShape).sha256,
            MakeChunk(MakeSequences(), kShape).sha256);
  EXPECT_NE(MakeChunk(MakeSequences(), kShape).sha256,
            MakeChunk(other, kShape).sha256);
}

TEST(MemoryChunk, RefusesBytesOfAnotherDigest) {
  StateChunk chunk = MakeChunk(MakeSequences(), kShape);
  std::string bytes = *chunk.bytes;
  bytes.back() ^= 1;
  chunk.bytes = std::make_shared<const std::string>(bytes);

  EXPECT_THAT(ViewChunk(chunk, kShape),
              StatusIs(absl::StatusCode::kDataLoss,
                       AllOf(HasSubstr("memory-" + chunk.sha256),
                             HasSubstr("SHA-256: expected"))));
}

TEST(MemoryChunk, OfThisProcessIsViewedWithoutItsDigest) {
  StateChunk chunk = MakeChunk(MakeSequences(), kShape);
  const auto expected = ViewChunk(chunk, kShape);
  ASSERT_THAT(expected, IsOk());
  chunk.sha256 = "another";

  const auto view = ViewOwnChunk(chunk, kShape);

  ASSERT_THAT(view, IsOk());
  EXPECT_EQ(view->observation.data(), expected->observation.data());
  EXPECT_THAT(view->label, ElementsAreArray(MakeSequences().label));
  EXPECT_EQ(ViewChunk(chunk, kShape).status().code(),
            absl::StatusCode::kDataLoss);
}

TEST(MemoryChunk, RefusesWhatIsNoneAndNamesTheArray) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::pair<StateChunk, std::string> cases[] = {
      {Chunk("nothing"), "memory-"},
      {With("label", HostTensor::Float32({2, 2, 2}, std::vector<float>(8))),
       "label: expected float32 [2, 2, 1]"},
      {With("label", HostTensor::Float32({2, 2, 1}, {0, nan, 0, 0})),
       "label: expected finite numbers"},
      {With("valid", HostTensor::Float32({2, 2}, {1, 0.5, 1, 0})),
       "valid: expected flags of 0 or 1"},
      {With("linked", HostTensor::Float32({2, 2}, {0, 1, 0, 1})),
       "linked: expected links between valid rows"},
      {With("linked", HostTensor::Float32({2, 2}, {0, 1, 1, 0})),
       "linked: expected links between valid rows"}};
  for (const auto& [chunk, message] : cases) {
    EXPECT_THAT(ViewChunk(chunk, kShape),
                StatusIs(absl::StatusCode::kDataLoss, HasSubstr(message)))
        << message;
  }
}

}  // namespace
}  // namespace sinew::learner
