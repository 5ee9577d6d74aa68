#include "common/blobs/blob_ring.h"

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "common/digest.h"

namespace sinew {

absl::StatusOr<std::string> BlobRing::Put(std::string bytes) {
  const int64_t size = static_cast<int64_t>(bytes.size());
  if (size > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("blob: expected at most ", max_bytes_,
                     " bytes in memory, found ", size));
  }
  const std::string sha256 = Sha256Hex(bytes);
  Blob blob = std::make_shared<const std::string>(std::move(bytes));
  MutexLock lock(mu_);
  if (blobs_.contains(sha256)) {
    order_.erase(std::find(order_.begin(), order_.end(), sha256));
  } else {
    blobs_.emplace(sha256, std::move(blob));
    bytes_ += size;
  }
  order_.push_back(sha256);
  while (bytes_ > max_bytes_) DropOldest();
  return sha256;
}

absl::StatusOr<Blob> BlobRing::GetBlob(const std::string& sha256) {
  if (!IsSha256Hex(sha256)) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected a SHA-256, found \"", sha256, "\""));
  }
  MutexLock lock(mu_);
  const auto found = blobs_.find(sha256);
  if (found == blobs_.end()) {
    return absl::NotFoundError(absl::StrCat("no blob ", sha256, " in memory"));
  }
  return found->second;
}

int64_t BlobRing::bytes() const {
  MutexLock lock(mu_);
  return bytes_;
}

void BlobRing::DropOldest() {
  const auto found = blobs_.find(order_.front());
  bytes_ -= static_cast<int64_t>(found->second->size());
  blobs_.erase(found);
  order_.pop_front();
}

}  // namespace sinew
