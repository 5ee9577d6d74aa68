#ifndef SINEW_COMMON_BLOBS_BLOB_SOURCE_H_
#define SINEW_COMMON_BLOBS_BLOB_SOURCE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/mapped_file.h"

namespace sinew {

// Immutable bytes that several readers share; they stay readable after their
// source has dropped them.
using Blob = std::shared_ptr<const std::string>;

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

  // The same as a file on this machine, whose memory all processes share that
  // have it mapped; null: this source keeps no such files. Its bytes were
  // verified, but the file may have been replaced since: who maps it looks
  // again.
  virtual absl::StatusOr<std::shared_ptr<const MappedFile>> MapBlob(
      const std::string& /*sha256*/) {
    return nullptr;
  }
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_SOURCE_H_
