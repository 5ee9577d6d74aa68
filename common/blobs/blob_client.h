#ifndef SINEW_COMMON_BLOBS_BLOB_CLIENT_H_
#define SINEW_COMMON_BLOBS_BLOB_CLIENT_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "common/blobs/blob_source.h"
#include "common/rpc/chunks.h"
#include "common/rpc/peer_calls.h"
#include "common/rpc/retry.h"
#include "grpcpp/channel.h"
#include "proto/sinew/v1/blob.grpc.pb.h"

namespace sinew {

// A peer's blobs, fetched in chunks and verified by their digest. A broken
// transfer goes on where it stopped.
//
// Thread-safety: any thread. Ownership: shares the channel. Blocking: until
// the bytes are here; each attempt at most `attempt_timeout`, or `idle_timeout`
// without a chunk, with back-off in between, at most `attempts` in all: of a
// peer that hangs, at most attempts * (idle_timeout + the back-off). A peer
// that is not there has `connect_timeout` to come up, also in the middle
// (rpc::PeerCalls). Errors: name peer and digest; as BlobSource, and
// RESOURCE_EXHAUSTED for a blob over `max_bytes` (nothing is allocated),
// CANCELLED after `stop`, UNAVAILABLE or DEADLINE_EXCEEDED.
class BlobClient : public BlobSource {
 public:
  struct Options {
    // Says who the peer is in errors, e.g. "checkpoint host:7002".
    std::string peer = {};
    int64_t max_bytes = int64_t{4} << 30;
    absl::Duration connect_timeout = absl::Seconds(15);
    absl::Duration attempt_timeout = absl::Seconds(60);
    // Longer than a peer takes to verify a large blob before it is sent.
    absl::Duration idle_timeout = absl::Seconds(60);
    int attempts = 8;
    rpc::BackoffOptions backoff = {};
    std::stop_token stop = {};
  };

  BlobClient(std::shared_ptr<grpc::Channel> channel, Options options);

  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override;

 private:
  // One transfer, from where `payload` stands.
  absl::Status Receive(const std::string& sha256, rpc::ChunkAssembler& payload);

  const Options options_;
  const std::unique_ptr<v1::Blobs::Stub> stub_;
  const rpc::PeerCalls calls_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOB_CLIENT_H_
