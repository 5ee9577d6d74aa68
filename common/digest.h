#ifndef SINEW_COMMON_DIGEST_H_
#define SINEW_COMMON_DIGEST_H_

#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "google/protobuf/message_lite.h"

namespace sinew {

// SHA-256 as 64 lower-case hex digits.
std::string Sha256Hex(absl::string_view bytes);

// True if `text` is 64 lower-case hex digits.
bool IsSha256Hex(absl::string_view text);

// SHA-256 of bytes that arrive in pieces.
//
// Thread-safety: one thread at a time. Blocking: never. Errors: none.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Update(absl::string_view bytes);

  // Digest of all bytes so far, as Sha256Hex. Ends the object's use.
  std::string FinishHex();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

// Serialisation with sorted map keys: equal messages give equal bytes within
// one build. Used wherever a digest of a message is taken. At most 2 GiB
// (protobuf's limit, CHECKed).
std::string SerializeDeterministically(
    const google::protobuf::MessageLite& message);

}  // namespace sinew

#endif  // SINEW_COMMON_DIGEST_H_
