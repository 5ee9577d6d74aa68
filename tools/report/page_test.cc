#include "tools/report/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sinew::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Page, LetsNoDataActAsMarkup) {
  const std::string hostile = "</script><script>alert(1)</script><!--";

  const std::string page = MakePage({{"title", hostile}});

  EXPECT_THAT(page, Not(HasSubstr("alert(1)</script>")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script\\u003e"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
}

}  // namespace
}  // namespace sinew::report
