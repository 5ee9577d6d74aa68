#ifndef SINEW_COMMON_BLOBS_BLOB_FILE_H_
#define SINEW_COMMON_BLOBS_BLOB_FILE_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/blobs/blob_reader.h"

namespace sinew {

// A file as a blob, read as it is needed. Its content is verified first, in
// pieces: that reads all of it once, and holds one piece in memory. The file
// may be removed or replaced meanwhile, the reader goes on with what was there.
//
// Blocking: on the disk. Errors: name the path; NOT_FOUND; FAILED_PRECONDITION:
// not a regular file; DATA_LOSS: its SHA-256 is not `sha256`.
absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlobFile(
    const std::string& path, const std::string& sha256);

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_FILE_H_
