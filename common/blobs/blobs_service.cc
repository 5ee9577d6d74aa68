#include "common/blobs/blobs_service.h"

#include <cstdint>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/blobs/blob_reader.h"
#include "common/rpc/chunks.h"
#include "common/rpc/status.h"
#include "common/rpc/watchdog.h"

namespace sinew {

grpc::Status BlobsService::GetBlob(grpc::ServerContext* context,
                                   const v1::GetBlobRequest* request,
                                   grpc::ServerWriter<v1::BlobChunk>* writer) {
  const auto blob = source_.OpenBlob(request->sha256());
  if (!blob.ok()) return rpc::ToGrpc(blob.status());
  const int64_t size = (*blob)->size();
  const int64_t begin = request->offset();
  if (begin < 0 || begin > size) {
    return rpc::ToGrpc(absl::InvalidArgumentError(
        absl::StrCat("blob ", request->sha256(), ": expected an offset in [0, ",
                     size, "], found ", begin)));
  }
  rpc::Watchdog watchdog(idle_timeout_, [context] { context->TryCancel(); });
  v1::BlobChunk chunk;
  int64_t offset = begin;
  do {  // Once at least, for the total size.
    const absl::StatusOr<absl::string_view> piece =
        (*blob)->Read(offset, rpc::kChunkBytes);
    if (!piece.ok()) return rpc::ToGrpc(piece.status());
    chunk.set_total_size(offset == begin ? size : 0);
    chunk.set_data(piece->data(), piece->size());
    if (!writer->Write(chunk)) return grpc::Status::CANCELLED;
    watchdog.Feed();
    offset += static_cast<int64_t>(piece->size());
  } while (offset < size);
  return grpc::Status::OK;
}

}  // namespace sinew
