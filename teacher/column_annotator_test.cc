#include "teacher/column_annotator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "teacher/local_annotator.h"
#include "teacher/testing/toy_teacher.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;
using testing::MakeToyRows;
using testing::MakeToyTeacher;
using testing::ToyRows;

constexpr int64_t kTeacherWidth = 21;
constexpr int64_t kStudentWidth = 25;

std::unique_ptr<Annotator> Toy() {
  return LocalAnnotator::Create(MakeToyTeacher(), 1).value();
}

// The student's columns 24, 23 ... 4.
std::vector<int32_t> Backwards() {
  std::vector<int32_t> columns(kTeacherWidth);
  for (int64_t i = 0; i < kTeacherWidth; ++i) {
    columns[i] = static_cast<int32_t>(kStudentWidth - 1 - i);
  }
  return columns;
}

// What a student sees where its teacher sees `toy`; 7 in columns 0 to 3.
std::vector<float> StudentsObservations(const ToyRows& toy) {
  const auto rows =
      static_cast<int64_t>(toy.observations.size()) / kTeacherWidth;
  std::vector<float> wide(rows * kStudentWidth, 7.0F);
  for (int64_t r = 0; r < rows; ++r) {
    for (int64_t i = 0; i < kTeacherWidth; ++i) {
      wide[r * kStudentWidth + kStudentWidth - 1 - i] =
          toy.observations[r * kTeacherWidth + i];
    }
  }
  return wide;
}

std::unique_ptr<ColumnAnnotator> Wide() {
  return ColumnAnnotator::Create(Toy(), Backwards(), kStudentWidth).value();
}

TEST(ColumnAnnotator, ShowsTheTeacherItsColumnsInItsOrder) {
  const ToyRows toy = MakeToyRows(5);
  std::vector<double> expected(toy.bases.size());
  ASSERT_THAT(Toy()->Annotate(toy.rows(), absl::MakeSpan(expected)), IsOk());
  const std::vector<float> wide = StudentsObservations(toy);
  std::vector<double> found(toy.bases.size());

  ASSERT_THAT(Wide()->Annotate({.observations = wide, .bases = toy.bases},
                               absl::MakeSpan(found)),
              IsOk());

  EXPECT_EQ(found, expected);
}

TEST(ColumnAnnotator, IsTheTeacherToWhoeverAsksWithTheStudentsWidth) {
  const auto teacher = Toy();
  const auto wide = Wide();

  EXPECT_EQ(wide->description().observation_width(), kStudentWidth);
  EXPECT_EQ(wide->description().bundle_sha256(),
            teacher->description().bundle_sha256());
  EXPECT_EQ(wide->description().action_width(),
            teacher->description().action_width());
  EXPECT_EQ(
      std::vector<double>(wide->spread().begin(), wide->spread().end()),
      std::vector<double>(teacher->spread().begin(), teacher->spread().end()));
}

TEST(ColumnAnnotator, NamesColumnsAsTheStudentHasThem) {
  const ToyRows toy = MakeToyRows(2);
  std::vector<float> wide = StudentsObservations(toy);
  wide[kStudentWidth + 2] = NAN;  // which the teacher does not see
  std::vector<double> targets(toy.bases.size());

  EXPECT_THAT(Wide()->Annotate({.observations = wide, .bases = toy.bases},
                               absl::MakeSpan(targets)),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("row 1, column 2")));
  wide.pop_back();
  EXPECT_THAT(Wide()->Annotate({.observations = wide, .bases = toy.bases},
                               absl::MakeSpan(targets)),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("25")));
}

TEST(ColumnAnnotator, RefusesColumnsThatAreNotThere) {
  std::vector<int32_t> columns(kTeacherWidth);
  std::iota(columns.begin(), columns.end(), 0);
  const auto create = [&] {
    return ColumnAnnotator::Create(Toy(), columns, kStudentWidth).status();
  };
  ASSERT_THAT(create(), IsOk());

  columns[3] = 25;
  EXPECT_THAT(create(), StatusIs(absl::StatusCode::kInvalidArgument,
                                 HasSubstr("columns of 25, found column 25")));
  columns[3] = -1;
  EXPECT_THAT(create(), StatusIs(absl::StatusCode::kInvalidArgument,
                                 HasSubstr("found column -1")));
  columns.pop_back();
  EXPECT_THAT(create(), StatusIs(absl::StatusCode::kInvalidArgument,
                                 HasSubstr("expected 21 columns, found 20")));
}

}  // namespace
}  // namespace sinew::teacher
