#include "common/rpc/chunks.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace sinew::rpc {

absl::Status ChunkAssembler::Begin(int64_t total_bytes) {
  begun_ = false;
  bytes_.clear();
  if (total_bytes < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("declared size: expected >= 0, found ", total_bytes));
  }
  if (total_bytes > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("declared size: expected at most ", max_bytes_,
                     " bytes, found ", total_bytes));
  }
  begun_ = true;
  total_bytes_ = total_bytes;
  bytes_.reserve(total_bytes);
  return absl::OkStatus();
}

absl::Status ChunkAssembler::Append(absl::string_view chunk) {
  if (!begun_) {
    return absl::InvalidArgumentError(
        "chunk: expected a first message with the total size");
  }
  if (static_cast<int64_t>(bytes_.size() + chunk.size()) > total_bytes_) {
    return absl::InvalidArgumentError(
        absl::StrCat("payload: expected ", total_bytes_, " bytes, found ",
                     bytes_.size() + chunk.size(), " or more"));
  }
  bytes_.append(chunk.data(), chunk.size());
  return absl::OkStatus();
}

std::string ChunkAssembler::Release() {
  begun_ = false;
  return std::exchange(bytes_, std::string());
}

}  // namespace sinew::rpc
