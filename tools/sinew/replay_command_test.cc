#include "tools/sinew/replay_command.h"

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tools/sinew/testing/run_command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::RunServerBriefly;

class ReplayCommand : public ::testing::Test {
 protected:
  absl::Status Run(const std::string& arguments) {
    return RunServerBriefly(AddReplayCommand,
                            absl::StrCat("replay ", arguments));
  }

  const rpc::SocketFolder folder_;
};

TEST_F(ReplayCommand, ServesUntilItIsAskedToEnd) {
  EXPECT_THAT(Run(absl::StrCat("--listen ", folder_.Address("r"),
                               " --bytes 64MiB --metrics 127.0.0.1:0")),
              IsOk());
}

TEST_F(ReplayCommand, RefusesATableThatIsTooSmall) {
  EXPECT_THAT(
      Run(absl::StrCat("--listen ", folder_.Address("r"), " --bytes 4kb")),
      StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("found 4000")));
}

TEST_F(ReplayCommand, RefusesPlainTextToOtherMachines) {
  EXPECT_THAT(
      Run("--listen 0.0.0.0:0"),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               AllOf(HasSubstr("0.0.0.0"), HasSubstr("--allow-insecure"))));
}

TEST_F(ReplayCommand, NeedsAnAddressAndASize) {
  EXPECT_THROW(static_cast<void>(Run("")), CLI::RequiredError);
  EXPECT_THROW(static_cast<void>(Run("--listen unix:/x --bytes many")),
               CLI::ValidationError);
}

}  // namespace
}  // namespace sinew::tools
