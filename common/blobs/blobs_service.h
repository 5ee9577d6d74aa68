#ifndef SINEW_COMMON_BLOBS_BLOBS_SERVICE_H_
#define SINEW_COMMON_BLOBS_BLOBS_SERVICE_H_

#include "common/blobs/blob_source.h"
#include "proto/sinew/v1/blob.grpc.pb.h"

namespace sinew {

// Serves any source's blobs over gRPC (blob.proto).
//
// Thread-safety: gRPC calls it from many threads. Ownership: borrows the
// source. Blocking: a call lasts as long as its client reads; gRPC's flow
// control bounds what is in memory. Errors: the source's, as gRPC statuses.
class BlobsService final : public v1::Blobs::Service {
 public:
  explicit BlobsService(BlobSource& source) : source_(source) {}

  grpc::Status GetBlob(grpc::ServerContext* context,
                       const v1::GetBlobRequest* request,
                       grpc::ServerWriter<v1::BlobChunk>* writer) override;

 private:
  BlobSource& source_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOBS_SERVICE_H_
