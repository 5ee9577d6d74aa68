#include "common/rpc/credentials.h"

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "grpcpp/security/tls_certificate_provider.h"
#include "grpcpp/security/tls_credentials_options.h"

namespace sinew::rpc {
namespace {

namespace tls = grpc::experimental;

constexpr unsigned kRefreshSeconds = 60;
constexpr int64_t kMaxPemBytes = 1 << 20;

using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;
using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

Bio MemoryBio(absl::string_view text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())),
             &BIO_free);
}

absl::StatusOr<Certificate> ReadCertificate(const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMaxPemBytes));
  Certificate certificate(
      PEM_read_bio_X509(MemoryBio(text).get(), nullptr, nullptr, nullptr),
      &X509_free);
  if (certificate == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": expected a PEM certificate"));
  }
  return certificate;
}

absl::StatusOr<Key> ReadKey(const std::string& path) {
  SINEW_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMaxPemBytes));
  Key key(
      PEM_read_bio_PrivateKey(MemoryBio(text).get(), nullptr, nullptr, nullptr),
      &EVP_PKEY_free);
  if (key == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": expected a PEM private key without password"));
  }
  return key;
}

absl::Status CheckFiles(const Security& security) {
  if (security.key_file.empty() || security.authority_file.empty() ||
      security.certificate_file.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "TLS: expected certificate, key and authority files, found "
        "certificate \"",
        security.certificate_file, "\", key \"", security.key_file,
        "\", authority \"", security.authority_file, "\""));
  }
  SINEW_ASSIGN_OR_RETURN(const Certificate certificate,
                         ReadCertificate(security.certificate_file));
  SINEW_ASSIGN_OR_RETURN(const Key key, ReadKey(security.key_file));
  SINEW_RETURN_IF_ERROR(ReadCertificate(security.authority_file).status());
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    return absl::InvalidArgumentError(absl::StrCat(security.key_file,
                                                   ": not the private key of ",
                                                   security.certificate_file));
  }
  return absl::OkStatus();
}

// True: speak TLS. False: plain text is fine here.
absl::StatusOr<bool> UseTls(const Address& address, const Security& security) {
  const bool any_file = !security.certificate_file.empty() ||
                        !security.key_file.empty() ||
                        !security.authority_file.empty();
  if (any_file) {
    SINEW_RETURN_IF_ERROR(CheckFiles(security));
    return !address.is_unix();
  }
  if (!IsLocal(address) && !security.allow_insecure) {
    return absl::FailedPreconditionError(absl::StrCat(
        AddressString(address),
        ": plain text is for unix sockets and loopback; expected TLS "
        "certificate, key and authority files, or --allow-insecure"));
  }
  return false;
}

std::shared_ptr<tls::FileWatcherCertificateProvider> MakeProvider(
    const Security& security) {
  return std::make_shared<tls::FileWatcherCertificateProvider>(
      security.key_file, security.certificate_file, security.authority_file,
      kRefreshSeconds);
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeServerCredentials(
    const Address& address, const Security& security) {
  SINEW_ASSIGN_OR_RETURN(const bool use_tls, UseTls(address, security));
  if (!use_tls) return grpc::InsecureServerCredentials();
  tls::TlsServerCredentialsOptions options(MakeProvider(security));
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  options.set_cert_request_type(
      GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  return tls::TlsServerCredentials(options);
}

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>>
MakeChannelCredentials(const Address& address, const Security& security) {
  SINEW_ASSIGN_OR_RETURN(const bool use_tls, UseTls(address, security));
  if (!use_tls) return grpc::InsecureChannelCredentials();
  tls::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(MakeProvider(security));
  options.watch_root_certs();
  options.watch_identity_key_cert_pairs();
  return tls::TlsCredentials(options);
}

}  // namespace sinew::rpc
