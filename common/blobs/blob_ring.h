#ifndef SINEW_COMMON_BLOBS_BLOB_RING_H_
#define SINEW_COMMON_BLOBS_BLOB_RING_H_

#include <cstddef>
#include <deque>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "common/blobs/blob_source.h"
#include "common/mutex.h"

namespace sinew {

// The latest blobs in memory, so many at most: a new one pushes the oldest out.
// The learner keeps its snapshots here for actors to fetch.
//
// Thread-safety: any thread. Ownership: shares the bytes with readers.
// Blocking: never.
class BlobRing : public BlobSource {
 public:
  // `max_blobs` >= 1.
  explicit BlobRing(size_t max_blobs) : max_blobs_(max_blobs) {}

  // Adds bytes, which become the newest even if they were there already, and
  // returns their digest.
  std::string Put(std::string bytes) SINEW_EXCLUDES(mu_);

  // NOT_FOUND: never put, or pushed out since.
  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override
      SINEW_EXCLUDES(mu_);

 private:
  const size_t max_blobs_;
  Mutex mu_;
  // Oldest first.
  std::deque<std::string> order_ SINEW_GUARDED_BY(mu_);
  absl::flat_hash_map<std::string, Blob> blobs_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_RING_H_
