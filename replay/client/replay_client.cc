#include "replay/client/replay_client.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/rpc/channel.h"
#include "common/rpc/chunks.h"
#include "common/rpc/status.h"
#include "common/status_context.h"
#include "common/status_macros.h"
#include "replay/client/segment_stream.h"

namespace sinew::replay {
namespace {

// gRPC says CANCELLED of a call that reaches a server which is shutting down.
// To whoever did not cancel it, the peer is away.
absl::Status AwayIfCancelled(const absl::Status& status,
                             const std::stop_token& stop) {
  if (!absl::IsCancelled(status) || stop.stop_requested()) return status;
  return absl::UnavailableError(
      absl::StrCat(status.message(), " (the peer ended the call)"));
}

// Puts the segments of one Take together.
class Collector {
 public:
  explicit Collector(int64_t max_segment_bytes) : payload_(max_segment_bytes) {}

  absl::Status Add(const v1::TakeResponse& chunk) {
    if (!payload_.begun()) {
      SINEW_RETURN_IF_ERROR(payload_.Begin(chunk.total_size()));
    }
    SINEW_RETURN_IF_ERROR(
        payload_.Append({chunk.data().data(), chunk.data().size()}));
    if (!payload_.complete()) return absl::OkStatus();
    auto segment = std::make_shared<v1::Segment>();
    if (!segment->ParseFromString(payload_.Release())) {
      return absl::DataLossError(absl::StrCat(
          "the segment of order ", chunk.order_id(), " does not parse"));
    }
    segments_.push_back(std::move(segment));
    return absl::OkStatus();
  }

  absl::StatusOr<std::vector<SegmentPtr>> Finish(size_t expected) {
    if (payload_.begun() || segments_.size() != expected) {
      return absl::DataLossError(absl::StrCat(
          "expected ", expected, " segments, found ", segments_.size()));
    }
    return std::move(segments_);
  }

 private:
  rpc::ChunkAssembler payload_;
  std::vector<SegmentPtr> segments_;
};

}  // namespace

ReplayClient::ReplayClient(std::shared_ptr<grpc::Channel> channel,
                           Options options)
    : channel_(std::move(channel)),
      stub_(v1::Replay::NewStub(channel_)),
      options_(std::move(options)) {}

absl::Status ReplayClient::Open(const v1::OpenRequest& request,
                                const std::stop_token& stop) {
  grpc::ClientContext context;
  rpc::SetTimeout(context, options_.timeout);
  context.set_wait_for_ready(true);
  const std::stop_callback cancel(stop, [&context] { context.TryCancel(); });
  v1::OpenResponse response;
  return AwayIfCancelled(
      rpc::FromGrpc(stub_->Open(&context, request, &response), options_.peer),
      stop);
}

absl::StatusOr<v1::PutSegmentResponse> ReplayClient::Put(
    const std::string& run_id, int64_t order_id, absl::string_view bytes,
    absl::Duration timeout) {
  SegmentStream stream(channel_, options_.peer, timeout);
  // A broken stream shows when it is read.
  stream.Write(run_id, order_id, bytes);
  stream.CloseWrites();
  auto verdict = stream.Read();
  if (!verdict.ok()) return AwayIfCancelled(verdict.status(), {});
  return verdict;
}

absl::StatusOr<std::vector<SegmentPtr>> ReplayClient::Take(
    const std::string& run_id, absl::Span<const int64_t> order_ids,
    absl::Duration timeout, const std::stop_token& stop) {
  grpc::ClientContext context;
  rpc::SetTimeout(context, timeout);
  context.set_wait_for_ready(true);
  const std::stop_callback cancel(stop, [&context] { context.TryCancel(); });
  v1::TakeRequest request;
  request.set_run_id(run_id);
  request.mutable_order_ids()->Add(order_ids.begin(), order_ids.end());
  const auto reader = stub_->Take(&context, request);
  Collector collector(options_.max_segment_bytes);
  v1::TakeResponse chunk;
  absl::Status status;
  while (status.ok() && reader->Read(&chunk)) status = collector.Add(chunk);
  if (!status.ok()) context.TryCancel();
  const absl::Status finished = rpc::FromGrpc(reader->Finish(), options_.peer);
  SINEW_RETURN_IF_ERROR(WithContext(status, options_.peer));
  SINEW_RETURN_IF_ERROR(AwayIfCancelled(finished, stop));
  return collector.Finish(order_ids.size());
}

absl::StatusOr<v1::GetReplayStatusResponse> ReplayClient::GetStatus(
    const std::stop_token& stop) {
  grpc::ClientContext context;
  rpc::SetTimeout(context, options_.timeout);
  context.set_wait_for_ready(true);
  const std::stop_callback cancel(stop, [&context] { context.TryCancel(); });
  v1::GetReplayStatusResponse response;
  SINEW_RETURN_IF_ERROR(AwayIfCancelled(
      rpc::FromGrpc(
          stub_->GetStatus(&context, v1::GetReplayStatusRequest(), &response),
          options_.peer),
      stop));
  return response;
}

}  // namespace sinew::replay
