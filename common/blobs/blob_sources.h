#ifndef SINEW_COMMON_BLOBS_BLOB_SOURCES_H_
#define SINEW_COMMON_BLOBS_BLOB_SOURCES_H_

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/blobs/blob_reader.h"
#include "common/blobs/blob_source.h"

namespace sinew {

// Several sources asked in turn; the first that has the blob answers. Borrows
// them. Thread-safe. Errors: the last source's NOT_FOUND, or whatever else a
// source reports.
class BlobSources : public BlobSource {
 public:
  explicit BlobSources(std::vector<BlobSource*> sources)
      : sources_(std::move(sources)) {}

  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override;
  absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlob(
      const std::string& sha256) override;

 private:
  const std::vector<BlobSource*> sources_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_SOURCES_H_
