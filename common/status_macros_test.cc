#include "common/status_macros.h"

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

absl::Status Forward(const absl::Status& status, int& reached) {
  SINEW_RETURN_IF_ERROR(status);
  ++reached;
  return absl::OkStatus();
}

absl::StatusOr<int> AddOne(absl::StatusOr<int> value) {
  SINEW_ASSIGN_OR_RETURN(const int number, value);
  return number + 1;
}

absl::StatusOr<std::unique_ptr<int>> PassOn(
    absl::StatusOr<std::unique_ptr<int>> value) {
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<int> pointer, std::move(value));
  return pointer;
}

absl::StatusOr<std::map<int, std::string>> MakeTable() {
  return std::map<int, std::string>{{7, "seven"}};
}

absl::StatusOr<std::string> LookUp(int key) {
  SINEW_ASSIGN_OR_RETURN((const std::map<int, std::string> table), MakeTable());
  return table.at(key);
}

TEST(ReturnIfError, GoesOnAfterOk) {
  int reached = 0;

  EXPECT_TRUE(Forward(absl::OkStatus(), reached).ok());

  EXPECT_EQ(reached, 1);
}

TEST(ReturnIfError, ReturnsTheErrorUnchanged) {
  int reached = 0;

  EXPECT_EQ(Forward(absl::NotFoundError("no clip"), reached),
            absl::NotFoundError("no clip"));

  EXPECT_EQ(reached, 0);
}

TEST(ReturnIfError, EvaluatesItsExpressionOnce) {
  int calls = 0;
  const auto count = [&calls] {
    ++calls;
    return absl::OkStatus();
  };

  const auto run = [&]() -> absl::Status {
    SINEW_RETURN_IF_ERROR(count());
    return absl::OkStatus();
  };

  EXPECT_TRUE(run().ok());
  EXPECT_EQ(calls, 1);
}

TEST(AssignOrReturn, AssignsTheValue) { EXPECT_EQ(*AddOne(41), 42); }

TEST(AssignOrReturn, ReturnsTheError) {
  EXPECT_EQ(AddOne(absl::DataLossError("cut")).status(),
            absl::DataLossError("cut"));
}

TEST(AssignOrReturn, MovesValuesThatCannotBeCopied) {
  EXPECT_EQ(**PassOn(std::make_unique<int>(3)), 3);
}

TEST(AssignOrReturn, TakesATypeWithACommaInParentheses) {
  EXPECT_EQ(*LookUp(7), "seven");
}

}  // namespace
}  // namespace sinew
