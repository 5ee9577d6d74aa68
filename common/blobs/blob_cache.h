#ifndef SINEW_COMMON_BLOBS_BLOB_CACHE_H_
#define SINEW_COMMON_BLOBS_BLOB_CACHE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/blobs/blob_source.h"

namespace sinew {

// A folder of blobs, each in a file named by its digest, in front of a source
// that is slower: what is asked for once stays. Several processes may share the
// folder. Bounded: the files that were used longest ago are removed.
//
// Thread-safety: any thread. Ownership: borrows the source. Blocking: on disk
// and source. Errors: the source's; a file that does not match its name is
// fetched anew, and a folder that cannot be written is only no cache.
class BlobCache : public BlobSource {
 public:
  // Makes the folder if need be. `max_bytes` >= 0: bound of all files.
  static absl::StatusOr<std::unique_ptr<BlobCache>> Create(
      const std::string& folder, int64_t max_bytes, BlobSource& source);

  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override;
  absl::StatusOr<SharedBytes> MapBlob(const std::string& sha256) override;

 private:
  BlobCache(std::string folder, int64_t max_bytes, BlobSource& source);

  absl::StatusOr<Blob> Read(const std::string& sha256) const;
  absl::Status Write(const std::string& sha256, const Blob& blob) const;
  // Removes files until `extra_bytes` more fit.
  absl::Status MakeRoom(int64_t extra_bytes) const;

  const std::string folder_;
  const int64_t max_bytes_;
  BlobSource& source_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_CACHE_H_
