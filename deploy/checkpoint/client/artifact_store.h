#ifndef SINEW_DEPLOY_CHECKPOINT_CLIENT_ARTIFACT_STORE_H_
#define SINEW_DEPLOY_CHECKPOINT_CLIENT_ARTIFACT_STORE_H_

#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/blobs/blob_source.h"
#include "proto/sinew/v1/checkpoint.pb.h"

namespace sinew::checkpoint {

// Where training states, bundles and assets are kept: content-addressed blobs,
// immutable artifacts that name them, aliases that name artifacts. In a folder
// of this machine (deploy/checkpoint/local_store.h) or behind gRPC
// (checkpoint_client.h).
//
//   PutBlob ... PutBlob  PutArtifact("state-00000120")  SetAlias("latest", ...)
//   Retain("state", 3)
//   GetArtifact("latest")  GetBlob(its files' digests) ...
//
// An artifact is either whole or not there: its record is written last.
//
// Thread-safety: any thread. Ownership: results are shared. Blocking: on the
// disk or the network, never for ever. Errors: name artifact, file or digest,
// expected and found; RESOURCE_EXHAUSTED: no room (nothing that was there is
// lost); NOT_FOUND; DATA_LOSS: bytes do not match their digest.
class ArtifactStore : public BlobSource {
 public:
  // Stores bytes under their digest and returns it; harmless if they are there
  // (damaged bytes are replaced). They stay until an artifact names them and is
  // dropped, or until DropBlobs.
  virtual absl::StatusOr<std::string> PutBlob(const Blob& blob) = 0;

  // Registers an artifact; the store sets `sequence`, and `created_unix_s` if
  // unset. FAILED_PRECONDITION: a blob of it is missing; ALREADY_EXISTS: same
  // id with other content (equal content is harmless: it changes nothing, and
  // other writers' blobs go on waiting for their artifacts); INVALID_ARGUMENT:
  // see validate_artifact.h.
  virtual absl::Status PutArtifact(const v1::Artifact& artifact) = 0;

  // By id or alias. DATA_LOSS: an alias whose record is damaged, or that names
  // an artifact that is gone.
  virtual absl::StatusOr<v1::Artifact> GetArtifact(const std::string& name) = 0;

  // Newest first; empty kind: all.
  virtual absl::StatusOr<v1::ListArtifactsResponse> ListArtifacts(
      const std::string& kind) = 0;

  // Points an alias at an artifact (NOT_FOUND). FAILED_PRECONDITION if
  // `expected_id` is not empty and the alias points elsewhere (DATA_LOSS: its
  // record is damaged); harmless if it points at `id` already.
  virtual absl::Status SetAlias(const std::string& alias, const std::string& id,
                                const std::string& expected_id = "") = 0;

  // Removes the artifacts of a kind beyond the newest `keep` (>= 1) whole
  // ones, but none that an alias names (none at all while an alias is damaged),
  // then the blobs that nothing refers to.
  virtual absl::Status Retain(const std::string& kind, int keep) = 0;

  // Gives up blobs that were put for an artifact that will not come: they go
  // unless something else needs them.
  virtual absl::Status DropBlobs(absl::Span<const std::string> sha256s) = 0;
};

// Aliases of a run's store: its newest training state and its best evaluated
// policy.
inline constexpr char kLatest[] = "latest";
inline constexpr char kBest[] = "best";

// Files of an artifact by relative path.
using ArtifactFiles = std::map<std::string, Blob>;

// Stores the files, then the artifact `record` with `files` filled in. On an
// error nothing of it stays.
absl::Status PutFiles(ArtifactStore& store, v1::Artifact record,
                      const ArtifactFiles& files);

// All files of an artifact, by id or alias, verified. Errors name artifact and
// file; DATA_LOSS also for a record that ValidateArtifact refuses, so that no
// path leaves the folder that it is written to.
absl::StatusOr<ArtifactFiles> GetFiles(ArtifactStore& store,
                                       const std::string& name);

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_CLIENT_ARTIFACT_STORE_H_
