#include "common/rpc/testing/certificates.h"

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <memory>

#include "common/check.h"
#include "common/files.h"

namespace sinew::rpc {
namespace {

using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;

constexpr int64_t kDaySeconds = 86400;

Key MakeKey() {
  Key key(EVP_EC_gen("P-256"), &EVP_PKEY_free);
  SINEW_CHECK(key != nullptr);
  return key;
}

void AddExtension(X509* certificate, int id, const char* value) {
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, nullptr, id, value);
  SINEW_CHECK(extension != nullptr) << value;
  SINEW_CHECK(X509_add_ext(certificate, extension, -1) == 1);
  X509_EXTENSION_free(extension);
}

// A certificate for `key` without issuer and signature.
Certificate MakeCertificate(EVP_PKEY* key, const char* name, long serial) {
  Certificate certificate(X509_new(), &X509_free);
  X509_set_version(certificate.get(), X509_VERSION_3);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), serial);
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -kDaySeconds);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), kDaySeconds);
  X509_set_pubkey(certificate.get(), key);
  X509_NAME_add_entry_by_txt(
      X509_get_subject_name(certificate.get()), "CN", MBSTRING_ASC,
      reinterpret_cast<const unsigned char*>(name), -1, -1, 0);
  return certificate;
}

void Sign(X509* certificate, X509* issuer, EVP_PKEY* issuer_key) {
  X509_set_issuer_name(certificate, X509_get_subject_name(issuer));
  SINEW_CHECK(X509_sign(certificate, issuer_key, EVP_sha256()) > 0);
}

template <typename Write>
void WritePem(const std::string& path, Write write) {
  BIO* bio = BIO_new_file(path.c_str(), "w");
  SINEW_CHECK(bio != nullptr) << path;
  SINEW_CHECK(write(bio) == 1) << path;
  BIO_free(bio);
}

}  // namespace

Security MakeCertificates(const std::string& folder,
                          const std::string& prefix) {
  const Key authority_key = MakeKey();
  const Certificate authority =
      MakeCertificate(authority_key.get(), "authority", /*serial=*/1);
  AddExtension(authority.get(), NID_basic_constraints, "critical,CA:TRUE");
  Sign(authority.get(), authority.get(), authority_key.get());
  const Key key = MakeKey();
  const Certificate certificate =
      MakeCertificate(key.get(), "sinew", /*serial=*/2);
  AddExtension(certificate.get(), NID_subject_alt_name,
               "DNS:localhost,IP:127.0.0.1");
  Sign(certificate.get(), authority.get(), authority_key.get());

  Security files;
  files.certificate_file = JoinPath(folder, prefix + "-cert.pem");
  files.key_file = JoinPath(folder, prefix + "-key.pem");
  files.authority_file = JoinPath(folder, prefix + "-ca.pem");
  WritePem(files.certificate_file, [&](BIO* bio) {
    return PEM_write_bio_X509(bio, certificate.get());
  });
  WritePem(files.key_file, [&](BIO* bio) {
    return PEM_write_bio_PrivateKey(bio, key.get(), nullptr, nullptr, 0,
                                    nullptr, nullptr);
  });
  WritePem(files.authority_file,
           [&](BIO* bio) { return PEM_write_bio_X509(bio, authority.get()); });
  return files;
}

}  // namespace sinew::rpc
