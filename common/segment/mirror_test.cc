#include "common/segment/mirror.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/segment/segment_layout.h"

namespace sinew {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

void AddFloats(v1::Segment& segment, absl::string_view name,
               const std::vector<int64_t>& shape,
               const std::vector<float>& values) {
  v1::Tensor* tensor = segment.add_columns();
  tensor->set_name(std::string(name));
  tensor->set_dtype(v1::DATA_TYPE_FLOAT32);
  tensor->mutable_shape()->Add(shape.begin(), shape.end());
  tensor->set_data(std::string(reinterpret_cast<const char*>(values.data()),
                               values.size() * sizeof(float)));
}

std::vector<float> Floats(const v1::Tensor& tensor) {
  std::vector<float> values(tensor.data().size() / sizeof(float));
  std::memcpy(values.data(), tensor.data().data(), tensor.data().size());
  return values;
}

// Observation (height, left, right, sideways), action (left, right).
SegmentMirror MakeMirror() {
  return {.observation = {{0, 2, 1, 3}, {1, 1, 1, -1}},
          .action = {{1, 0}, {-1, -1}}};
}

v1::Segment MakeSegment() {
  v1::Segment segment;
  AddFloats(segment, column::kObservation, {2, 1, 4}, {1, 2, 3, 4, 5, 6, 7, 8});
  AddFloats(segment, column::kAction, {2, 1, 2}, {1, 2, 3, 4});
  AddFloats(segment, column::kReward, {2, 1}, {0.5, 0.25});
  AddFloats(segment, column::kTruncationObservation, {0, 4}, {});
  return segment;
}

TEST(Mirror, TurnsObservationsAndActionsAndLeavesTheRest) {
  const auto mirrored = MirrorSegment(MakeSegment(), MakeMirror());

  ASSERT_TRUE(mirrored.ok()) << mirrored.status();
  EXPECT_THAT(Floats(mirrored->columns(0)),
              ElementsAre(1, 3, 2, -4, 5, 7, 6, -8));
  EXPECT_THAT(Floats(mirrored->columns(1)), ElementsAre(-2, -1, -4, -3));
  EXPECT_THAT(Floats(mirrored->columns(2)), ElementsAre(0.5, 0.25));
}

TEST(Mirror, TwiceIsTheSegmentItself) {
  const v1::Segment segment = MakeSegment();

  const auto once = MirrorSegment(segment, MakeMirror());
  ASSERT_TRUE(once.ok()) << once.status();
  const auto twice = MirrorSegment(*once, MakeMirror());

  ASSERT_TRUE(twice.ok()) << twice.status();
  EXPECT_EQ(twice->SerializeAsString(), segment.SerializeAsString());
}

TEST(Mirror, RefusesAColumnOfAnotherWidth) {
  SegmentMirror mirror = MakeMirror();
  mirror.action = {{0}, {1}};

  const auto mirrored = MirrorSegment(MakeSegment(), mirror);

  EXPECT_EQ(mirrored.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(mirrored.status().message()),
              HasSubstr("action: expected float32 rows of 1"));
}

TEST(Mirror, RefusesAMapThatIsNotItsOwnInverse) {
  EXPECT_FALSE(CheckRowMirror({{1, 2, 0}, {1, 1, 1}}).ok());
  EXPECT_FALSE(CheckRowMirror({{1, 0}, {1, -1}}).ok());
  EXPECT_FALSE(CheckRowMirror({{0, 7}, {1, 1}}).ok());
  EXPECT_FALSE(CheckRowMirror({{0, 1}, {1}}).ok());
  EXPECT_TRUE(CheckRowMirror({{1, 0}, {-1, -1}}).ok());
}

}  // namespace
}  // namespace sinew
