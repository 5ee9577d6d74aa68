#include "common/blobs/blob_client.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/rpc/channel.h"
#include "common/rpc/status.h"
#include "common/rpc/watchdog.h"
#include "common/status_context.h"
#include "common/status_macros.h"

namespace sinew {

BlobClient::BlobClient(std::shared_ptr<grpc::Channel> channel, Options options)
    : options_(std::move(options)),
      stub_(v1::Blobs::NewStub(channel)),
      calls_(std::move(channel), {.peer = options_.peer,
                                  .connect_timeout = options_.connect_timeout,
                                  .backoff = options_.backoff,
                                  .stop = options_.stop}) {}

absl::Status BlobClient::Receive(const std::string& sha256,
                                 rpc::ChunkAssembler& payload) {
  grpc::ClientContext context;
  rpc::SetTimeout(context, options_.attempt_timeout);
  const std::stop_callback cancel(options_.stop,
                                  [&context] { context.TryCancel(); });
  rpc::Watchdog watchdog(options_.idle_timeout,
                         [&context] { context.TryCancel(); });
  v1::GetBlobRequest request;
  request.set_sha256(sha256);
  request.set_offset(payload.received_bytes());
  const auto reader = stub_->GetBlob(&context, request);
  v1::BlobChunk chunk;
  absl::Status status;
  while (status.ok() && reader->Read(&chunk)) {
    watchdog.Feed();
    if (!payload.begun()) status = payload.Begin(chunk.total_size());
    if (status.ok()) status = payload.Append(chunk.data());
  }
  if (!status.ok()) {
    context.TryCancel();
    reader->Finish().ok();
    return status;
  }
  const absl::Status finished = rpc::FromGrpc(reader->Finish(), options_.peer);
  if (!finished.ok() && watchdog.has_expired()) {
    return absl::DeadlineExceededError(
        absl::StrCat("the peer sent nothing for ",
                     absl::FormatDuration(options_.idle_timeout), ", after ",
                     payload.received_bytes(), " bytes"));
  }
  SINEW_RETURN_IF_ERROR(finished);
  if (payload.complete()) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat("truncated after ", payload.received_bytes(), " bytes"));
}

absl::StatusOr<Blob> BlobClient::GetBlob(const std::string& sha256) {
  if (!IsSha256Hex(sha256)) {
    return absl::InvalidArgumentError(
        absl::StrCat("expected a SHA-256, found \"", sha256, "\""));
  }
  const std::string name = absl::StrCat(options_.peer, ": blob ", sha256);
  rpc::ChunkAssembler payload(options_.max_bytes);
  SINEW_RETURN_IF_ERROR(WithContext(
      calls_.Run(options_.attempts, [&] { return Receive(sha256, payload); }),
      name));
  auto bytes = std::make_shared<const std::string>(payload.Release());
  const std::string found = Sha256Hex(*bytes);
  if (found != sha256) {
    return absl::DataLossError(absl::StrCat(
        name, ": the bytes received have SHA-256 ", found, " instead"));
  }
  return bytes;
}

}  // namespace sinew
