#include "tools/sinew/checkpoint_command.h"

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/rpc/testing/certificates.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/checkpoint/service/checkpoint_server.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tools/sinew/testing/run_command.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::IsOkAndHolds;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::RunCommand;

class CheckpointCommand : public ::testing::Test {
 protected:
  CheckpointCommand() {
    EXPECT_THAT(MakeDirectories(Path("bundle/character")), IsOk());
    EXPECT_THAT(WriteFileAtomically(Path("bundle/weights"), "w"), IsOk());
    EXPECT_THAT(WriteFileAtomically(Path("bundle/character/a.xml"), "x"),
                IsOk());
  }

  std::string Path(const std::string& name) const {
    return JoinPath(folder_.path(), name);
  }

  absl::Status Run(const std::string& arguments, const StopToken& stop = {}) {
    return RunCommand(AddCheckpointCommand, "checkpoint " + arguments, stop);
  }

  // The verb on the store, and what it prints.
  absl::StatusOr<std::string> Output(const std::string& arguments) {
    std::string output;
    const absl::Status status = RunCommand(
        AddCheckpointCommand, "checkpoint " + arguments, /*stop=*/{}, &output);
    if (!status.ok()) return status;
    return output;
  }

  // Everything that people do, on the store that `store` (flags) names.
  void ExpectToWork(const std::string& store) {
    EXPECT_THAT(
        Run(absl::StrCat("put ", Path("bundle"),
                         " --id bundle-1 --kind bundle --iteration 40", store)),
        IsOk());
    EXPECT_THAT(Run("alias best bundle-1" + store), IsOk());
    EXPECT_THAT(Output("list" + store),
                IsOkAndHolds(AllOf(HasSubstr("bundle-1"), HasSubstr(" 40 "),
                                   HasSubstr(" best\n"))));
    EXPECT_THAT(Run(absl::StrCat("get best --out ", Path("out"), store)),
                IsOk());
    EXPECT_THAT(ReadFile(Path("out/character/a.xml")), IsOkAndHolds("x"));
    EXPECT_THAT(Run("alias best bundle-1 --expected bundle-0" + store), IsOk());
    EXPECT_THAT(Run("alias best bundle-2" + store),
                StatusIs(absl::StatusCode::kNotFound, HasSubstr("bundle-2")));
    EXPECT_THAT(Run(absl::StrCat("get absent --out ", Path("absent"), store)),
                StatusIs(absl::StatusCode::kNotFound, HasSubstr("absent")));
    EXPECT_FALSE(FileExists(Path("absent")));
  }

  const rpc::SocketFolder folder_;
  const SystemClock clock_;
};

TEST_F(CheckpointCommand, PutsListsNamesAndGetsInAFolder) {
  ExpectToWork(" --store " + Path("store"));
}

TEST_F(CheckpointCommand, PutsListsNamesAndGetsOverAService) {
  const auto server = checkpoint::CheckpointServer::Start(
      {.address = "127.0.0.1:0", .folder = Path("store")}, clock_);
  ASSERT_THAT(server, IsOk());

  ExpectToWork(" --store " + (*server)->address());
}

TEST_F(CheckpointCommand, LeavesTheNamesOfPromotionToIt) {
  const std::string store = " --store " + Path("store");
  const std::string put =
      absl::StrCat("put ", Path("bundle"), " --kind bundle", store, " --id ");
  ASSERT_THAT(Run(put + "bundle-1"), IsOk());

  for (const std::string name : {"stable", "stable-previous"}) {
    const auto is_refused = StatusIs(
        absl::StatusCode::kInvalidArgument,
        AllOf(HasSubstr(absl::StrCat("\"", name, "\": expected")),
              HasSubstr("sinew promote"), HasSubstr("--error-tolerance 1e6"),
              HasSubstr("--rollback")));
    EXPECT_THAT(Run(absl::StrCat("alias ", name, " bundle-1", store)),
                is_refused);
    EXPECT_THAT(Run(absl::StrCat("get ", name, " --out ", Path("out"), store)),
                StatusIs(absl::StatusCode::kNotFound));
  }
  EXPECT_THAT(Run("alias stable-2026 bundle-1" + store), IsOk());
}

TEST_F(CheckpointCommand, RefusesIdsThatWouldStandInForAliases) {
  for (const std::string name :
       {"stable", "stable-previous", "best", "latest"}) {
    EXPECT_THAT(
        Run(absl::StrCat("put ", Path("bundle"), " --kind bundle --store ",
                         Path("store"), " --id ", name)),
        StatusIs(absl::StatusCode::kInvalidArgument,
                 HasSubstr(absl::StrCat("--id: artifact id: expected none that "
                                        "is the name of an alias, found \"",
                                        name, "\""))));
  }
}

TEST_F(CheckpointCommand, SpeaksTls) {
  const rpc::Security security = rpc::MakeCertificates(folder_.path(), "a");
  const rpc::Security stranger = rpc::MakeCertificates(folder_.path(), "b");
  const auto server = checkpoint::CheckpointServer::Start(
      {.address = "127.0.0.1:0", .folder = Path("store"), .security = security},
      clock_);
  ASSERT_THAT(server, IsOk());
  const auto flags = [](const rpc::Security& tls) {
    return absl::StrCat(" --tls-certificate ", tls.certificate_file,
                        " --tls-key ", tls.key_file, " --tls-authority ",
                        tls.authority_file);
  };
  const std::string store = " --store " + (*server)->address();

  EXPECT_THAT(Output("list" + store + flags(security)), IsOk());
  // A certificate that the authority did not sign.
  EXPECT_THAT(Run("list" + store + flags(stranger)),
              StatusIs(absl::StatusCode::kUnavailable,
                       HasSubstr((*server)->address())));
}

TEST_F(CheckpointCommand, ReadsAFolderThatIsBeingServed) {
  const auto server = checkpoint::CheckpointServer::Start(
      {.address = folder_.Address("s"), .folder = Path("store")}, clock_);
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT(Output("list --store " + Path("store")), IsOk());
  EXPECT_THAT(
      Run(absl::StrCat("put ", Path("bundle"), " --id b --kind bundle --store ",
                       Path("store"))),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               HasSubstr("in use by process")));
}

TEST_F(CheckpointCommand, ServesUntilItIsStopped) {
  StopSource stop;
  stop.request_stop();

  EXPECT_THAT(
      Run(absl::StrCat("serve --metrics 127.0.0.1:0 --listen ",
                       folder_.Address("s"), " --folder ", Path("store")),
          stop.get_token()),
      IsOk());
  EXPECT_TRUE(FileExists(Path("store/blobs")));
}

TEST_F(CheckpointCommand, RefusesAPortAndAFolderThatAreInUse) {
  const auto server = checkpoint::CheckpointServer::Start(
      {.address = "127.0.0.1:0", .folder = Path("store")}, clock_);
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT(Run(absl::StrCat("serve --listen ", (*server)->address(),
                               " --folder ", Path("other"))),
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr((*server)->address())));
  EXPECT_THAT(
      Run(absl::StrCat("serve --listen 127.0.0.1:0 --folder ", Path("store"))),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               HasSubstr(Path("store"))));
}

TEST_F(CheckpointCommand, RefusesPlainTextToOtherMachines) {
  EXPECT_THAT(
      Run("list --store store.example:7000"),
      StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("plain text")));
}

TEST_F(CheckpointCommand, NamesAFolderThatIsNoStore) {
  EXPECT_THAT(Run("list --store " + Path("bundle")),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr(Path("bundle"))));
}

TEST_F(CheckpointCommand, NeedsAStore) {
  EXPECT_THROW(Run("list").IgnoreError(), CLI::RequiredError);
  EXPECT_THROW(Run("put x --store y").IgnoreError(), CLI::RequiredError);
}

}  // namespace
}  // namespace sinew::tools
