#include "common/blobs/blob_sources.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace sinew {
namespace {

// The first answer that is not NOT_FOUND, or else the last.
template <typename T, typename Ask>
absl::StatusOr<T> AskInTurn(const std::vector<BlobSource*>& sources,
                            const std::string& sha256, Ask&& ask) {
  absl::StatusOr<T> result =
      absl::NotFoundError(absl::StrCat("no blob ", sha256));
  for (BlobSource* source : sources) {
    result = ask(*source);
    if (!absl::IsNotFound(result.status())) break;
  }
  return result;
}

}  // namespace

absl::StatusOr<Blob> BlobSources::GetBlob(const std::string& sha256) {
  return AskInTurn<Blob>(sources_, sha256, [&](BlobSource& source) {
    return source.GetBlob(sha256);
  });
}

absl::StatusOr<std::unique_ptr<BlobReader>> BlobSources::OpenBlob(
    const std::string& sha256) {
  return AskInTurn<std::unique_ptr<BlobReader>>(
      sources_, sha256,
      [&](BlobSource& source) { return source.OpenBlob(sha256); });
}

}  // namespace sinew
