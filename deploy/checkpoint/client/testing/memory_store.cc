#include "deploy/checkpoint/client/testing/memory_store.h"

#include <chrono>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/validate_artifact.h"

namespace sinew::checkpoint {

absl::StatusOr<Blob> MemoryStore::GetBlob(const std::string& sha256) {
  SINEW_RETURN_IF_ERROR(ValidateDigest(sha256));
  MutexLock lock(mu_);
  SINEW_RETURN_IF_ERROR(read_status_);
  const auto found = blobs_.find(sha256);
  if (found == blobs_.end()) {
    return absl::NotFoundError(absl::StrCat("no blob ", sha256));
  }
  const std::string digest = Sha256Hex(*found->second);
  if (digest == sha256) return found->second;
  return absl::DataLossError(
      absl::StrCat("memory: expected SHA-256 ", sha256, ", found ", digest));
}

absl::StatusOr<std::string> MemoryStore::PutBlob(const Blob& blob) {
  std::string sha256 = Sha256Hex(*blob);
  const auto deadline =
      std::chrono::steady_clock::now() + std::chrono::seconds(30);
  MutexLock lock(mu_);
  while (paused_ && resumed_.WaitUntil(mu_, deadline)) {
  }
  if (!blobs_.contains(sha256) &&
      BytesLocked() + static_cast<int64_t>(blob->size()) > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("memory: no room for ", blob->size(), " bytes"));
  }
  index_.Hold(sha256);
  blobs_[sha256] = blob;
  return sha256;
}

absl::Status MemoryStore::PutArtifact(const v1::Artifact& artifact) {
  SINEW_RETURN_IF_ERROR(ValidateArtifact(artifact));
  MutexLock lock(mu_);
  SINEW_ASSIGN_OR_RETURN(const v1::Artifact record, index_.Admit(artifact, 1));
  for (const v1::Artifact::File& file : record.files()) {
    const auto found = blobs_.find(file.sha256());
    if (found != blobs_.end() &&
        static_cast<int64_t>(found->second->size()) == file.size()) {
      continue;
    }
    return absl::FailedPreconditionError(
        absl::StrCat("file ", file.path(), ": expected blob ", file.sha256(),
                     " of ", file.size(), " bytes"));
  }
  if (index_.Contains(record.id())) return absl::OkStatus();
  index_.Insert(record);
  for (const v1::Artifact::File& file : record.files()) {
    index_.Release(file.sha256());
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::Artifact> MemoryStore::GetArtifact(const std::string& name) {
  SINEW_RETURN_IF_ERROR(ValidateName("artifact id or alias", name));
  MutexLock lock(mu_);
  return index_.Get(name);
}

absl::StatusOr<v1::ListArtifactsResponse> MemoryStore::ListArtifacts(
    const std::string& kind) {
  if (!kind.empty()) SINEW_RETURN_IF_ERROR(ValidateKind(kind));
  MutexLock lock(mu_);
  return index_.List(kind);
}

absl::Status MemoryStore::SetAlias(const std::string& alias,
                                   const std::string& id,
                                   const std::string& expected_id) {
  SINEW_RETURN_IF_ERROR(ValidateName("alias", alias));
  MutexLock lock(mu_);
  SINEW_RETURN_IF_ERROR(index_.CheckAlias(alias, id, expected_id));
  index_.InsertAlias(alias, id);
  return absl::OkStatus();
}

absl::Status MemoryStore::Retain(const std::string& kind, int keep) {
  SINEW_RETURN_IF_ERROR(ValidateKind(kind));
  if (keep < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("keep: expected >= 1, found ", keep));
  }
  MutexLock lock(mu_);
  for (const std::string& id :
       index_.Surplus(kind, keep, [](const auto&) { return true; })) {
    index_.Erase(id);
  }
  index_.Age();
  std::erase_if(blobs_, [this](const auto& blob) SINEW_REQUIRES(mu_) {
    return !index_.IsNeeded(blob.first);
  });
  return absl::OkStatus();
}

absl::Status MemoryStore::DropBlobs(absl::Span<const std::string> sha256s) {
  for (const std::string& sha256 : sha256s) {
    SINEW_RETURN_IF_ERROR(ValidateDigest(sha256));
  }
  MutexLock lock(mu_);
  for (const std::string& sha256 : sha256s) {
    index_.Release(sha256);
    if (!index_.IsNeeded(sha256)) blobs_.erase(sha256);
  }
  return absl::OkStatus();
}

void MemoryStore::Damage(const std::string& sha256) {
  MutexLock lock(mu_);
  std::string bytes = *blobs_.at(sha256);
  bytes.back() ^= 1;
  blobs_[sha256] = std::make_shared<const std::string>(std::move(bytes));
}

void MemoryStore::LimitBytes(int64_t max_bytes) {
  MutexLock lock(mu_);
  max_bytes_ = max_bytes;
}

void MemoryStore::FailReads(const absl::Status& status) {
  MutexLock lock(mu_);
  read_status_ = status;
}

void MemoryStore::Pause() {
  MutexLock lock(mu_);
  paused_ = true;
}

void MemoryStore::Resume() {
  MutexLock lock(mu_);
  paused_ = false;
  resumed_.NotifyAll();
}

int64_t MemoryStore::bytes() const {
  MutexLock lock(mu_);
  return BytesLocked();
}

int64_t MemoryStore::BytesLocked() const {
  int64_t bytes = 0;
  for (const auto& [sha256, blob] : blobs_) {
    bytes += static_cast<int64_t>(blob->size());
  }
  return bytes;
}

}  // namespace sinew::checkpoint
