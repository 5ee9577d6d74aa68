#ifndef SINEW_DEPLOY_CHECKPOINT_CLIENT_ARTIFACT_INDEX_H_
#define SINEW_DEPLOY_CHECKPOINT_CLIENT_ARTIFACT_INDEX_H_

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/sinew/v1/checkpoint.pb.h"

namespace sinew::checkpoint {

// What a store knows beside its bytes: artifacts, aliases, and which blobs are
// needed. The rules of ArtifactStore as plain data, so that stores differ only
// in where they keep them.
//
// A blob is needed while an artifact names it, or while it is held: from its
// PutBlob until the PutArtifact that names it and adds a record (or DropBlobs).
// A hold whose writer never came back, put the bytes twice, or found its
// artifact there already ends after kMaxAge calls of Age, so garbage is bounded
// without asking a clock.
//
// Thread-safety: one thread at a time. Ownership: owns its data. Blocking:
// never. Errors: name artifact or alias, expected and found.
class ArtifactIndex {
 public:
  static constexpr int64_t kMaxAge = 64;

  // --- Records ---------------------------------------------------------------
  // By id or alias. NOT_FOUND: there is neither; DATA_LOSS: its record is
  // damaged, or the artifact that the alias names is gone.
  absl::StatusOr<v1::Artifact> Get(const std::string& name) const;
  // Newest first; empty kind: all.
  v1::ListArtifactsResponse List(const std::string& kind) const;
  bool Contains(const std::string& id) const { return artifacts_.contains(id); }

  // What to keep for a valid `artifact`: numbered, dated if it is not. The
  // record that is there if it is equal. ALREADY_EXISTS: another content, or an
  // alias of that name.
  absl::StatusOr<v1::Artifact> Admit(const v1::Artifact& artifact,
                                     int64_t now_unix_s) const;
  // Adds what Admit returned, or a record that was read back.
  void Insert(const v1::Artifact& artifact);
  void Erase(const std::string& id);
  // A record that cannot be read; `reason` names it.
  void InsertDamaged(const std::string& id, const std::string& reason);

  // NOT_FOUND: no such artifact. ALREADY_EXISTS: an artifact has the alias'
  // name. FAILED_PRECONDITION: points neither at `expected_id` nor at `id`.
  // DATA_LOSS: its record is damaged, so nobody knows where it points; without
  // an `expected_id` it may be set anew.
  absl::Status CheckAlias(const std::string& alias, const std::string& id,
                          const std::string& expected_id) const;
  void InsertAlias(const std::string& alias, const std::string& id);
  // A record that cannot be read; `reason` names it.
  void InsertDamagedAlias(const std::string& alias, const std::string& reason);
  // By alias, with its reason.
  const std::map<std::string, std::string>& damaged_aliases() const {
    return damaged_aliases_;
  }

  // Ids of a kind, without aliases, older than the newest `keep` that are
  // whole; none while an alias is damaged, which may be one of theirs.
  std::vector<std::string> Surplus(
      const std::string& kind, int keep,
      const std::function<bool(const v1::Artifact&)>& is_whole) const;

  // --- Blobs -----------------------------------------------------------------
  void Hold(const std::string& sha256);
  // Ends one hold, if there is one.
  void Release(const std::string& sha256);
  bool IsNeeded(const std::string& sha256) const;
  // Ends the holds that have become too old.
  void Age();

 private:
  struct Held {
    int count = 0;
    // age_ at the latest Hold.
    int64_t since = 0;
  };

  bool HasAlias(const std::string& id) const;

  std::map<std::string, v1::Artifact> artifacts_;
  std::map<std::string, std::string> aliases_;
  // To the reason, by id and by alias.
  std::map<std::string, std::string> damaged_;
  std::map<std::string, std::string> damaged_aliases_;
  int64_t last_sequence_ = 0;
  // Digest to the number of files that have it.
  std::map<std::string, int> references_;
  std::map<std::string, Held> held_;
  int64_t age_ = 0;
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_CLIENT_ARTIFACT_INDEX_H_
