#include "tools/sinew/quickstart_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "sim/world/testing/toy_world.h"
#include "tools/sinew/testing/run_command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RunCommand;

absl::Status Quickstart(const std::string& arguments) {
  return RunCommand(AddQuickstartCommand,
                    absl::StrCat("quickstart ", arguments));
}

TEST(QuickstartCommand, RefusesAnotherClipThanItsFolderHolds) {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  std::filesystem::rename(toy.library_folder, JoinPath(toy.folder, "motions"));
  const std::string out = absl::StrCat("--out ", toy.folder);

  EXPECT_THAT(Quickstart(absl::StrCat(out, " --clip walk")),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("--clip: expected turn, which "),
                             HasSubstr(toy.folder), HasSubstr("found walk"))));
  // The clip that it holds comes as far as to the file that it is read from,
  // which no such clip has.
  const absl::Status held = Quickstart(absl::StrCat(out, " --clip turn"));
  EXPECT_THAT(std::string(held.message()),
              AllOf(HasSubstr("turn.txt"), Not(HasSubstr("--clip"))));
}

TEST(QuickstartCommand, RefusesMinutesThatAreNoNumber) {
  EXPECT_THROW(static_cast<void>(Quickstart("--minutes nan")),
               CLI::ValidationError);
  EXPECT_THAT(Quickstart("--minutes 0"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("--minutes: expected > 0, found 0")));
}

}  // namespace
}  // namespace sinew::tools
