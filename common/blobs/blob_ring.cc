#include "common/blobs/blob_ring.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/digest.h"

namespace sinew {

std::string BlobRing::Put(std::string bytes) {
  const std::string sha256 = Sha256Hex(bytes);
  Blob blob = std::make_shared<const std::string>(std::move(bytes));
  MutexLock lock(mu_);
  if (!blobs_.emplace(sha256, std::move(blob)).second) {
    order_.erase(std::find(order_.begin(), order_.end(), sha256));
  }
  order_.push_back(sha256);
  while (order_.size() > max_blobs_) {
    blobs_.erase(order_.front());
    order_.pop_front();
  }
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

}  // namespace sinew
