#include "tools/sinew/render_command.h"

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"

namespace sinew::tools {
namespace {

// Reads a command line that ends in these arguments; runs nothing.
void Parse(const std::string& arguments) {
  CLI::App app;
  app.require_subcommand(1);
  Action action;
  AddRenderCommand(app, action);
  app.parse(absl::StrCat("render bundle --motions library --out picture.png ",
                         arguments));
}

TEST(RenderCommand, TakesAClipOrAFallenState) {
  EXPECT_NO_THROW(Parse("--clip walk --seconds 3"));
  EXPECT_NO_THROW(Parse("--fallen-state 0"));
  EXPECT_NO_THROW(Parse("--fallen-state 1023 --get-up"));
}

TEST(RenderCommand, RefusesBoth) {
  EXPECT_THROW(Parse("--fallen-state 0 --clip walk"), CLI::ExcludesError);
  EXPECT_THROW(Parse("--fallen-state 0 --seconds 3"), CLI::ExcludesError);
}

TEST(RenderCommand, RefusesAGetUpOfNobody) {
  EXPECT_THROW(Parse("--get-up"), CLI::RequiresError);
}

TEST(RenderCommand, RefusesStatesThatNobodyMakes) {
  EXPECT_THROW(Parse("--fallen-state -1"), CLI::ValidationError);
  EXPECT_THROW(Parse("--fallen-state 1024"), CLI::ValidationError);
}

}  // namespace
}  // namespace sinew::tools
