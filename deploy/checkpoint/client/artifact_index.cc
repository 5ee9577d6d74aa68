#include "deploy/checkpoint/client/artifact_index.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/status_macros.h"

namespace sinew::checkpoint {
namespace {

// Equal in all that the writer decides.
bool SameContent(v1::Artifact a, v1::Artifact b) {
  for (v1::Artifact* artifact : {&a, &b}) {
    artifact->clear_created_unix_s();
    artifact->clear_sequence();
  }
  return SerializeDeterministically(a) == SerializeDeterministically(b);
}

}  // namespace

absl::StatusOr<v1::Artifact> ArtifactIndex::Get(const std::string& name) const {
  if (const auto damaged = damaged_aliases_.find(name);
      damaged != damaged_aliases_.end()) {
    return absl::DataLossError(damaged->second);
  }
  const auto alias = aliases_.find(name);
  const std::string& id = alias == aliases_.end() ? name : alias->second;
  if (const auto damaged = damaged_.find(id); damaged != damaged_.end()) {
    return absl::DataLossError(damaged->second);
  }
  const auto found = artifacts_.find(id);
  if (found != artifacts_.end()) return found->second;
  if (alias != aliases_.end()) {
    return absl::DataLossError(absl::StrCat("alias ", name,
                                            ": expected an artifact, found "
                                            "none of the id that it names, ",
                                            id));
  }
  return absl::NotFoundError(
      absl::StrCat("no artifact ", id, " and no such alias"));
}

v1::ListArtifactsResponse ArtifactIndex::List(const std::string& kind) const {
  std::vector<const v1::Artifact*> newest_first;
  for (const auto& [id, artifact] : artifacts_) {
    if (kind.empty() || artifact.kind() == kind) {
      newest_first.push_back(&artifact);
    }
  }
  std::sort(newest_first.begin(), newest_first.end(),
            [](const v1::Artifact* a, const v1::Artifact* b) {
              return a->sequence() > b->sequence();
            });
  v1::ListArtifactsResponse list;
  for (const v1::Artifact* artifact : newest_first) {
    *list.add_artifacts() = *artifact;
  }
  for (const auto& [name, id] : aliases_) {
    v1::Alias& alias = *list.add_aliases();
    alias.set_name(name);
    alias.set_id(id);
  }
  for (const auto& [id, reason] : damaged_) list.add_damaged(reason);
  for (const auto& [name, reason] : damaged_aliases_) list.add_damaged(reason);
  return list;
}

absl::StatusOr<v1::Artifact> ArtifactIndex::Admit(const v1::Artifact& artifact,
                                                  int64_t now_unix_s) const {
  if (const auto alias = aliases_.find(artifact.id());
      alias != aliases_.end()) {
    return absl::AlreadyExistsError(
        absl::StrCat("artifact ", artifact.id(),
                     ": an alias has this name, it points at ", alias->second));
  }
  if (const auto damaged = damaged_aliases_.find(artifact.id());
      damaged != damaged_aliases_.end()) {
    return absl::AlreadyExistsError(
        absl::StrCat("artifact ", artifact.id(),
                     ": an alias has this name: ", damaged->second));
  }
  if (const auto found = artifacts_.find(artifact.id());
      found != artifacts_.end()) {
    if (SameContent(found->second, artifact)) return found->second;
    return absl::AlreadyExistsError(absl::StrCat(
        "artifact ", artifact.id(), ": expected the content that it has (",
        found->second.files_size(), " files, iteration ",
        found->second.iteration(), "), found another (", artifact.files_size(),
        " files, iteration ", artifact.iteration(), ")"));
  }
  v1::Artifact record = artifact;
  record.set_sequence(last_sequence_ + 1);
  if (record.created_unix_s() == 0) record.set_created_unix_s(now_unix_s);
  return record;
}

void ArtifactIndex::Insert(const v1::Artifact& artifact) {
  if (!artifacts_.emplace(artifact.id(), artifact).second) return;
  damaged_.erase(artifact.id());
  last_sequence_ = std::max(last_sequence_, artifact.sequence());
  for (const v1::Artifact::File& file : artifact.files()) {
    ++references_[file.sha256()];
  }
}

void ArtifactIndex::Erase(const std::string& id) {
  const auto found = artifacts_.find(id);
  if (found == artifacts_.end()) return;
  for (const v1::Artifact::File& file : found->second.files()) {
    const auto reference = references_.find(file.sha256());
    if (--reference->second == 0) references_.erase(reference);
  }
  artifacts_.erase(found);
}

void ArtifactIndex::InsertDamaged(const std::string& id,
                                  const std::string& reason) {
  damaged_[id] = reason;
}

absl::Status ArtifactIndex::CheckAlias(const std::string& alias,
                                       const std::string& id,
                                       const std::string& expected_id) const {
  if (!artifacts_.contains(id)) {
    return absl::NotFoundError(
        absl::StrCat("alias ", alias, ": no artifact ", id));
  }
  if (artifacts_.contains(alias)) {
    return absl::AlreadyExistsError(
        absl::StrCat("alias ", alias, ": an artifact has this name"));
  }
  if (expected_id.empty()) return absl::OkStatus();
  if (const auto damaged = damaged_aliases_.find(alias);
      damaged != damaged_aliases_.end()) {
    return absl::DataLossError(damaged->second);
  }
  const auto found = aliases_.find(alias);
  const std::string now = found == aliases_.end() ? "" : found->second;
  if (now == expected_id || now == id) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("alias ", alias, ": expected it to point at ", expected_id,
                   ", found ", now.empty() ? "nothing" : now));
}

void ArtifactIndex::InsertAlias(const std::string& alias,
                                const std::string& id) {
  aliases_[alias] = id;
  damaged_aliases_.erase(alias);
}

void ArtifactIndex::InsertDamagedAlias(const std::string& alias,
                                       const std::string& reason) {
  damaged_aliases_[alias] = reason;
}

std::vector<std::string> ArtifactIndex::Surplus(
    const std::string& kind, int keep,
    const std::function<bool(const v1::Artifact&)>& is_whole) const {
  std::vector<std::string> surplus;
  if (!damaged_aliases_.empty()) return surplus;
  int whole = 0;
  const v1::ListArtifactsResponse list = List(kind);
  for (const v1::Artifact& artifact : list.artifacts()) {
    if (whole >= keep && !HasAlias(artifact.id())) {
      surplus.push_back(artifact.id());
    }
    if (whole < keep && is_whole(artifact)) ++whole;
  }
  return surplus;
}

void ArtifactIndex::Hold(const std::string& sha256) {
  Held& held = held_[sha256];
  ++held.count;
  held.since = age_;
}

void ArtifactIndex::Release(const std::string& sha256) {
  const auto found = held_.find(sha256);
  if (found != held_.end() && --found->second.count == 0) held_.erase(found);
}

bool ArtifactIndex::IsNeeded(const std::string& sha256) const {
  return references_.contains(sha256) || held_.contains(sha256);
}

void ArtifactIndex::Age() {
  ++age_;
  std::erase_if(held_, [this](const auto& item) {
    return age_ - item.second.since > kMaxAge;
  });
}

bool ArtifactIndex::HasAlias(const std::string& id) const {
  return std::any_of(aliases_.begin(), aliases_.end(),
                     [&](const auto& alias) { return alias.second == id; });
}

}  // namespace sinew::checkpoint
