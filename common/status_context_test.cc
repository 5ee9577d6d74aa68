#include "common/status_context.h"

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;

TEST(WithContext, NamesWhatAnErrorIsAboutAndKeepsItsCode) {
  EXPECT_THAT(WithContext(absl::NotFoundError("no joints"), "a.xml"),
              StatusIs(absl::StatusCode::kNotFound, "a.xml: no joints"));
  EXPECT_THAT(WithContext(absl::OkStatus(), "a.xml"), IsOk());
}

}  // namespace
}  // namespace sinew
