#include "actor/service/peer_blobs.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/rpc/channel.h"
#include "common/status_macros.h"

namespace sinew::actor {
namespace {

// A cache together with the client that it borrows.
class CachedPeer : public BlobSource {
 public:
  CachedPeer(std::shared_ptr<BlobSource> peer, std::unique_ptr<BlobCache> cache)
      : peer_(std::move(peer)), cache_(std::move(cache)) {}

  absl::StatusOr<Blob> GetBlob(const std::string& sha256) override {
    return cache_->GetBlob(sha256);
  }
  absl::StatusOr<SharedBytes> MapBlob(const std::string& sha256) override {
    return cache_->MapBlob(sha256);
  }

 private:
  const std::shared_ptr<BlobSource> peer_;
  const std::unique_ptr<BlobCache> cache_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<BlobSource>> PeerBlobs::Direct(
    const std::string& address, const Options& options) {
  SINEW_ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel,
                         rpc::MakeChannel(address, options.security));
  return std::make_shared<BlobClient>(
      std::move(channel),
      BlobClient::Options{
          .peer = address, .backoff = options.backoff, .stop = options.stop});
}

absl::StatusOr<std::shared_ptr<BlobSource>> PeerBlobs::Cached(
    const std::string& address, const Options& options,
    const std::string& cache_folder, int64_t cache_bytes) {
  SINEW_ASSIGN_OR_RETURN(std::shared_ptr<BlobSource> peer,
                         Direct(address, options));
  SINEW_ASSIGN_OR_RETURN(std::unique_ptr<BlobCache> cache,
                         BlobCache::Create(cache_folder, cache_bytes, *peer));
  return std::make_shared<CachedPeer>(std::move(peer), std::move(cache));
}

}  // namespace sinew::actor
