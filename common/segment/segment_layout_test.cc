#include "common/segment/segment_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "absl/strings/string_view.h"

namespace sinew {
namespace {

using ::testing::HasSubstr;

constexpr int kSteps = 3;
constexpr int kEnvironments = 2;
constexpr int kObservationWidth = 5;
constexpr int kActionWidth = 2;

v1::SegmentLayout Layout() {
  return MakeSegmentLayout(kObservationWidth, kActionWidth);
}

v1::Tensor* Column(v1::Segment& segment, absl::string_view name) {
  return const_cast<v1::Tensor*>(FindColumn(segment, name));
}

// All zeros and valid, except that step 1 of environment 1 (flat index 3) is
// truncated.
v1::Segment GoodSegment() {
  v1::Segment segment;
  const v1::SegmentLayout layout = Layout();
  for (const auto& column : layout.columns()) {
    v1::Tensor* tensor = segment.add_columns();
    tensor->set_name(column.name());
    tensor->set_dtype(column.dtype());
    int64_t rows = 1;
    if (column.lead() == v1::SegmentLayout::LEAD_STEP) {
      tensor->add_shape(kSteps);
      tensor->add_shape(kEnvironments);
      rows = kSteps * kEnvironments;
    } else if (column.lead() == v1::SegmentLayout::LEAD_BOUNDARY) {
      tensor->add_shape(kEnvironments);
      rows = kEnvironments;
    } else {
      tensor->add_shape(1);
    }
    for (int64_t extent : column.shape()) {
      tensor->add_shape(extent);
      rows *= extent;
    }
    tensor->set_data(std::string(rows * ElementBytes(column.dtype()), '\0'));
  }
  (*Column(segment, column::kTruncated)->mutable_data())[3] = 1;
  const int32_t index = 3;
  std::memcpy(Column(segment, column::kTruncationIndex)->mutable_data()->data(),
              &index, sizeof(index));
  return segment;
}

std::string Message(const v1::Segment& segment) {
  return std::string(
      CheckColumns(segment, Layout(), kSteps, kEnvironments).message());
}

TEST(SegmentLayout, AcceptsASegmentThatFits) {
  EXPECT_EQ(Message(GoodSegment()), "");
}

TEST(SegmentLayout, DigestChangesWithEveryWidth) {
  const std::string digest = LayoutSha256(MakeSegmentLayout(5, 2));

  EXPECT_EQ(digest, LayoutSha256(MakeSegmentLayout(5, 2)));
  EXPECT_NE(digest, LayoutSha256(MakeSegmentLayout(6, 2)));
  EXPECT_NE(digest, LayoutSha256(MakeSegmentLayout(5, 3)));
}

TEST(SegmentLayout, HasBasesExactlyInDistillation) {
  const v1::SegmentLayout plain = MakeSegmentLayout(5, 2);
  const v1::SegmentLayout layout = MakeSegmentLayout(5, 2, true);

  EXPECT_NE(LayoutSha256(layout), LayoutSha256(plain));
  ASSERT_EQ(layout.columns_size(), plain.columns_size() + 2);
  int bases = 0;
  for (const auto& column : layout.columns()) {
    if (column.name() != "base" && column.name() != "teacher_base") continue;
    ++bases;
    EXPECT_EQ(column.dtype(), v1::DATA_TYPE_FLOAT64);
    EXPECT_EQ(column.lead(), v1::SegmentLayout::LEAD_STEP);
    EXPECT_THAT(column.shape(), ::testing::ElementsAre(2));
  }
  EXPECT_EQ(bases, 2);
}

TEST(SegmentLayout, HasTheNoiseExactlyWhereALatentIsLearnt) {
  const v1::SegmentLayout plain = MakeSegmentLayout(5, 2);
  const v1::SegmentLayout layout = MakeSegmentLayout(5, 2, false, 3);

  EXPECT_NE(LayoutSha256(layout), LayoutSha256(plain));
  EXPECT_NE(LayoutSha256(layout),
            LayoutSha256(MakeSegmentLayout(5, 2, false, 4)));
  ASSERT_EQ(layout.columns_size(), plain.columns_size() + 1);
  v1::SegmentLayout rest = layout;
  for (int i = 0; i < layout.columns_size(); ++i) {
    if (layout.columns(i).name() != "latent_noise") continue;
    EXPECT_EQ(layout.columns(i).dtype(), v1::DATA_TYPE_FLOAT32);
    EXPECT_EQ(layout.columns(i).lead(), v1::SegmentLayout::LEAD_STEP);
    EXPECT_THAT(layout.columns(i).shape(), ::testing::ElementsAre(3));
    rest.mutable_columns()->DeleteSubrange(i, 1);
  }
  EXPECT_EQ(LayoutSha256(rest), LayoutSha256(plain));
}

TEST(SegmentLayout, RefusesAMissingColumn) {
  v1::Segment segment = GoodSegment();
  segment.mutable_columns()->RemoveLast();

  EXPECT_EQ(Message(segment), "segment: expected 16 columns, found 15");
}

TEST(SegmentLayout, RefusesAnotherNameTypeShapeOrSize) {
  v1::Segment segment = GoodSegment();
  Column(segment, column::kReward)->set_name("rewards");
  EXPECT_EQ(Message(segment),
            "segment column: expected \"reward\", found \"rewards\"");

  segment = GoodSegment();
  Column(segment, column::kTarget)->set_dtype(v1::DATA_TYPE_FLOAT32);
  EXPECT_EQ(Message(segment),
            "segment column target: expected type DATA_TYPE_FLOAT64, found "
            "DATA_TYPE_FLOAT32");

  segment = GoodSegment();
  Column(segment, column::kObservation)->set_shape(2, 6);
  EXPECT_EQ(Message(segment),
            "segment column observation: expected shape [3, 2, 5], found "
            "[3, 2, 6]");

  segment = GoodSegment();
  Column(segment, column::kReward)->mutable_data()->pop_back();
  EXPECT_EQ(Message(segment),
            "segment column reward: expected 24 bytes, found 23");
}

TEST(SegmentLayout, RefusesTruncationRowsThatDisagreeWithTheFlags) {
  v1::Segment segment = GoodSegment();
  (*Column(segment, column::kTruncated)->mutable_data())[0] = 1;

  EXPECT_EQ(Message(segment),
            "segment column truncation_index: expected the 2 truncated steps, "
            "found 1 indices");
}

TEST(SegmentLayout, RefusesMoreTruncationRowsThanSteps) {
  v1::Segment segment = GoodSegment();
  Column(segment, column::kTruncationIndex)->set_shape(0, int64_t{1} << 60);

  EXPECT_THAT(Message(segment), HasSubstr("expected at most 6 rows"));
}

TEST(SegmentLayout, RefusesAStepThatIsTerminatedAndTruncated) {
  v1::Segment segment = GoodSegment();
  (*Column(segment, column::kTerminated)->mutable_data())[3] = 1;

  EXPECT_EQ(Message(segment), "segment step 3: both terminated and truncated");
}

TEST(SegmentLayout, RefusesAFlagThatIsNeitherZeroNorOne) {
  v1::Segment segment = GoodSegment();
  (*Column(segment, column::kValid)->mutable_data())[4] = 7;

  EXPECT_EQ(Message(segment),
            "segment column valid[4]: expected 0 or 1, found 7");
}

TEST(SegmentLayout, NamesTheElementThatIsNotFinite) {
  v1::Segment segment = GoodSegment();
  ASSERT_TRUE(CheckColumnsFinite(segment).ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::memcpy(
      Column(segment, column::kTarget)->mutable_data()->data() + 2 * sizeof nan,
      &nan, sizeof nan);

  EXPECT_THAT(std::string(CheckColumnsFinite(segment).message()),
              HasSubstr("segment column target[2]: expected a finite number"));
}

}  // namespace
}  // namespace sinew
