#include "replay/client/segment_stream.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/rpc/channel.h"
#include "common/rpc/chunks.h"
#include "common/rpc/status.h"
#include "common/status_macros.h"

namespace sinew::replay {

SegmentStream::SegmentStream(std::shared_ptr<grpc::Channel> channel,
                             std::string peer, absl::Duration timeout)
    : stub_(v1::Replay::NewStub(std::move(channel))), peer_(std::move(peer)) {
  if (timeout != absl::InfiniteDuration()) rpc::SetTimeout(context_, timeout);
  stream_ = stub_->Put(&context_);
}

SegmentStream::~SegmentStream() {
  context_.TryCancel();
  if (!finished_) stream_->Finish().ok();
}

bool SegmentStream::Write(const std::string& run_id, int64_t order_id,
                          absl::string_view bytes) {
  v1::PutSegmentRequest chunk;
  chunk.set_run_id(run_id);
  chunk.set_order_id(order_id);
  chunk.set_total_size(static_cast<int64_t>(bytes.size()));
  return rpc::ForEachChunk(bytes, 0, [&](absl::string_view data, bool first) {
    if (!first) chunk.Clear();
    chunk.set_data(data.data(), data.size());
    return stream_->Write(chunk);
  });
}

void SegmentStream::CloseWrites() { stream_->WritesDone(); }

absl::StatusOr<v1::PutSegmentResponse> SegmentStream::Read() {
  v1::PutSegmentResponse response;
  if (stream_->Read(&response)) return response;
  finished_ = true;
  SINEW_RETURN_IF_ERROR(rpc::FromGrpc(stream_->Finish(), peer_));
  return absl::OutOfRangeError(absl::StrCat(peer_, ": end of stream"));
}

void SegmentStream::Cancel() { context_.TryCancel(); }

}  // namespace sinew::replay
