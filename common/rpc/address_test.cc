#include "common/rpc/address.h"

#include <string>

#include "absl/status/status.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::rpc {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

TEST(Address, ReadsAndWritesEachForm) {
  for (const std::string text :
       {"unix:/run/sinew.sock", "127.0.0.1:0", "learner:7000", "[::1]:80"}) {
    const auto address = ParseAddress(text);

    ASSERT_THAT(address, IsOk()) << text;
    EXPECT_EQ(AddressString(*address), text);
  }
}

TEST(Address, KnowsWhatStaysOnTheMachine) {
  EXPECT_TRUE(IsLocal(*ParseAddress("unix:a")));
  EXPECT_TRUE(IsLocal(*ParseAddress("127.0.0.1:1")));
  EXPECT_TRUE(IsLocal(*ParseAddress("127.8.9.10:1")));
  EXPECT_TRUE(IsLocal(*ParseAddress("[::1]:1")));
  EXPECT_TRUE(IsLocal(*ParseAddress("localhost:1")));
  EXPECT_FALSE(IsLocal(*ParseAddress("0.0.0.0:1")));
  EXPECT_FALSE(IsLocal(*ParseAddress("learner:1")));
  EXPECT_FALSE(IsLocal(*ParseAddress("127.example.org:1")));
  EXPECT_FALSE(IsLocal(*ParseAddress("128.0.0.1:1")));
}

TEST(Address, RefusesWhatItCannotReachByName) {
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_THAT(ParseAddress("learner"),
              StatusIs(kInvalid, HasSubstr("no port")));
  EXPECT_THAT(ParseAddress(":1"),
              StatusIs(kInvalid, HasSubstr("host is empty")));
  EXPECT_THAT(ParseAddress("h:70000"),
              StatusIs(kInvalid, HasSubstr("found \"70000\"")));
  EXPECT_THAT(ParseAddress("h:x"), StatusIs(kInvalid, HasSubstr("\"h:x\"")));
  EXPECT_THAT(ParseAddress("::1:80"),
              StatusIs(kInvalid, HasSubstr("brackets")));
  EXPECT_THAT(ParseAddress("unix:"), StatusIs(kInvalid, HasSubstr("empty")));
}

TEST(Address, RefusesASocketPathThatTheSystemWouldCut) {
  EXPECT_THAT(ParseAddress("unix:" + std::string(107, 'a')), IsOk());
  EXPECT_THAT(ParseAddress("unix:" + std::string(108, 'a')),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       HasSubstr("at most 107 bytes, found 108")));
}

}  // namespace
}  // namespace sinew::rpc
