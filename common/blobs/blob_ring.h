#ifndef SINEW_COMMON_BLOBS_BLOB_RING_H_
#define SINEW_COMMON_BLOBS_BLOB_RING_H_

#include <cstdint>
#include <deque>
#include <string>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/blobs/blob_source.h"
#include "common/mutex.h"

namespace sinew {

// The latest blobs in memory, bounded in bytes: a new one pushes the oldest
// out. The learner keeps its snapshots here for actors to fetch.
//
// Thread-safety: any thread. Ownership: shares the bytes with readers.
// Blocking: never. Errors: a blob larger than the whole bound is refused.
class BlobRing : public BlobSource {
 public:
  // `max_bytes` >= 1.
  explicit BlobRing(int64_t max_bytes) : max_bytes_(max_bytes) {}

  // Adds bytes, which become the newest even if they were there already, and
  // returns their digest. RESOURCE_EXHAUSTED: larger than the bound.
  absl::StatusOr<std::string> Put(std::string bytes) SINEW_EXCLUDES(mu_);

  // NOT_FOUND: never put, or pushed out since.
  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override
      SINEW_EXCLUDES(mu_);

  int64_t bytes() const SINEW_EXCLUDES(mu_);

 private:
  void DropOldest() SINEW_REQUIRES(mu_);

  const int64_t max_bytes_;
  mutable Mutex mu_;
  // Oldest first.
  std::deque<std::string> order_ SINEW_GUARDED_BY(mu_);
  absl::flat_hash_map<std::string, Blob> blobs_ SINEW_GUARDED_BY(mu_);
  int64_t bytes_ SINEW_GUARDED_BY(mu_) = 0;
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_RING_H_
