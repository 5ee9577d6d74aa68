#ifndef SINEW_DEPLOY_CHECKPOINT_STORE_RECORDS_H_
#define SINEW_DEPLOY_CHECKPOINT_STORE_RECORDS_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "deploy/checkpoint/client/artifact_index.h"
#include "proto/sinew/v1/checkpoint.pb.h"

namespace sinew::checkpoint {

// The small files of a local store. Each begins with a line "sha256 DIGEST" of
// the rest, so that a damaged one is known; the rest is v1::Artifact or
// v1::Alias in proto3 JSON. Written atomically.
//
// Thread-safe; the folder's owner keeps writers apart. Blocks on the disk.
// Errors: name the file.
struct StoreFolders {
  explicit StoreFolders(const std::string& folder);

  std::string BlobPath(const std::string& sha256) const;
  std::string ArtifactPath(const std::string& id) const;
  std::string AliasPath(const std::string& alias) const;

  const std::string root;
  const std::string blobs;
  const std::string artifacts;
  const std::string aliases;
};

absl::Status WriteArtifactRecord(const StoreFolders& folders,
                                 const v1::Artifact& artifact);
absl::Status WriteAliasRecord(const StoreFolders& folders,
                              const v1::Alias& alias);

absl::Status RemoveArtifactRecord(const StoreFolders& folders,
                                  const std::string& id);

// Forces removed records to the disk, before their blobs go.
absl::Status SyncArtifactRecords(const StoreFolders& folders);

// Everything that the folder holds. Damaged records are listed as such; files
// that go away meanwhile are left out.
absl::StatusOr<ArtifactIndex> ReadIndex(const StoreFolders& folders);

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_STORE_RECORDS_H_
