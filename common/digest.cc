#include "common/digest.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/string_view.h"
#include "common/check.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "google/protobuf/message_lite.h"
#include "openssl/evp.h"

namespace sinew {
namespace {

constexpr size_t kHexDigits = 64;

}  // namespace

struct Sha256::Context {
  Context() : evp(EVP_MD_CTX_new()) {
    SINEW_CHECK(evp != nullptr) << "out of memory";
    SINEW_CHECK(EVP_DigestInit_ex(evp, EVP_sha256(), nullptr) == 1)
        << "OpenSSL has no SHA-256";
  }
  ~Context() { EVP_MD_CTX_free(evp); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  EVP_MD_CTX* const evp;
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {}

Sha256::~Sha256() = default;

void Sha256::Update(absl::string_view bytes) {
  SINEW_CHECK(EVP_DigestUpdate(context_->evp, bytes.data(), bytes.size()) == 1)
      << "digest already finished";
}

std::string Sha256::FinishHex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned int size = 0;
  SINEW_CHECK(EVP_DigestFinal_ex(context_->evp, digest.data(), &size) == 1)
      << "digest already finished";
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(digest.data()), size));
}

std::string Sha256Hex(absl::string_view bytes) {
  Sha256 digest;
  digest.Update(bytes);
  return digest.FinishHex();
}

bool IsSha256Hex(absl::string_view text) {
  return text.size() == kHexDigits &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

std::string SerializeDeterministically(
    const google::protobuf::MessageLite& message) {
  std::string bytes;
  {
    google::protobuf::io::StringOutputStream stream(&bytes);
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    SINEW_CHECK(message.SerializeToCodedStream(&coded))
        << message.GetTypeName() << " is larger than 2 GiB";
  }
  return bytes;
}

}  // namespace sinew
