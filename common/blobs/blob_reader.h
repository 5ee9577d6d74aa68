#ifndef SINEW_COMMON_BLOBS_BLOB_READER_H_
#define SINEW_COMMON_BLOBS_BLOB_READER_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace sinew {

// A blob's bytes, piece by piece: whoever sends them on needs no more of them
// in memory than a piece.
//
// Thread-safety: one thread at a time. Ownership: keeps what it reads from,
// also when its source drops the blob. Blocking: on the disk. Errors: of the
// disk.
class BlobReader {
 public:
  virtual ~BlobReader() = default;

  virtual int64_t size() const = 0;

  // The bytes from `offset`, in [0, size()], on: `max_bytes` (>= 1), or fewer
  // at the end. Valid until the next call.
  virtual absl::StatusOr<absl::string_view> Read(int64_t offset,
                                                 int64_t max_bytes) = 0;
};

// Bytes that are in memory anyway.
class WholeBlobReader final : public BlobReader {
 public:
  explicit WholeBlobReader(std::shared_ptr<const std::string> blob)
      : blob_(std::move(blob)) {}

  int64_t size() const override { return static_cast<int64_t>(blob_->size()); }
  absl::StatusOr<absl::string_view> Read(int64_t offset,
                                         int64_t max_bytes) override {
    return absl::string_view(*blob_).substr(offset, max_bytes);
  }

 private:
  const std::shared_ptr<const std::string> blob_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_READER_H_
