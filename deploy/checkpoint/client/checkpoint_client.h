#ifndef SINEW_DEPLOY_CHECKPOINT_CLIENT_CHECKPOINT_CLIENT_H_
#define SINEW_DEPLOY_CHECKPOINT_CLIENT_CHECKPOINT_CLIENT_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/blobs/blob_client.h"
#include "common/rpc/peer_calls.h"
#include "common/rpc/retry.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "grpcpp/channel.h"
#include "proto/sinew/v1/checkpoint.grpc.pb.h"

namespace sinew::checkpoint {

// A checkpoint service as an ArtifactStore.
//
// Thread-safety: any thread. Ownership: shares the channel. Blocking: on the
// network; each attempt has a deadline, transient failures are tried again
// with back-off, `attempts` at most; all but DropBlobs, which twice would give
// up another writer's bytes. A PutBlob whose answer was lost and that was
// repeated may keep bytes longer than they are needed (artifact_index.h).
// A service that is not there has `connect_timeout` to come up, also between
// attempts (rpc::PeerCalls); so roles may be started in any order, and one that
// is simply absent is reported after that time. One that hangs is reported
// after at most attempts * (call_timeout, or of a blob idle_timeout, + the
// back-off); a blob that moves has `transfer_timeout` for each attempt.
// Errors: as ArtifactStore, after the peer's name; UNAVAILABLE,
// DEADLINE_EXCEEDED, CANCELLED after `stop`, RESOURCE_EXHAUSTED for a blob over
// `max_blob_bytes`, in either direction.
class CheckpointClient : public ArtifactStore {
 public:
  struct Options {
    // Says who the peer is in errors, e.g. "checkpoint host:7002".
    std::string peer = {};
    int64_t max_blob_bytes = int64_t{1} << 30;
    absl::Duration connect_timeout = absl::Seconds(15);
    absl::Duration call_timeout = absl::Seconds(30);
    // Of one blob, one attempt.
    absl::Duration transfer_timeout = absl::Minutes(10);
    // Of a blob that stands still; longer than the service takes to verify or
    // to store a large one.
    absl::Duration idle_timeout = absl::Seconds(60);
    int attempts = 8;
    rpc::BackoffOptions backoff = {};
    std::stop_token stop = {};
  };

  CheckpointClient(std::shared_ptr<grpc::Channel> channel, Options options);

  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override;
  absl::StatusOr<std::string> PutBlob(const Blob& blob) override;
  absl::Status PutArtifact(const v1::Artifact& artifact) override;
  absl::StatusOr<v1::Artifact> GetArtifact(const std::string& name) override;
  absl::StatusOr<v1::ListArtifactsResponse> ListArtifacts(
      const std::string& kind) override;
  absl::Status SetAlias(const std::string& alias, const std::string& id,
                        const std::string& expected_id = "") override;
  absl::Status Retain(const std::string& kind, int keep) override;
  absl::Status DropBlobs(absl::Span<const std::string> sha256s) override;

 private:
  template <typename Request, typename Response>
  using Method = grpc::Status (v1::Checkpoints::Stub::*)(grpc::ClientContext*,
                                                         const Request&,
                                                         Response*);
  template <typename Request, typename Response>
  absl::StatusOr<Response> Call(Method<Request, Response> method,
                                const Request& request, int attempts);

  // One attempt to send a blob.
  absl::Status Send(const std::string& sha256, const std::string& bytes);

  const Options options_;
  const std::unique_ptr<v1::Checkpoints::Stub> stub_;
  const rpc::PeerCalls calls_;
  BlobClient blobs_;
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_CLIENT_CHECKPOINT_CLIENT_H_
