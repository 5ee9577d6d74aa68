#ifndef SINEW_COMMON_RPC_CREDENTIALS_H_
#define SINEW_COMMON_RPC_CREDENTIALS_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/rpc/address.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/security/server_credentials.h"

namespace sinew::rpc {

// How peers prove who they are. Three files mean mutual TLS: both sides show a
// certificate that the authority signed, and clients also check the server's
// name. No files mean plain text, which is accepted on unix sockets and
// loopback only, unless `allow_insecure` is set.
struct Security {
  // PEM files: own certificate chain, its private key, the authority that
  // signs the peers' certificates. All or none.
  std::string certificate_file;
  std::string key_file;
  std::string authority_file;
  // Permits plain text to and from other machines.
  bool allow_insecure = false;

  bool has_tls() const { return !certificate_file.empty(); }
};

// Credentials for a listener or a channel at `address`; unix sockets always
// speak plain text (the file's permissions guard them). The files are checked
// at once and read again when they change. INVALID_ARGUMENT: some files given
// but not all; a file that does not parse, or a key that does not fit its
// certificate (the message names the file). FAILED_PRECONDITION: plain text
// beyond this machine without `allow_insecure`. NOT_FOUND, PERMISSION_DENIED:
// an unreadable file. Thread-safe; blocks on the disk.
absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeServerCredentials(
    const Address& address, const Security& security);
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>>
MakeChannelCredentials(const Address& address, const Security& security);

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_CREDENTIALS_H_
