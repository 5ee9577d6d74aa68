#ifndef SINEW_ACTOR_SERVICE_PEER_BLOBS_H_
#define SINEW_ACTOR_SERVICE_PEER_BLOBS_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "common/blobs/blob_cache.h"
#include "common/blobs/blob_client.h"
#include "common/blobs/blob_source.h"
#include "common/rpc/credentials.h"
#include "common/rpc/retry.h"

namespace sinew::actor {

// A peer's blobs by address, with or without a cache on disk. Thread-safety,
// blocking and errors: BlobClient's and BlobCache's.
class PeerBlobs {
 public:
  struct Options {
    rpc::Security security;
    rpc::BackoffOptions backoff;
    std::stop_token stop;
  };

  static absl::StatusOr<std::shared_ptr<BlobSource>> Direct(
      const std::string& address, const Options& options);
  static absl::StatusOr<std::shared_ptr<BlobSource>> Cached(
      const std::string& address, const Options& options,
      const std::string& cache_folder, int64_t cache_bytes);
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_PEER_BLOBS_H_
