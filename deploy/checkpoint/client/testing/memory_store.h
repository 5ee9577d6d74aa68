#ifndef SINEW_DEPLOY_CHECKPOINT_CLIENT_TESTING_MEMORY_STORE_H_
#define SINEW_DEPLOY_CHECKPOINT_CLIENT_TESTING_MEMORY_STORE_H_

#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/mutex.h"
#include "deploy/checkpoint/client/artifact_index.h"
#include "deploy/checkpoint/client/artifact_store.h"

namespace sinew::checkpoint {

// An ArtifactStore in memory whose bytes can be damaged and whose writes can
// fail.
//
// Thread-safety: any thread. Blocking: never, unless paused. Errors: as
// ArtifactStore.
class MemoryStore : public ArtifactStore {
 public:
  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override
      SINEW_EXCLUDES(mu_);
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

  // --- Faults ----------------------------------------------------------------
  // Flips a bit of a blob.
  void Damage(const std::string& sha256) SINEW_EXCLUDES(mu_);
  // PutBlob of new bytes is RESOURCE_EXHAUSTED beyond this many bytes in all.
  void LimitBytes(int64_t max_bytes) SINEW_EXCLUDES(mu_);
  // GetBlob returns this, unless it is OK.
  void FailReads(const absl::Status& status) SINEW_EXCLUDES(mu_);
  // PutBlob waits until Resume.
  void Pause() SINEW_EXCLUDES(mu_);
  void Resume() SINEW_EXCLUDES(mu_);
  int64_t bytes() const SINEW_EXCLUDES(mu_);

 private:
  int64_t BytesLocked() const SINEW_REQUIRES(mu_);

  mutable Mutex mu_;
  CondVar resumed_;
  ArtifactIndex index_ SINEW_GUARDED_BY(mu_);
  std::map<std::string, Blob> blobs_ SINEW_GUARDED_BY(mu_);
  int64_t max_bytes_ SINEW_GUARDED_BY(mu_) = int64_t{1} << 40;
  absl::Status read_status_ SINEW_GUARDED_BY(mu_);
  bool paused_ SINEW_GUARDED_BY(mu_) = false;
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_CLIENT_TESTING_MEMORY_STORE_H_
