#include "deploy/checkpoint/store_records.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/validate_artifact.h"
#include "google/protobuf/util/json_util.h"

namespace sinew::checkpoint {
namespace {

constexpr char kSeal[] = "sha256 ";
constexpr int64_t kMaxRecordBytes = 16 << 20;

absl::Status WriteSealed(const std::string& path,
                         const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  std::string json;
  const auto printed =
      google::protobuf::util::MessageToJsonString(message, &json, options);
  if (!printed.ok()) {
    return absl::InternalError(
        absl::StrCat("cannot write ", path, ": ", printed.ToString()));
  }
  return WriteFileAtomically(path,
                             absl::StrCat(kSeal, Sha256Hex(json), "\n", json));
}

// DATA_LOSS: not what was written. Fields that a later version added are
// ignored.
absl::Status ReadSealed(const std::string& path,
                        google::protobuf::Message& message) {
  SINEW_ASSIGN_OR_RETURN(const std::string content,
                         ReadFile(path, kMaxRecordBytes));
  absl::string_view rest = content;
  const size_t line = rest.find('\n');
  if (line == absl::string_view::npos || !absl::ConsumePrefix(&rest, kSeal)) {
    return absl::DataLossError(
        absl::StrCat(path, ": expected a first line \"sha256 DIGEST\", found ",
                     content.size(), " other bytes"));
  }
  const std::string expected(
      content.substr(sizeof(kSeal) - 1, line - (sizeof(kSeal) - 1)));
  const std::string json = content.substr(line + 1);
  const std::string found = Sha256Hex(json);
  if (found != expected) {
    return absl::DataLossError(
        absl::StrCat(path, ": expected SHA-256 ", expected, ", found ", found));
  }
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  const auto parsed =
      google::protobuf::util::JsonStringToMessage(json, &message, options);
  if (parsed.ok()) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(path, ": ", parsed.ToString()));
}

// What became of a record file.
enum class Reading { kGood, kGone, kDamaged };

// Other errors (no descriptors left, an unreadable disk) are returned: to take
// such a record for damaged would give its blobs up.
absl::StatusOr<Reading> ReadRecord(const std::string& path,
                                   google::protobuf::Message& message,
                                   std::string& reason) {
  const absl::Status status = ReadSealed(path, message);
  if (status.ok()) return Reading::kGood;
  if (absl::IsNotFound(status)) return Reading::kGone;
  if (!absl::IsDataLoss(status)) return status;
  reason = std::string(status.message());
  return Reading::kDamaged;
}

absl::Status ReadArtifacts(const StoreFolders& folders, ArtifactIndex& index) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> ids,
                         ListDirectory(folders.artifacts));
  for (const std::string& id : ids) {
    if (IsTemporaryName(id)) continue;
    const std::string path = folders.ArtifactPath(id);
    v1::Artifact artifact;
    std::string reason;
    SINEW_ASSIGN_OR_RETURN(Reading reading, ReadRecord(path, artifact, reason));
    if (reading == Reading::kGood) {
      const absl::Status valid = ValidateArtifact(artifact);
      if (!valid.ok() || artifact.id() != id) {
        reading = Reading::kDamaged;
        reason = absl::StrCat(path, ": expected artifact ", id, ", found ",
                              valid.ok() ? artifact.id() : valid.message());
      }
    }
    if (reading == Reading::kGood) index.Insert(artifact);
    if (reading == Reading::kDamaged) index.InsertDamaged(id, reason);
  }
  return absl::OkStatus();
}

absl::Status ReadAliases(const StoreFolders& folders, ArtifactIndex& index) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                         ListDirectory(folders.aliases));
  for (const std::string& name : names) {
    if (IsTemporaryName(name)) continue;
    v1::Alias alias;
    std::string reason;
    const std::string path = folders.AliasPath(name);
    SINEW_ASSIGN_OR_RETURN(Reading reading, ReadRecord(path, alias, reason));
    if (reading == Reading::kGood && alias.name() != name) {
      reading = Reading::kDamaged;
      reason = absl::StrCat(path, ": expected alias ", name, ", found ",
                            alias.name());
    }
    if (reading == Reading::kGood) index.InsertAlias(name, alias.id());
    if (reading == Reading::kDamaged) {
      absl::StrAppend(&reason, "; to set alias ", name,
                      " anew, remove this file first");
      index.InsertDamagedAlias(name, reason);
    }
  }
  return absl::OkStatus();
}

}  // namespace

StoreFolders::StoreFolders(const std::string& folder)
    : root(folder),
      blobs(JoinPath(folder, "blobs")),
      artifacts(JoinPath(folder, "artifacts")),
      aliases(JoinPath(folder, "aliases")) {}

std::string StoreFolders::BlobPath(const std::string& sha256) const {
  return JoinPath(blobs, sha256);
}

std::string StoreFolders::ArtifactPath(const std::string& id) const {
  return JoinPath(artifacts, id);
}

std::string StoreFolders::AliasPath(const std::string& alias) const {
  return JoinPath(aliases, alias);
}

absl::Status WriteArtifactRecord(const StoreFolders& folders,
                                 const v1::Artifact& artifact) {
  const std::string path = folders.ArtifactPath(artifact.id());
  absl::Status status = WriteSealed(path, artifact);
  // The name may be there although its folder could not be forced to the disk.
  if (!status.ok()) RemoveRecursively(path).IgnoreError();
  return status;
}

absl::Status WriteAliasRecord(const StoreFolders& folders,
                              const v1::Alias& alias) {
  return WriteSealed(folders.AliasPath(alias.name()), alias);
}

absl::Status RemoveArtifactRecord(const StoreFolders& folders,
                                  const std::string& id) {
  return RemoveRecursively(folders.ArtifactPath(id));
}

absl::Status SyncArtifactRecords(const StoreFolders& folders) {
  const int fd =
      open(folders.artifacts.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = fd >= 0 && fsync(fd) == 0;
  const int error = errno;
  if (fd >= 0) close(fd);
  if (synced) return absl::OkStatus();
  return absl::ErrnoToStatus(error,
                             absl::StrCat("cannot write ", folders.artifacts));
}

absl::StatusOr<ArtifactIndex> ReadIndex(const StoreFolders& folders) {
  ArtifactIndex index;
  SINEW_RETURN_IF_ERROR(ReadArtifacts(folders, index));
  SINEW_RETURN_IF_ERROR(ReadAliases(folders, index));
  return index;
}

}  // namespace sinew::checkpoint
