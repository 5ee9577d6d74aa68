#include "tools/sinew/actor_command.h"

#include <string>

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
using testing::RunCommand;

class ActorCommand : public ::testing::Test {
 protected:
  absl::Status Run(const std::string& arguments, const StopToken& stop = {}) {
    return RunCommand(
        AddActorCommand,
        absl::StrCat("actor --cache ", folder_.path(), "/cache ", arguments),
        stop);
  }

  const rpc::SocketFolder folder_;
};

TEST_F(ActorCommand, EndsInOrderWhenAskedToWhileNobodyAnswers) {
  StopSource stop;
  stop.request_stop();

  EXPECT_THAT(Run(absl::StrCat("--learner ", folder_.Address("nobody")),
                  stop.get_token()),
              IsOk());
}

TEST_F(ActorCommand, EndsWithAnErrorThatNamesALearnerThatIsNotThere) {
  EXPECT_THAT(Run(absl::StrCat("--reconnect-seconds 0.02 --threads 1",
                               " --learner ", folder_.Address("nobody"))),
              StatusIs(absl::StatusCode::kUnavailable,
                       AllOf(HasSubstr(folder_.Address("nobody")),
                             HasSubstr("for 20ms"))));
}

TEST_F(ActorCommand, RefusesPlainTextToOtherMachines) {
  EXPECT_THAT(Run("--learner learner.example:7000"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       AllOf(HasSubstr("learner.example:7000"),
                             HasSubstr("--allow-insecure"))));
}

TEST_F(ActorCommand, RefusesHalfOfTheTlsFiles) {
  EXPECT_THAT(Run("--learner learner.example:7000 --tls-key /nowhere/key.pem"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("key \"/nowhere/key.pem\"")));
}

TEST_F(ActorCommand, RefusesAnAddressThatIsNone) {
  EXPECT_THAT(Run("--learner learner"),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("address \"learner\": expected")));
}

TEST_F(ActorCommand, RefusesSecondsThatAreNoNumber) {
  for (const char* flag : {"--drain-seconds nan", "--reconnect-seconds nan",
                           "--drain-seconds inf"}) {
    EXPECT_THROW(Run(absl::StrCat("--learner unix:/x ", flag)).IgnoreError(),
                 CLI::ValidationError)
        << flag;
  }
}

TEST_F(ActorCommand, NeedsALearnerAndThreads) {
  EXPECT_THROW(Run("").IgnoreError(), CLI::RequiredError);
  EXPECT_THROW(Run("--learner unix:/x --threads 0").IgnoreError(),
               CLI::ValidationError);
}

}  // namespace
}  // namespace sinew::tools
