#ifndef SINEW_DEPLOY_CHECKPOINT_LOCAL_STORE_H_
#define SINEW_DEPLOY_CHECKPOINT_LOCAL_STORE_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/blobs/blob_reader.h"
#include "common/clock.h"
#include "common/files.h"
#include "common/mutex.h"
#include "deploy/checkpoint/client/artifact_index.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/store_records.h"

namespace sinew::checkpoint {

// An ArtifactStore in a folder:
//
//   FOLDER/LOCK               held by the one process that writes
//   FOLDER/blobs/SHA256       bytes, named by their digest
//   FOLDER/artifacts/ID       record of an artifact (store_records.h)
//   FOLDER/aliases/NAME       record of an alias
//
// Every file is written beside its place, forced to the disk and renamed; blobs
// come before the record that names them, and records go before their blobs.
// So a kill at any point leaves a store in which each artifact is whole or not
// there, and at most some bytes that the next Retain collects.
//
// Thread-safety: any thread. Ownership: borrows the clock, which dates records
// for people. Blocking: on the disk; records are written under the mutex, bytes
// of blobs are not. Errors: as ArtifactStore; paths are named.
class LocalStore : public ArtifactStore {
 public:
  // For writing: makes what is missing, removes what a killed writer left half
  // done. FAILED_PRECONDITION naming the process that has the folder open.
  static absl::StatusOr<std::unique_ptr<LocalStore>> Open(
      const std::string& folder, const Clock& clock);

  // For reading, beside a process that writes; whatever changes the store is
  // FAILED_PRECONDITION. NOT_FOUND: no store is there.
  static absl::StatusOr<std::unique_ptr<LocalStore>> OpenReadOnly(
      const std::string& folder, const Clock& clock);

  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override;
  absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlob(
      const std::string& sha256) override;
  absl::StatusOr<std::string> PutBlob(const Blob& blob) override
      SINEW_EXCLUDES(mu_);
  absl::Status PutArtifact(const v1::Artifact& artifact) override
      SINEW_EXCLUDES(mu_);
  absl::StatusOr<v1::Artifact> GetArtifact(const std::string& name) override
      SINEW_EXCLUDES(mu_);
  absl::StatusOr<v1::ListArtifactsResponse> ListArtifacts(
      const std::string& kind) override SINEW_EXCLUDES(mu_);
  absl::Status SetAlias(const std::string& alias, const std::string& id,
                        const std::string& expected_id = "") override
      SINEW_EXCLUDES(mu_);
  absl::Status Retain(const std::string& kind, int keep) override
      SINEW_EXCLUDES(mu_);
  absl::Status DropBlobs(absl::Span<const std::string> sha256s) override
      SINEW_EXCLUDES(mu_);

 private:
  LocalStore(const std::string& folder, const Clock& clock,
             std::unique_ptr<DirectoryLock> lock, ArtifactIndex index);

  absl::Status CheckWritable() const;
  // Every blob of an artifact is there, by name and size.
  absl::Status CheckBlobs(const v1::Artifact& artifact) const;
  // What is known now: of the writer's memory, or of the disk.
  absl::StatusOr<ArtifactIndex> CurrentIndex() const SINEW_EXCLUDES(mu_);
  // Removes the blobs that nothing needs.
  absl::Status CollectGarbage() SINEW_REQUIRES(mu_);

  const StoreFolders folders_;
  const Clock& clock_;
  // Null: read only.
  const std::unique_ptr<DirectoryLock> lock_;

  mutable Mutex mu_;
  ArtifactIndex index_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_LOCAL_STORE_H_
