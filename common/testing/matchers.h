#ifndef SINEW_COMMON_TESTING_MATCHERS_H_
#define SINEW_COMMON_TESTING_MATCHERS_H_

#include <memory>
#include <ostream>
#include <string>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "gmock/gmock.h"
#include "google/protobuf/message.h"

namespace sinew::testing {

namespace internal {

inline const absl::Status& GetStatus(const absl::Status& status) {
  return status;
}
template <typename T>
const absl::Status& GetStatus(const absl::StatusOr<T>& status_or) {
  return status_or.status();
}

template <typename StatusOrType>
class IsOkAndHoldsImpl : public ::testing::MatcherInterface<StatusOrType> {
 public:
  using Value = typename std::remove_reference_t<StatusOrType>::value_type;

  template <typename Inner>
  explicit IsOkAndHoldsImpl(Inner&& inner)
      : inner_(::testing::SafeMatcherCast<const Value&>(
            std::forward<Inner>(inner))) {}

  void DescribeTo(std::ostream* os) const override {
    *os << "is OK and has a value that ";
    inner_.DescribeTo(os);
  }
  void DescribeNegationTo(std::ostream* os) const override {
    *os << "isn't OK or has a value that ";
    inner_.DescribeNegationTo(os);
  }
  bool MatchAndExplain(
      StatusOrType actual,
      ::testing::MatchResultListener* listener) const override {
    if (!actual.ok()) {
      *listener << "which has status " << actual.status();
      return false;
    }
    return inner_.MatchAndExplain(*actual, listener);
  }

 private:
  const ::testing::Matcher<const Value&> inner_;
};

template <typename Inner>
class IsOkAndHoldsMatcher {
 public:
  explicit IsOkAndHoldsMatcher(Inner inner) : inner_(std::move(inner)) {}

  template <typename StatusOrType>
  operator ::testing::Matcher<StatusOrType>() const {  // NOLINT
    return ::testing::Matcher<StatusOrType>(
        new IsOkAndHoldsImpl<const StatusOrType&>(inner_));
  }

 private:
  const Inner inner_;
};

// Result of comparing two messages: empty if equal, else the difference.
std::string DifferenceOf(const google::protobuf::Message& actual,
                         const google::protobuf::Message& expected);

// Parses `text` into `message`; a test failure if that is impossible.
void ParseTextOrFail(absl::string_view text,
                     google::protobuf::Message& message);

}  // namespace internal

// Matches an absl::Status or absl::StatusOr that is OK.
MATCHER(IsOk, negation ? "isn't OK" : "is OK") {
  const absl::Status& status = internal::GetStatus(arg);
  *result_listener << "which has status " << status;
  return status.ok();
}

// Matches an absl::StatusOr that is OK and whose value matches `inner`.
template <typename Inner>
internal::IsOkAndHoldsMatcher<std::decay_t<Inner>> IsOkAndHolds(Inner&& inner) {
  return internal::IsOkAndHoldsMatcher<std::decay_t<Inner>>(
      std::forward<Inner>(inner));
}

// Matches an absl::Status or absl::StatusOr by its code.
MATCHER_P(StatusIs, code,
          std::string(negation ? "hasn't" : "has") + " status code " +
              absl::StatusCodeToString(code)) {
  const absl::Status& status = internal::GetStatus(arg);
  *result_listener << "which has status " << status;
  return status.code() == code;
}

// By its code and its message (a string or a matcher of one).
MATCHER_P2(StatusIs, code, message_matcher,
           std::string(negation ? "hasn't" : "has") + " status code " +
               absl::StatusCodeToString(code) + " and a message that " +
               ::testing::DescribeMatcher<std::string>(message_matcher)) {
  const absl::Status& status = internal::GetStatus(arg);
  *result_listener << "which has status " << status;
  return status.code() == code &&
         ::testing::ExplainMatchResult(
             message_matcher, std::string(status.message()), result_listener);
}

// Matches a message equal to `expected`: a message of the same type, or its
// text form.
MATCHER_P(EqualsProto, expected,
          std::string(negation ? "differs from" : "equals") +
              " the expected message") {
  using MessageType = std::remove_cvref_t<decltype(arg)>;
  using ExpectedType = std::remove_cvref_t<decltype(expected)>;
  std::string difference;
  if constexpr (std::is_convertible_v<ExpectedType, absl::string_view>) {
    MessageType parsed;
    internal::ParseTextOrFail(expected, parsed);
    difference = internal::DifferenceOf(arg, parsed);
  } else {
    difference = internal::DifferenceOf(arg, expected);
  }
  *result_listener << difference;
  return difference.empty();
}

}  // namespace sinew::testing

#endif  // SINEW_COMMON_TESTING_MATCHERS_H_
