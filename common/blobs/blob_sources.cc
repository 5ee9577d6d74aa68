#include "common/blobs/blob_sources.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace sinew {

absl::StatusOr<Blob> BlobSources::GetBlob(const std::string& sha256) {
  absl::StatusOr<Blob> result =
      absl::NotFoundError(absl::StrCat("no blob ", sha256));
  for (BlobSource* source : sources_) {
    result = source->GetBlob(sha256);
    if (!absl::IsNotFound(result.status())) break;
  }
  return result;
}

}  // namespace sinew
