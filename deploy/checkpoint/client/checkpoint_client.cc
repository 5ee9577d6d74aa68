#include "deploy/checkpoint/client/checkpoint_client.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/rpc/channel.h"
#include "common/rpc/chunks.h"
#include "common/rpc/status.h"
#include "common/rpc/watchdog.h"
#include "common/status_macros.h"

namespace sinew::checkpoint {
namespace {

BlobClient::Options BlobOptions(const CheckpointClient::Options& options) {
  BlobClient::Options blobs;
  blobs.peer = options.peer;
  blobs.max_bytes = options.max_blob_bytes;
  blobs.connect_timeout = options.connect_timeout;
  blobs.attempt_timeout = options.transfer_timeout;
  blobs.idle_timeout = options.idle_timeout;
  blobs.attempts = options.attempts;
  blobs.backoff = options.backoff;
  blobs.stop = options.stop;
  return blobs;
}

}  // namespace

CheckpointClient::CheckpointClient(std::shared_ptr<grpc::Channel> channel,
                                   Options options)
    : options_(std::move(options)),
      stub_(v1::Checkpoints::NewStub(channel)),
      calls_(channel, {.peer = options_.peer,
                       .connect_timeout = options_.connect_timeout,
                       .backoff = options_.backoff,
                       .stop = options_.stop}),
      blobs_(channel, BlobOptions(options_)) {}

template <typename Request, typename Response>
absl::StatusOr<Response> CheckpointClient::Call(
    Method<Request, Response> method, const Request& request, int attempts) {
  Response response;
  const absl::Status status = calls_.Run(attempts, [&] {
    grpc::ClientContext context;
    rpc::SetTimeout(context, options_.call_timeout);
    const std::stop_callback cancel(options_.stop,
                                    [&context] { context.TryCancel(); });
    response.Clear();
    return rpc::FromGrpc((stub_.get()->*method)(&context, request, &response),
                         options_.peer);
  });
  if (!status.ok()) return status;
  return response;
}

absl::StatusOr<Blob> CheckpointClient::GetBlob(const std::string& sha256) {
  return blobs_.GetBlob(sha256);
}

absl::Status CheckpointClient::Send(const std::string& sha256,
                                    const std::string& bytes) {
  grpc::ClientContext context;
  rpc::SetTimeout(context, options_.transfer_timeout);
  const std::stop_callback cancel(options_.stop,
                                  [&context] { context.TryCancel(); });
  rpc::Watchdog watchdog(options_.idle_timeout,
                         [&context] { context.TryCancel(); });
  v1::PutBlobResponse response;
  const auto writer = stub_->PutBlob(&context, &response);
  v1::PutBlobRequest message;
  message.set_sha256(sha256);
  message.set_size(static_cast<int64_t>(bytes.size()));
  // A write fails once the server has answered: refused, or has the bytes.
  if (writer->Write(message) && !bytes.empty()) {
    message.Clear();
    rpc::ForEachChunk(bytes, 0, [&](absl::string_view data, bool /*first*/) {
      watchdog.Feed();
      message.set_data(data.data(), data.size());
      return writer->Write(message);
    });
  }
  watchdog.Feed();
  writer->WritesDone();
  const absl::Status status = rpc::FromGrpc(writer->Finish(), options_.peer);
  if (!status.ok() && watchdog.has_expired()) {
    return absl::DeadlineExceededError(absl::StrCat(
        options_.peer, ": blob ", sha256, ": the peer neither took bytes nor ",
        "answered for ", absl::FormatDuration(options_.idle_timeout)));
  }
  return status;
}

absl::StatusOr<std::string> CheckpointClient::PutBlob(const Blob& blob) {
  if (static_cast<int64_t>(blob->size()) > options_.max_blob_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat(options_.peer, ": blob: expected at most ",
                     options_.max_blob_bytes, " bytes, found ", blob->size()));
  }
  const std::string sha256 = Sha256Hex(*blob);
  SINEW_RETURN_IF_ERROR(
      calls_.Run(options_.attempts, [&] { return Send(sha256, *blob); }));
  return sha256;
}

absl::Status CheckpointClient::PutArtifact(const v1::Artifact& artifact) {
  v1::PutArtifactRequest request;
  *request.mutable_artifact() = artifact;
  return Call(&v1::Checkpoints::Stub::PutArtifact, request, options_.attempts)
      .status();
}

absl::StatusOr<v1::Artifact> CheckpointClient::GetArtifact(
    const std::string& name) {
  v1::GetArtifactRequest request;
  request.set_name(name);
  SINEW_ASSIGN_OR_RETURN(
      v1::GetArtifactResponse response,
      Call(&v1::Checkpoints::Stub::GetArtifact, request, options_.attempts));
  return std::move(*response.mutable_artifact());
}

absl::StatusOr<v1::ListArtifactsResponse> CheckpointClient::ListArtifacts(
    const std::string& kind) {
  v1::ListArtifactsRequest request;
  request.set_kind(kind);
  return Call(&v1::Checkpoints::Stub::ListArtifacts, request,
              options_.attempts);
}

absl::Status CheckpointClient::SetAlias(const std::string& alias,
                                        const std::string& id,
                                        const std::string& expected_id) {
  v1::SetAliasRequest request;
  request.mutable_alias()->set_name(alias);
  request.mutable_alias()->set_id(id);
  request.set_expected_id(expected_id);
  return Call(&v1::Checkpoints::Stub::SetAlias, request, options_.attempts)
      .status();
}

absl::Status CheckpointClient::Retain(const std::string& kind, int keep) {
  v1::RetainRequest request;
  request.set_kind(kind);
  request.set_keep(keep);
  return Call(&v1::Checkpoints::Stub::Retain, request, options_.attempts)
      .status();
}

absl::Status CheckpointClient::DropBlobs(
    absl::Span<const std::string> sha256s) {
  v1::DropBlobsRequest request;
  for (const std::string& sha256 : sha256s) request.add_sha256(sha256);
  // Twice would end another writer's hold on the same bytes.
  return Call(&v1::Checkpoints::Stub::DropBlobs, request, /*attempts=*/1)
      .status();
}

}  // namespace sinew::checkpoint
