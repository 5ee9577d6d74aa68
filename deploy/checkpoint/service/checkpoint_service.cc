#include "deploy/checkpoint/service/checkpoint_service.h"

#include <memory>
#include <utility>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/rpc/chunks.h"
#include "common/rpc/status.h"
#include "common/rpc/watchdog.h"
#include "common/status_macros.h"

namespace sinew::checkpoint {
namespace {

using Reader = grpc::ServerReader<v1::PutBlobRequest>;

// Reads chunks until the client has sent all; `message` is the first one.
absl::Status ReadChunks(Reader& reader, v1::PutBlobRequest& message,
                        rpc::ChunkAssembler& payload, rpc::Watchdog& watchdog) {
  do {
    watchdog.Feed();
    if (static_cast<int64_t>(message.data().size()) > rpc::kChunkBytes) {
      return absl::InvalidArgumentError(
          absl::StrCat("chunk: expected at most ", rpc::kChunkBytes,
                       " bytes, found ", message.data().size()));
    }
    SINEW_RETURN_IF_ERROR(payload.Append(message.data()));
    message.Clear();
  } while (reader.Read(&message));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Blob> CheckpointService::CountedBlobs::GetBlob(
    const std::string& sha256) {
  absl::StatusOr<Blob> blob = store_.GetBlob(sha256);
  metrics_.Count("GetBlob", blob.status());
  if (blob.ok()) {
    metrics_.sent_bytes.Increment(static_cast<double>((*blob)->size()));
  }
  return blob;
}

absl::StatusOr<std::unique_ptr<BlobReader>>
CheckpointService::CountedBlobs::OpenBlob(const std::string& sha256) {
  auto blob = store_.OpenBlob(sha256);
  metrics_.Count("GetBlob", blob.status());
  if (blob.ok()) {
    metrics_.sent_bytes.Increment(static_cast<double>((*blob)->size()));
  }
  return blob;
}

CheckpointService::CheckpointService(ArtifactStore& store,
                                     const Options& options, const Clock& clock,
                                     ServiceMetrics& metrics)
    : store_(store),
      options_(options),
      clock_(clock),
      metrics_(metrics),
      counted_blobs_(store, metrics) {
  metrics_.upload_limit_bytes.Set(
      static_cast<double>(options_.max_upload_bytes));
}

grpc::Status CheckpointService::Finish(const std::string& rpc,
                                       const absl::Status& status) {
  metrics_.Count(rpc, status);
  return rpc::ToGrpc(status);
}

absl::Status CheckpointService::ReserveUpload(int64_t bytes) {
  MutexLock lock(mu_);
  if (upload_bytes_ + bytes > options_.max_upload_bytes) {
    return absl::UnavailableError(absl::StrCat(
        "uploads in flight: expected at most ", options_.max_upload_bytes,
        " bytes, found ", upload_bytes_, " and ", bytes, " more"));
  }
  upload_bytes_ += bytes;
  metrics_.upload_bytes.Set(static_cast<double>(upload_bytes_));
  return absl::OkStatus();
}

void CheckpointService::ReleaseUpload(int64_t bytes) {
  MutexLock lock(mu_);
  upload_bytes_ -= bytes;
  metrics_.upload_bytes.Set(static_cast<double>(upload_bytes_));
}

bool CheckpointService::AlreadyThere(const std::string& sha256, int64_t size) {
  const absl::StatusOr<Blob> blob = store_.GetBlob(sha256);
  return blob.ok() && static_cast<int64_t>((*blob)->size()) == size &&
         store_.PutBlob(*blob).ok();
}

absl::Status CheckpointService::Receive(grpc::ServerContext& context,
                                        Reader& reader) {
  rpc::Watchdog watchdog(options_.idle_timeout,
                         [&context] { context.TryCancel(); });
  v1::PutBlobRequest message;
  if (!reader.Read(&message)) {
    return absl::InvalidArgumentError("expected a header, found no message");
  }
  const std::string sha256 = message.sha256();
  const int64_t size = message.size();
  if (!IsSha256Hex(sha256)) {
    return absl::InvalidArgumentError(
        absl::StrCat("header: expected a SHA-256, found ", sha256.size(),
                     " other characters"));
  }
  if (size < 0 || size > options_.max_blob_bytes) {
    return absl::Status(
        size < 0 ? absl::StatusCode::kInvalidArgument
                 : absl::StatusCode::kResourceExhausted,
        absl::StrCat("blob ", sha256, ": expected 0 to ",
                     options_.max_blob_bytes, " bytes, found ", size));
  }
  // What is there already is read to be compared.
  SINEW_RETURN_IF_ERROR(ReserveUpload(size));
  const absl::Cleanup release = [this, size] { ReleaseUpload(size); };
  if (AlreadyThere(sha256, size)) return absl::OkStatus();
  rpc::ChunkAssembler payload(options_.max_blob_bytes);
  SINEW_RETURN_IF_ERROR(payload.Begin(size));
  SINEW_RETURN_IF_ERROR(ReadChunks(reader, message, payload, watchdog));
  if (!payload.complete()) {
    return absl::InvalidArgumentError(
        absl::StrCat("blob ", sha256, ": expected ", size, " bytes, found ",
                     payload.received_bytes()));
  }
  const Blob blob = std::make_shared<const std::string>(payload.Release());
  const std::string found = Sha256Hex(*blob);
  if (found != sha256) {
    return absl::InvalidArgumentError(
        absl::StrCat("blob: expected SHA-256 ", sha256, ", found ", found));
  }
  metrics_.received_bytes.Increment(static_cast<double>(size));
  return store_.PutBlob(blob).status();
}

grpc::Status CheckpointService::PutBlob(grpc::ServerContext* context,
                                        Reader* reader,
                                        v1::PutBlobResponse* /*response*/) {
  return Finish("PutBlob", Receive(*context, *reader));
}

grpc::Status CheckpointService::PutArtifact(
    grpc::ServerContext* /*context*/, const v1::PutArtifactRequest* request,
    v1::PutArtifactResponse* /*response*/) {
  const absl::Status status = store_.PutArtifact(request->artifact());
  if (status.ok()) {
    metrics_.last_artifact_timestamp_seconds.Set(clock_.WallSeconds());
  }
  return Finish("PutArtifact", status);
}

grpc::Status CheckpointService::ListArtifacts(
    grpc::ServerContext* /*context*/, const v1::ListArtifactsRequest* request,
    v1::ListArtifactsResponse* response) {
  absl::StatusOr<v1::ListArtifactsResponse> list =
      store_.ListArtifacts(request->kind());
  if (list.ok()) *response = *std::move(list);
  return Finish("ListArtifacts", list.status());
}

grpc::Status CheckpointService::GetArtifact(
    grpc::ServerContext* /*context*/, const v1::GetArtifactRequest* request,
    v1::GetArtifactResponse* response) {
  absl::StatusOr<v1::Artifact> artifact = store_.GetArtifact(request->name());
  if (artifact.ok()) *response->mutable_artifact() = *std::move(artifact);
  return Finish("GetArtifact", artifact.status());
}

grpc::Status CheckpointService::SetAlias(grpc::ServerContext* /*context*/,
                                         const v1::SetAliasRequest* request,
                                         v1::SetAliasResponse* /*response*/) {
  return Finish("SetAlias",
                store_.SetAlias(request->alias().name(), request->alias().id(),
                                request->expected_id()));
}

grpc::Status CheckpointService::Retain(grpc::ServerContext* /*context*/,
                                       const v1::RetainRequest* request,
                                       v1::RetainResponse* /*response*/) {
  return Finish("Retain", store_.Retain(request->kind(), request->keep()));
}

grpc::Status CheckpointService::DropBlobs(grpc::ServerContext* /*context*/,
                                          const v1::DropBlobsRequest* request,
                                          v1::DropBlobsResponse* /*response*/) {
  const std::vector<std::string> sha256s(request->sha256().begin(),
                                         request->sha256().end());
  return Finish("DropBlobs", store_.DropBlobs(sha256s));
}

}  // namespace sinew::checkpoint
