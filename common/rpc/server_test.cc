#include "common/rpc/server.h"

#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/rpc/channel.h"
#include "common/rpc/credentials.h"
#include "common/rpc/status.h"
#include "common/rpc/testing/certificates.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/blob.grpc.pb.h"

namespace sinew::rpc {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

// Any service will do: a call that arrives is answered UNIMPLEMENTED.
v1::Blobs::Service& AnyService() {
  static auto& service = *new v1::Blobs::Service;
  return service;
}

absl::StatusOr<std::unique_ptr<Server>> Start(const std::string& address,
                                              const Security& security = {}) {
  return Server::Start({.address = address, .security = security},
                       {&AnyService()});
}

// UNIMPLEMENTED if the peer was reached.
absl::Status Call(const std::string& address, const Security& security = {}) {
  const auto channel = MakeChannel(address, security);
  if (!channel.ok()) return channel.status();
  grpc::ClientContext context;
  SetTimeout(context, absl::Seconds(20));
  const auto reader =
      v1::Blobs::NewStub(*channel)->GetBlob(&context, v1::GetBlobRequest());
  return FromGrpc(reader->Finish(), address);
}

TEST(Server, TakesAFreePortAndSaysWhich) {
  const auto server = Start("127.0.0.1:0");
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT((*server)->address(), Not(EndsWith(":0")));
  EXPECT_THAT(Call((*server)->address()),
              StatusIs(absl::StatusCode::kUnimplemented));
}

TEST(Server, AnswersOnAUnixSocket) {
  const SocketFolder folder;
  const auto server = Start(folder.Address("s"));
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT(Call(folder.Address("s")),
              StatusIs(absl::StatusCode::kUnimplemented));
}

TEST(Server, NamesAPortThatIsInUse) {
  const auto first = Start("127.0.0.1:0");
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(Start((*first)->address()),
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr((*first)->address())));
}

TEST(Server, NamesASocketThatIsInUse) {
  const SocketFolder folder;
  const auto first = Start(folder.Address("s"));
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(Start(folder.Address("s")),
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr(folder.Address("s"))));
}

TEST(Server, ReplacesTheSocketThatADeadServerLeft) {
  const SocketFolder folder;
  ASSERT_THAT(Start(folder.Address("s")), IsOk());

  EXPECT_THAT(Start(folder.Address("s")), IsOk());
}

TEST(Server, RefusesCallsAfterShutdown) {
  const auto server = Start("127.0.0.1:0");
  ASSERT_THAT(server, IsOk());

  (*server)->Shutdown(absl::ZeroDuration());

  EXPECT_THAT(Call((*server)->address()),
              StatusIs(absl::StatusCode::kUnavailable));
}

TEST(Server, RefusesPlainTextBeyondTheMachine) {
  EXPECT_THAT(Start("0.0.0.0:0"),
              StatusIs(absl::StatusCode::kFailedPrecondition,
                       HasSubstr("--allow-insecure")));
  Security insecure;
  insecure.allow_insecure = true;
  EXPECT_THAT(Start("0.0.0.0:0", insecure), IsOk());
}

TEST(MutualTls, LetsPeersOfOneAuthorityTalk) {
  const SocketFolder folder;
  const Security security = MakeCertificates(folder.path(), "a");
  const auto server = Start("127.0.0.1:0", security);
  ASSERT_THAT(server, IsOk());

  EXPECT_THAT(Call((*server)->address(), security),
              StatusIs(absl::StatusCode::kUnimplemented));
}

TEST(MutualTls, KeepsStrangersAndPlainTextOut) {
  const SocketFolder folder;
  const Security security = MakeCertificates(folder.path(), "a");
  const Security stranger = MakeCertificates(folder.path(), "b");
  // Trusts the server, but shows a certificate of another authority.
  Security impostor = stranger;
  impostor.authority_file = security.authority_file;
  const auto server = Start("127.0.0.1:0", security);
  ASSERT_THAT(server, IsOk());

  constexpr auto kUnavailable = absl::StatusCode::kUnavailable;
  EXPECT_THAT(Call((*server)->address(), stranger), StatusIs(kUnavailable));
  EXPECT_THAT(Call((*server)->address(), impostor), StatusIs(kUnavailable));
  EXPECT_THAT(Call((*server)->address()), StatusIs(kUnavailable));
}

TEST(MutualTls, NamesTheFileThatIsWrong) {
  const SocketFolder folder;
  const Security good = MakeCertificates(folder.path(), "a");
  const Security other = MakeCertificates(folder.path(), "b");
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

  Security wrong = good;
  wrong.key_file = other.key_file;
  EXPECT_THAT(Start("127.0.0.1:0", wrong),
              StatusIs(kInvalid, HasSubstr("b-key.pem: not the private key")));
  wrong = good;
  wrong.key_file.clear();
  EXPECT_THAT(Start("127.0.0.1:0", wrong),
              StatusIs(kInvalid, HasSubstr("key \"\"")));
  wrong = good;
  wrong.authority_file = good.key_file;
  EXPECT_THAT(Start("127.0.0.1:0", wrong),
              StatusIs(kInvalid, HasSubstr("a-key.pem: expected a PEM cert")));
  wrong = good;
  wrong.certificate_file = folder.path() + "/none.pem";
  EXPECT_THAT(Start("127.0.0.1:0", wrong),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("none.pem")));
}

}  // namespace
}  // namespace sinew::rpc
