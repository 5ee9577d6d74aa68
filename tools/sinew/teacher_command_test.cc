#include "tools/sinew/teacher_command.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/files.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "sim/world/testing/toy_world.h"
#include "tools/sinew/testing/run_command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::RunServerBriefly;

class TeacherCommand : public ::testing::Test {
 protected:
  TeacherCommand() {
    const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
    bundle_ = JoinPath(toy.folder, "bundle");
    EXPECT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), bundle_),
                IsOk());
  }

  absl::Status Run(const std::string& arguments) {
    return RunServerBriefly(AddTeacherCommand,
                            absl::StrCat("teacher ", arguments));
  }

  const rpc::SocketFolder folder_;
  std::string bundle_;
};

TEST_F(TeacherCommand, ServesUntilItIsAskedToEnd) {
  EXPECT_THAT(
      Run(absl::StrCat("--bundle ", bundle_, " --listen ", folder_.Address("t"),
                       " --threads 2 --max-batch 64 --batch-delay 0.5 "
                       "--queue 128 --metrics 127.0.0.1:0")),
      IsOk());
}

TEST_F(TeacherCommand, RefusesAQueueThatHoldsNoBatch) {
  EXPECT_THAT(
      Run(absl::StrCat("--bundle ", bundle_, " --listen ", folder_.Address("t"),
                       " --max-batch 64 --queue 63")),
      StatusIs(absl::StatusCode::kInvalidArgument,
               HasSubstr("rows of the queue: expected 64, a batch, to")));
}

TEST_F(TeacherCommand, RefusesAQueueWithoutBounds) {
  EXPECT_THAT(Run(absl::StrCat("--bundle ", bundle_, " --listen ",
                               folder_.Address("t"), " --queue 1000000000")),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("to 262144, found 1000000000")));
}

TEST_F(TeacherCommand, RefusesPlainTextToOtherMachines) {
  EXPECT_THAT(
      Run(absl::StrCat("--bundle ", bundle_, " --listen 0.0.0.0:0")),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               AllOf(HasSubstr("0.0.0.0"), HasSubstr("--allow-insecure"))));
}

TEST_F(TeacherCommand, NamesABundleThatIsNotThere) {
  EXPECT_THAT(Run("--bundle /nowhere --listen 127.0.0.1:0"),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere")));
}

TEST_F(TeacherCommand, RefusesADelayThatIsNoNumber) {
  for (const char* delay : {"nan", "inf"}) {
    EXPECT_THROW(
        Run(absl::StrCat("--bundle x --listen unix:/x --batch-delay ", delay))
            .IgnoreError(),
        CLI::ValidationError)
        << delay;
  }
}

TEST_F(TeacherCommand, RefusesNumbersOfThreadsThatNoMachineHas) {
  for (const char* threads : {"0", "-2", "1000000"}) {
    EXPECT_THROW(static_cast<void>(Run(absl::StrCat(
                     "--bundle x --listen unix:/x --threads=", threads))),
                 CLI::ValidationError)
        << threads;
  }
}

TEST_F(TeacherCommand, NeedsABundleAndAnAddress) {
  EXPECT_THROW(static_cast<void>(Run("--listen unix:/x")), CLI::RequiredError);
  EXPECT_THROW(static_cast<void>(Run("--bundle x")), CLI::RequiredError);
}

}  // namespace
}  // namespace sinew::tools
