#include "common/blobs/blobs_service.h"

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/rpc/chunks.h"
#include "common/rpc/status.h"

namespace sinew {

grpc::Status BlobsService::GetBlob(grpc::ServerContext* /*context*/,
                                   const v1::GetBlobRequest* request,
                                   grpc::ServerWriter<v1::BlobChunk>* writer) {
  const absl::StatusOr<Blob> blob = source_.GetBlob(request->sha256());
  if (!blob.ok()) return rpc::ToGrpc(blob.status());
  const std::string& bytes = **blob;
  const int64_t size = static_cast<int64_t>(bytes.size());
  if (request->offset() < 0 || request->offset() > size) {
    return rpc::ToGrpc(absl::InvalidArgumentError(
        absl::StrCat("blob ", request->sha256(), ": expected an offset in [0, ",
                     size, "], found ", request->offset())));
  }
  v1::BlobChunk chunk;
  const bool sent = rpc::ForEachChunk(
      bytes, request->offset(), [&](absl::string_view data, bool first) {
        chunk.set_total_size(first ? size : 0);
        chunk.set_data(data.data(), data.size());
        return writer->Write(chunk);
      });
  return sent ? grpc::Status::OK : grpc::Status::CANCELLED;
}

}  // namespace sinew
