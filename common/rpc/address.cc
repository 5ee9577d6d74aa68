#include "common/rpc/address.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/un.h>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"

namespace sinew::rpc {
namespace {

constexpr size_t kMaxSocketPath = sizeof(sockaddr_un::sun_path) - 1;

absl::Status Malformed(const std::string& text, const std::string& reason) {
  return absl::InvalidArgumentError(absl::StrCat(
      "address \"", text, "\": expected unix:PATH or HOST:PORT; ", reason));
}

absl::StatusOr<Address> ParseUnix(const std::string& text,
                                  absl::string_view path) {
  if (path.empty()) return Malformed(text, "the path is empty");
  if (path.size() > kMaxSocketPath) {
    return absl::InvalidArgumentError(absl::StrCat(
        "address \"", text, "\": a socket path has at most ", kMaxSocketPath,
        " bytes, found ", path.size(), "; use a shorter folder"));
  }
  Address address;
  address.unix_path = std::string(path);
  return address;
}

}  // namespace

absl::StatusOr<Address> ParseAddress(const std::string& text) {
  absl::string_view path = text;
  if (absl::ConsumePrefix(&path, "unix:")) return ParseUnix(text, path);
  const size_t colon = text.rfind(':');
  if (colon == std::string::npos) return Malformed(text, "no port");
  absl::string_view host = absl::string_view(text).substr(0, colon);
  if (absl::StartsWith(host, "[") && absl::EndsWith(host, "]")) {
    host = host.substr(1, host.size() - 2);
  } else if (absl::StrContains(host, ':')) {
    return Malformed(text, "an IPv6 address stands in brackets");
  }
  if (host.empty()) return Malformed(text, "the host is empty");
  int port = -1;
  if (!absl::SimpleAtoi(text.substr(colon + 1), &port) || port < 0 ||
      port > 65535) {
    return Malformed(text, absl::StrCat("the port is 0 to 65535, found \"",
                                        text.substr(colon + 1), "\""));
  }
  Address address;
  address.host = std::string(host);
  address.port = port;
  return address;
}

std::string AddressString(const Address& address) {
  if (address.is_unix()) return absl::StrCat("unix:", address.unix_path);
  if (absl::StrContains(address.host, ':')) {
    return absl::StrCat("[", address.host, "]:", address.port);
  }
  return absl::StrCat(address.host, ":", address.port);
}

bool IsLocal(const Address& address) {
  if (address.is_unix() || address.host == "localhost") return true;
  // 127.0.0.0/8; a name that begins so may be anybody's.
  in_addr four;
  if (inet_pton(AF_INET, address.host.c_str(), &four) == 1) {
    return ntohl(four.s_addr) >> 24 == 127;
  }
  return address.host == "::1";
}

}  // namespace sinew::rpc
