#include "tools/sinew/finite_range.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"

namespace sinew::tools {
namespace {

using ::testing::HasSubstr;

// What `--x` is refused with; empty: it is taken.
std::string Refusal(const std::string& words) {
  CLI::App app;
  std::vector<double> x;
  app.add_option("--x", x)->check(FiniteRange(-0.5, 60));
  try {
    app.parse(words);
  } catch (const CLI::ValidationError& error) {
    return error.what();
  }
  return "";
}

TEST(FiniteRange, TakesNumbersUpToItsEnds) {
  for (const char* number : {"-0.5", "0", "1e-3", "59.999", "60"}) {
    EXPECT_EQ(Refusal(absl::StrCat("--x=", number)), "") << number;
  }
}

TEST(FiniteRange, RefusesWhatIsNoNumberInIt) {
  for (const char* number : {"nan", "-nan", "NaN", "inf", "-inf", "1e999",
                             "-0.51", "60.01", "1s", "one"}) {
    EXPECT_EQ(Refusal(absl::StrCat("--x=", number)),
              absl::StrCat("--x: expected -0.5 to 60, found ", number));
  }
}

TEST(FiniteRange, LooksAtEachOfSeveral) {
  EXPECT_EQ(Refusal("--x 1 2 nan"), "--x: expected -0.5 to 60, found nan");
}

TEST(FiniteRange, IsPartOfTheHelp) {
  CLI::App app;
  double x = 0;
  app.add_option("--x", x)->check(FiniteRange(0, 1));
  EXPECT_THAT(app.help(), HasSubstr("in [0 to 1]"));
}

}  // namespace
}  // namespace sinew::tools
