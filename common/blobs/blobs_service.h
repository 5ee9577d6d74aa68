#ifndef SINEW_COMMON_BLOBS_BLOBS_SERVICE_H_
#define SINEW_COMMON_BLOBS_BLOBS_SERVICE_H_

#include "absl/time/time.h"
#include "common/blobs/blob_source.h"
#include "proto/sinew/v1/blob.grpc.pb.h"

namespace sinew {

// Serves any source's blobs over gRPC (blob.proto).
//
// Thread-safety: gRPC calls it from many threads. Ownership: borrows the
// source. Blocking: a call lasts as long as its client reads, but one whose
// client takes nothing for `idle_timeout` is cut (CANCELLED; it may go on where
// it stopped). In memory are one chunk of each call and what flow control lets
// through, and the blob itself only if the source holds it in memory
// (BlobSource::OpenBlob). Errors: the source's, as gRPC statuses.
class BlobsService final : public v1::Blobs::Service {
 public:
  explicit BlobsService(BlobSource& source,
                        absl::Duration idle_timeout = absl::Seconds(60))
      : source_(source), idle_timeout_(idle_timeout) {}

  grpc::Status GetBlob(grpc::ServerContext* context,
                       const v1::GetBlobRequest* request,
                       grpc::ServerWriter<v1::BlobChunk>* writer) override;

 private:
  BlobSource& source_;
  const absl::Duration idle_timeout_;
};

}  // namespace sinew

#endif  // SINEW_COMMON_BLOBS_BLOBS_SERVICE_H_
