#ifndef SINEW_COMMON_BLOBS_BLOB_SOURCE_H_
#define SINEW_COMMON_BLOBS_BLOB_SOURCE_H_

#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/blobs/blob_reader.h"
#include "common/mapped_file.h"

namespace sinew {

// Immutable bytes that several readers share; they stay readable after their
// source has dropped them.
using Blob = std::shared_ptr<const std::string>;

// Bytes in memory or in a mapped file: one of the two is set.
struct SharedBytes {
  Blob blob;
  std::shared_ptr<const MappedFile> file;

  absl::string_view view() const {
    return file != nullptr ? file->bytes() : absl::string_view(*blob);
  }
};

// Content-addressed bytes: a store on disk, snapshots in memory, a peer.
//
// Thread-safety: any thread. Ownership: results are shared. Blocking: on the
// disk or the network, never for ever. Errors: NOT_FOUND names the digest;
// DATA_LOSS: the bytes are there but do not match it.
class BlobSource {
 public:
  virtual ~BlobSource() = default;

  // The bytes whose SHA-256 is `sha256` (64 lower-case hex digits, else
  // INVALID_ARGUMENT), verified.
  virtual absl::StatusOr<Blob> GetBlob(const std::string& sha256) = 0;

  // The same, as a file of this machine where the source keeps one: all
  // processes that have it mapped share its memory. Its bytes were verified,
  // but the file may have been replaced since: who needs to be sure looks
  // again.
  virtual absl::StatusOr<SharedBytes> MapBlob(const std::string& sha256) {
    absl::StatusOr<Blob> blob = GetBlob(sha256);
    if (!blob.ok()) return blob.status();
    return SharedBytes{.blob = *std::move(blob), .file = nullptr};
  }

  // The same, to be read piece by piece: not in memory as a whole where the
  // source keeps it elsewhere. It was verified as a whole when it was opened;
  // who needs to be sure of what is read later looks again.
  virtual absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlob(
      const std::string& sha256) {
    absl::StatusOr<Blob> blob = GetBlob(sha256);
    if (!blob.ok()) return blob.status();
    return std::make_unique<WholeBlobReader>(*std::move(blob));
  }
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_SOURCE_H_
