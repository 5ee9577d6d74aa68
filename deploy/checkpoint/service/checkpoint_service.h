#ifndef SINEW_DEPLOY_CHECKPOINT_SERVICE_CHECKPOINT_SERVICE_H_
#define SINEW_DEPLOY_CHECKPOINT_SERVICE_CHECKPOINT_SERVICE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/blobs/blob_reader.h"
#include "common/blobs/blob_source.h"
#include "common/clock.h"
#include "common/mutex.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/service/service_metrics.h"
#include "proto/sinew/v1/checkpoint.grpc.pb.h"

namespace sinew::checkpoint {

// Serves a store over gRPC (checkpoint.proto); BlobsService over
// counted_blobs() serves its bytes.
//
// Thread-safety: gRPC calls it from many threads. Ownership: borrows store,
// clock and metrics. Blocking: on the store; an upload lasts as long as its
// client sends, but one that stands still for `idle_timeout` is cut. Errors:
// the store's, as gRPC statuses; malformed requests are INVALID_ARGUMENT and
// change nothing; RESOURCE_EXHAUSTED: a blob over the limit; UNAVAILABLE: too
// many bytes of uploads in flight, try again.
class CheckpointService final : public v1::Checkpoints::Service {
 public:
  struct Options {
    int64_t max_blob_bytes = int64_t{1} << 30;
    // Of all uploads in flight, which are held in memory; >= max_blob_bytes.
    int64_t max_upload_bytes = int64_t{2} << 30;
    absl::Duration idle_timeout = absl::Seconds(60);
  };

  CheckpointService(ArtifactStore& store, const Options& options,
                    const Clock& clock, ServiceMetrics& metrics);

  grpc::Status PutBlob(grpc::ServerContext* context,
                       grpc::ServerReader<v1::PutBlobRequest>* reader,
                       v1::PutBlobResponse* response) override;
  grpc::Status PutArtifact(grpc::ServerContext* context,
                           const v1::PutArtifactRequest* request,
                           v1::PutArtifactResponse* response) override;
  grpc::Status ListArtifacts(grpc::ServerContext* context,
                             const v1::ListArtifactsRequest* request,
                             v1::ListArtifactsResponse* response) override;
  grpc::Status GetArtifact(grpc::ServerContext* context,
                           const v1::GetArtifactRequest* request,
                           v1::GetArtifactResponse* response) override;
  grpc::Status SetAlias(grpc::ServerContext* context,
                        const v1::SetAliasRequest* request,
                        v1::SetAliasResponse* response) override;
  grpc::Status Retain(grpc::ServerContext* context,
                      const v1::RetainRequest* request,
                      v1::RetainResponse* response) override;
  grpc::Status DropBlobs(grpc::ServerContext* context,
                         const v1::DropBlobsRequest* request,
                         v1::DropBlobsResponse* response) override;

  // The store's blobs, counted.
  BlobSource& counted_blobs() { return counted_blobs_; }

 private:
  class CountedBlobs : public BlobSource {
   public:
    CountedBlobs(ArtifactStore& store, ServiceMetrics& metrics)
        : store_(store), metrics_(metrics) {}
    absl::StatusOr<Blob> GetBlob(const std::string& sha256) override;
    absl::StatusOr<std::unique_ptr<BlobReader>> OpenBlob(
        const std::string& sha256) override;

   private:
    ArtifactStore& store_;
    ServiceMetrics& metrics_;
  };

  grpc::Status Finish(const std::string& rpc, const absl::Status& status);
  absl::Status Receive(grpc::ServerContext& context,
                       grpc::ServerReader<v1::PutBlobRequest>& reader);
  // True, and held for the client, if the store has the bytes already.
  bool AlreadyThere(const std::string& sha256, int64_t size);
  absl::Status ReserveUpload(int64_t bytes) SINEW_EXCLUDES(mu_);
  void ReleaseUpload(int64_t bytes) SINEW_EXCLUDES(mu_);

  ArtifactStore& store_;
  const Options options_;
  const Clock& clock_;
  ServiceMetrics& metrics_;
  CountedBlobs counted_blobs_;

  Mutex mu_;
  int64_t upload_bytes_ SINEW_GUARDED_BY(mu_) = 0;
};

}  // namespace sinew::checkpoint

#endif  // SINEW_DEPLOY_CHECKPOINT_SERVICE_CHECKPOINT_SERVICE_H_
