#include "common/testing/matchers.h"

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "gmock/gmock.h"
#include "gtest/gtest-spi.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/tensor.pb.h"

namespace sinew::testing {
namespace {

using ::testing::AllOf;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pointee;
using ::testing::StringMatchResultListener;

template <typename T, typename Matcher>
std::string Explain(const T& value, const Matcher& matcher) {
  StringMatchResultListener listener;
  ::testing::ExplainMatchResult(matcher, value, &listener);
  return listener.str();
}

v1::Tensor MakeTensor() {
  v1::Tensor tensor;
  tensor.set_name("reward");
  tensor.add_shape(2);
  return tensor;
}

TEST(IsOk, MatchesStatusAndStatusOr) {
  EXPECT_THAT(absl::OkStatus(), IsOk());
  EXPECT_THAT(absl::StatusOr<int>(3), IsOk());
  EXPECT_THAT(absl::NotFoundError("clip"), Not(IsOk()));
  EXPECT_THAT(absl::StatusOr<int>(absl::NotFoundError("clip")), Not(IsOk()));
}

TEST(IsOk, ShowsTheError) {
  EXPECT_THAT(Explain(absl::NotFoundError("no clip 7"), IsOk()),
              HasSubstr("no clip 7"));
}

TEST(IsOkAndHolds, MatchesTheValue) {
  const absl::StatusOr<int> three = 3;

  EXPECT_THAT(three, IsOkAndHolds(3));
  EXPECT_THAT(three, IsOkAndHolds(Gt(2)));
  EXPECT_THAT(three, Not(IsOkAndHolds(4)));
  EXPECT_THAT(absl::StatusOr<int>(absl::NotFoundError("clip")),
              Not(IsOkAndHolds(3)));
}

TEST(IsOkAndHolds, MatchesValuesThatCannotBeCopied) {
  EXPECT_THAT(absl::StatusOr<std::unique_ptr<int>>(std::make_unique<int>(3)),
              IsOkAndHolds(Pointee(3)));
}

TEST(StatusIs, MatchesCodeAndMessage) {
  const absl::Status status = absl::DataLossError("file.bin: cut at byte 9");

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(status, Not(StatusIs(absl::StatusCode::kNotFound)));
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kDataLoss,
                               AllOf(HasSubstr("file.bin"), HasSubstr("9"))));
  EXPECT_THAT(status,
              StatusIs(absl::StatusCode::kDataLoss, "file.bin: cut at byte 9"));
  EXPECT_THAT(status, Not(StatusIs(absl::StatusCode::kDataLoss, "file.bin")));
}

TEST(EqualsProto, MatchesMessageAndText) {
  EXPECT_THAT(MakeTensor(), EqualsProto(MakeTensor()));
  EXPECT_THAT(MakeTensor(), EqualsProto("name: 'reward' shape: 2"));
  EXPECT_THAT(MakeTensor(), Not(EqualsProto("name: 'reward' shape: 3")));
}

TEST(EqualsProto, ShowsTheFieldThatDiffers) {
  EXPECT_THAT(Explain(MakeTensor(), EqualsProto("name: 'reward' shape: 3")),
              HasSubstr("modified: shape[0]: 3 -> 2"));
}

TEST(EqualsProto, FailsTheTestWhenTheTextDoesNotParse) {
  EXPECT_NONFATAL_FAILURE(
      internal::ParseTextOrFail("no_such_field: 1",
                                *std::make_unique<v1::Tensor>()),
      "not a text form of sinew.v1.Tensor");
}

}  // namespace
}  // namespace sinew::testing
