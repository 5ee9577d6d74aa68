#ifndef SINEW_COMMON_RPC_CHUNKS_H_
#define SINEW_COMMON_RPC_CHUNKS_H_

#include <algorithm>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace sinew::rpc {

// Bytes of one chunk of a streamed payload; well below gRPC's 4 MiB limit.
inline constexpr int64_t kChunkBytes = 256 * 1024;

// Calls send(chunk, first) for consecutive chunks of `bytes` from `offset` on;
// at least once, so that the first message of an empty payload is sent too.
// Stops and returns false as soon as `send` does. Precondition: offset within
// [0, size].
template <typename Send>
bool ForEachChunk(absl::string_view bytes, int64_t offset, Send&& send) {
  bool first = true;
  absl::string_view rest = bytes.substr(offset);
  while (first || !rest.empty()) {
    const size_t size = std::min<size_t>(rest.size(), kChunkBytes);
    if (!send(rest.substr(0, size), first)) return false;
    rest.remove_prefix(size);
    first = false;
  }
  return true;
}

// Puts a payload together from chunks whose total size was declared first.
//
//   ChunkAssembler payload(/*max_bytes=*/64 << 20);
//   Begin(total) Append(chunk)* complete() Release() Begin(...) ...
//
// Thread-safety: one thread. Ownership: owns the bytes until Release.
// Blocking: never. Errors: sizes that disagree; nothing is allocated for a
// payload that is refused.
class ChunkAssembler {
 public:
  // Payloads of more than `max_bytes` are refused.
  explicit ChunkAssembler(int64_t max_bytes) : max_bytes_(max_bytes) {}

  // Starts a payload, dropping an unfinished one. INVALID_ARGUMENT: negative;
  // RESOURCE_EXHAUSTED: over the limit.
  absl::Status Begin(int64_t total_bytes);

  // INVALID_ARGUMENT: not begun, or more bytes than declared.
  absl::Status Append(absl::string_view chunk);

  // True when a payload was begun and all of its bytes are there.
  bool complete() const {
    return begun_ && static_cast<int64_t>(bytes_.size()) == total_bytes_;
  }
  bool begun() const { return begun_; }
  int64_t received_bytes() const { return static_cast<int64_t>(bytes_.size()); }

  // Hands the payload out and waits for the next Begin.
  std::string Release();

 private:
  const int64_t max_bytes_;
  int64_t total_bytes_ = 0;
  bool begun_ = false;
  std::string bytes_;
};

}  // namespace sinew::rpc

#endif  // SINEW_COMMON_RPC_CHUNKS_H_
