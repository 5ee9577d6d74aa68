#include "common/rpc/server.h"

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/rpc/channel.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/generic/generic_stub.h"
#include "gtest/gtest.h"

namespace sinew::rpc {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

std::unique_ptr<Server> StartOrDie(const std::string& address) {
  auto server = Server::Start({.address = address}, {});
  EXPECT_THAT(server, IsOk());
  return std::move(server).value();
}

std::string SocketPath() { return ::testing::TempDir() + "server_test.sock"; }

TEST(Server, TakesAFreePortAndSaysWhich) {
  const auto server = StartOrDie("127.0.0.1:0");

  EXPECT_THAT(server->address(), Not(EndsWith(":0")));
}

TEST(Server, NamesAPortThatIsInUse) {
  const auto first = StartOrDie("127.0.0.1:0");

  const auto second = Server::Start({.address = first->address()}, {});

  EXPECT_THAT(second, StatusIs(absl::StatusCode::kAlreadyExists,
                               HasSubstr(first->address())));
}

TEST(Server, NamesASocketThatIsInUse) {
  const auto first = StartOrDie("unix:" + SocketPath());

  const auto second = Server::Start({.address = first->address()}, {});

  EXPECT_THAT(second, StatusIs(absl::StatusCode::kAlreadyExists,
                               HasSubstr(SocketPath())));
}

TEST(Server, ReplacesTheSocketOfADeadServer) {
  StartOrDie("unix:" + SocketPath()).reset();

  EXPECT_THAT(Server::Start({.address = "unix:" + SocketPath()}, {}), IsOk());
}

TEST(Server, RefusesPlainTextBeyondTheMachine) {
  const auto server = Server::Start({.address = "0.0.0.0:0"}, {});

  EXPECT_THAT(server, StatusIs(absl::StatusCode::kFailedPrecondition,
                               HasSubstr("--insecure")));
}

}  // namespace
}  // namespace sinew::rpc
