#ifndef SINEW_COMMON_RPC_ADDRESS_H_
#define SINEW_COMMON_RPC_ADDRESS_H_

#include <string>

#include "absl/status/statusor.h"

namespace sinew::rpc {

// Where a server listens or a peer is found: a unix socket or host and port.
struct Address {
  // Path of a unix socket; empty for TCP.
  std::string unix_path;
  // Host name or address (IPv6 without brackets); empty for a unix socket.
  std::string host;
  // 0 to 65535; 0 lets a server choose a free port.
  int port = 0;

  bool is_unix() const { return !unix_path.empty(); }
};

// Reads "unix:PATH" or "HOST:PORT" ("127.0.0.1:0", "[::1]:7000").
// INVALID_ARGUMENT says what was expected and found: an empty host, a port out
// of range, a socket path longer than the 107 bytes that the system takes.
absl::StatusOr<Address> ParseAddress(const std::string& text);

// The inverse of ParseAddress.
std::string AddressString(const Address& address);

// True where bytes cannot leave the machine: unix sockets and loopback.
bool IsLocal(const Address& address);

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_ADDRESS_H_
