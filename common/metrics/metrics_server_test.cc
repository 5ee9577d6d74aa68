#include "common/metrics/metrics_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "absl/status/status.h"
#include "common/rpc/address.h"
#include "common/testing/matchers.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace sinew::metrics {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::HasSubstr;

// What a scraper reads from loopback.
std::string Scrape(const std::string& address) {
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in name = {};
  name.sin_family = AF_INET;
  name.sin_port =
      htons(static_cast<uint16_t>(rpc::ParseAddress(address)->port));
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&name), sizeof(name)), 0);
  const std::string request = "GET /metrics HTTP/1.0\r\n\r\n";
  EXPECT_EQ(write(fd, request.data(), request.size()),
            static_cast<ssize_t>(request.size()));
  std::string answer;
  char buffer[4096];
  for (ssize_t n; (n = read(fd, buffer, sizeof(buffer))) > 0;) {
    answer.append(buffer, n);
  }
  close(fd);
  return answer;
}

TEST(MetricsServer, AnswersScrapesOnAPortOfItsChoice) {
  Registry registry({.role = "replay", .build = "abc"});
  registry.AddCounter("sinew_things_total", "Things.").Increment(7);
  const auto server = MetricsServer::Start("127.0.0.1:0", registry);
  ASSERT_THAT(server, IsOk());

  const std::string answer = Scrape((*server)->address());

  EXPECT_THAT(answer, HasSubstr("200 OK"));
  EXPECT_THAT(answer, HasSubstr("sinew_things_total 7"));
  EXPECT_THAT(answer, HasSubstr("process_cpu_seconds_total"));
}

TEST(MetricsServer, NamesAPortThatIsInUse) {
  Registry registry({.role = "replay", .build = ""});
  const auto first = MetricsServer::Start("127.0.0.1:0", registry);
  ASSERT_THAT(first, IsOk());

  EXPECT_THAT(MetricsServer::Start((*first)->address(), registry),
              StatusIs(absl::StatusCode::kAlreadyExists,
                       HasSubstr((*first)->address())));
}

TEST(MetricsServer, RefusesWhatIsNoTcpAddress) {
  Registry registry({.role = "replay", .build = ""});

  EXPECT_THAT(MetricsServer::Start("unix:/tmp/x", registry),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

}  // namespace
}  // namespace sinew::metrics
