#include "deploy/checkpoint/local_store.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/blobs/blob_file.h"
#include "common/digest.h"
#include "common/logging.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/validate_artifact.h"

namespace sinew::checkpoint {
namespace {

// Of a reader beside a writer.
constexpr int kLooks = 3;

absl::Status RemoveTemporaryFiles(const std::string& folder) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                         ListDirectory(folder));
  for (const std::string& name : names) {
    if (!IsTemporaryName(name)) continue;
    SINEW_RETURN_IF_ERROR(RemoveRecursively(JoinPath(folder, name)));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<LocalStore>> LocalStore::Open(
    const std::string& folder, const Clock& clock) {
  const StoreFolders folders(folder);
  SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<DirectoryLock> lock,
                         DirectoryLock::Acquire(folder));
  for (const std::string& part :
       {folders.blobs, folders.artifacts, folders.aliases}) {
    SINEW_RETURN_IF_ERROR(MakeDirectories(part));
    SINEW_RETURN_IF_ERROR(RemoveTemporaryFiles(part));
  }
  SINEW_ASSIGN_OR_RETURN(ArtifactIndex index, ReadIndex(folders));
  return std::unique_ptr<LocalStore>(
      new LocalStore(folder, clock, std::move(lock), std::move(index)));
}

absl::StatusOr<std::unique_ptr<LocalStore>> LocalStore::OpenReadOnly(
    const std::string& folder, const Clock& clock) {
  const StoreFolders folders(folder);
  for (const std::string& part :
       {folders.blobs, folders.artifacts, folders.aliases}) {
    if (FileExists(part)) continue;
    return absl::NotFoundError(
        absl::StrCat(folder, ": expected a checkpoint store, found no ", part));
  }
  return std::unique_ptr<LocalStore>(
      new LocalStore(folder, clock, nullptr, ArtifactIndex()));
}

LocalStore::LocalStore(const std::string& folder, const Clock& clock,
                       std::unique_ptr<DirectoryLock> lock, ArtifactIndex index)
    : folders_(folder),
      clock_(clock),
      lock_(std::move(lock)),
      index_(std::move(index)) {}

absl::Status LocalStore::CheckWritable() const {
  if (lock_ != nullptr) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(folders_.root, ": opened for reading only"));
}

absl::Status LocalStore::CheckBlobs(const v1::Artifact& artifact) const {
  for (const v1::Artifact::File& file : artifact.files()) {
    const absl::StatusOr<int64_t> size =
        FileSize(folders_.BlobPath(file.sha256()));
    if (size.ok() && *size == file.size()) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "artifact ", artifact.id(), ", file ", file.path(), ": expected blob ",
        file.sha256(), " of ", file.size(), " bytes, found ",
        size.ok() ? absl::StrCat(*size, " bytes") : "none"));
  }
  return absl::OkStatus();
}

absl::StatusOr<ArtifactIndex> LocalStore::CurrentIndex() const {
  if (lock_ == nullptr) return ReadIndex(folders_);
  MutexLock lock(mu_);
  return index_;
}

absl::StatusOr<Blob> LocalStore::GetBlob(const std::string& sha256) {
  SINEW_RETURN_IF_ERROR(ValidateDigest(sha256));
  const std::string path = folders_.BlobPath(sha256);
  SINEW_ASSIGN_OR_RETURN(std::string bytes, ReadFile(path));
  const std::string found = Sha256Hex(bytes);
  if (found != sha256) {
    return absl::DataLossError(absl::StrCat(path, ": expected SHA-256 ", sha256,
                                            ", found ", found, " (",
                                            bytes.size(), " bytes)"));
  }
  return std::make_shared<const std::string>(std::move(bytes));
}

absl::StatusOr<std::unique_ptr<BlobReader>> LocalStore::OpenBlob(
    const std::string& sha256) {
  SINEW_RETURN_IF_ERROR(ValidateDigest(sha256));
  return OpenBlobFile(folders_.BlobPath(sha256), sha256);
}

absl::StatusOr<std::string> LocalStore::PutBlob(const Blob& blob) {
  SINEW_RETURN_IF_ERROR(CheckWritable());
  const std::string sha256 = Sha256Hex(*blob);
  {
    // From here on no Retain removes the bytes, be they old or new.
    MutexLock lock(mu_);
    index_.Hold(sha256);
  }
  const std::string path = folders_.BlobPath(sha256);
  const absl::StatusOr<std::string> there =
      ReadFile(path, static_cast<int64_t>(blob->size()));
  if (there.ok() && *there == *blob) return sha256;
  if (!absl::IsNotFound(there.status())) {
    LogWarning("replacing a damaged blob", {{"path", path}});
  }
  const absl::Status status = WriteFileAtomically(path, *blob);
  if (status.ok()) return sha256;
  // They may be there and only their name not be safe.
  DropBlobs({sha256}).IgnoreError();
  return status;
}

absl::Status LocalStore::PutArtifact(const v1::Artifact& artifact) {
  SINEW_RETURN_IF_ERROR(CheckWritable());
  SINEW_RETURN_IF_ERROR(ValidateArtifact(artifact));
  MutexLock lock(mu_);
  SINEW_ASSIGN_OR_RETURN(
      const v1::Artifact record,
      index_.Admit(artifact, absl::ToUnixSeconds(clock_.WallNow())));
  SINEW_RETURN_IF_ERROR(CheckBlobs(record));
  // Perhaps a client that lost the answer: its holds are ended, and others are
  // not its own. Those of a second writer of the same become too old.
  if (index_.Contains(record.id())) return absl::OkStatus();
  SINEW_RETURN_IF_ERROR(WriteArtifactRecord(folders_, record));
  index_.Insert(record);
  for (const v1::Artifact::File& file : record.files()) {
    index_.Release(file.sha256());
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::Artifact> LocalStore::GetArtifact(const std::string& name) {
  SINEW_RETURN_IF_ERROR(ValidateName("artifact id or alias", name));
  absl::StatusOr<v1::Artifact> found;
  // Between its looks at artifacts and at aliases a reader may miss what a
  // writer puts, names and collects.
  for (int look = 0; look < (lock_ == nullptr ? kLooks : 1); ++look) {
    SINEW_ASSIGN_OR_RETURN(const ArtifactIndex index, CurrentIndex());
    found = index.Get(name);
    if (!absl::IsDataLoss(found.status())) break;
  }
  return found;
}

absl::StatusOr<v1::ListArtifactsResponse> LocalStore::ListArtifacts(
    const std::string& kind) {
  if (!kind.empty()) SINEW_RETURN_IF_ERROR(ValidateKind(kind));
  SINEW_ASSIGN_OR_RETURN(const ArtifactIndex index, CurrentIndex());
  return index.List(kind);
}

absl::Status LocalStore::SetAlias(const std::string& alias,
                                  const std::string& id,
                                  const std::string& expected_id) {
  SINEW_RETURN_IF_ERROR(CheckWritable());
  SINEW_RETURN_IF_ERROR(ValidateName("alias", alias));
  MutexLock lock(mu_);
  SINEW_RETURN_IF_ERROR(index_.CheckAlias(alias, id, expected_id));
  v1::Alias record;
  record.set_name(alias);
  record.set_id(id);
  SINEW_RETURN_IF_ERROR(WriteAliasRecord(folders_, record));
  index_.InsertAlias(alias, id);
  return absl::OkStatus();
}

absl::Status LocalStore::Retain(const std::string& kind, int keep) {
  SINEW_RETURN_IF_ERROR(CheckWritable());
  SINEW_RETURN_IF_ERROR(ValidateKind(kind));
  if (keep < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("keep: expected >= 1, found ", keep));
  }
  MutexLock lock(mu_);
  for (const auto& [alias, reason] : index_.damaged_aliases()) {
    LogWarning("nothing is collected while an alias is damaged",
               {{"alias", alias}, {"reason", reason}});
  }
  const std::vector<std::string> surplus =
      index_.Surplus(kind, keep, [this](const v1::Artifact& artifact) {
        return CheckBlobs(artifact).ok();
      });
  for (const std::string& id : surplus) {
    SINEW_RETURN_IF_ERROR(RemoveArtifactRecord(folders_, id));
    index_.Erase(id);
  }
  if (!surplus.empty()) SINEW_RETURN_IF_ERROR(SyncArtifactRecords(folders_));
  index_.Age();
  return CollectGarbage();
}

absl::Status LocalStore::DropBlobs(absl::Span<const std::string> sha256s) {
  SINEW_RETURN_IF_ERROR(CheckWritable());
  for (const std::string& sha256 : sha256s) {
    SINEW_RETURN_IF_ERROR(ValidateDigest(sha256));
  }
  MutexLock lock(mu_);
  for (const std::string& sha256 : sha256s) {
    index_.Release(sha256);
    if (index_.IsNeeded(sha256)) continue;
    SINEW_RETURN_IF_ERROR(RemoveRecursively(folders_.BlobPath(sha256)));
  }
  return absl::OkStatus();
}

absl::Status LocalStore::CollectGarbage() {
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                         ListDirectory(folders_.blobs));
  for (const std::string& name : names) {
    // Others are files that a PutBlob is writing.
    if (!IsSha256Hex(name) || index_.IsNeeded(name)) continue;
    SINEW_RETURN_IF_ERROR(RemoveRecursively(folders_.BlobPath(name)));
  }
  return absl::OkStatus();
}

}  // namespace sinew::checkpoint
