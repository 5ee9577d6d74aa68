#include "replay/service/replay_service.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "common/rpc/chunks.h"
#include "common/rpc/status.h"
#include "common/status_macros.h"

namespace sinew::replay {
namespace {

using Response = v1::PutSegmentResponse;
using PutStream =
    grpc::ServerReaderWriter<v1::PutSegmentResponse, v1::PutSegmentRequest>;

// A Take without deadline ends after this long all the same.
constexpr absl::Duration kLongestTake = absl::Minutes(10);

// When a Take gives up whose caller waits until `deadline`: early enough for
// what it then says to arrive.
absl::Time GiveUpAt(absl::Time now, absl::Time deadline) {
  const absl::Duration left = std::min(deadline - now, kLongestTake);
  return now + left - std::min(absl::Seconds(2), left / 4);
}

// One actor's stream: takes chunks one by one, answers complete segments.
class Receiver {
 public:
  Receiver(Table& table, grpc::ServerContext& context, PutStream& stream)
      : table_(table),
        context_(context),
        stream_(stream),
        payload_(std::numeric_limits<int64_t>::max()) {}

  absl::Status Run() {
    v1::PutSegmentRequest chunk;
    while (stream_.Read(&chunk)) {
      if (remaining_ == 0) SINEW_RETURN_IF_ERROR(Begin(chunk));
      SINEW_RETURN_IF_ERROR(Append(chunk.data()));
      if (remaining_ == 0) Finish();
    }
    return absl::OkStatus();
  }

 private:
  absl::Status Begin(const v1::PutSegmentRequest& first) {
    if (first.total_size() < 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "first chunk of order ", first.order_id(),
          ": total_size: expected >= 1, found ", first.total_size()));
    }
    SINEW_ASSIGN_OR_RETURN(
        admission_, table_.Admit(first.run_id(), first.order_id(),
                                 first.total_size(), absl::InfiniteFuture(),
                                 [this] { return context_.IsCancelled(); }));
    remaining_ = first.total_size();
    if (admission_.refusal.has_value()) return absl::OkStatus();
    return payload_.Begin(first.total_size());
  }

  absl::Status Append(absl::string_view data) {
    if (static_cast<int64_t>(data.size()) > remaining_) {
      return absl::InvalidArgumentError(absl::StrCat(
          "chunk: expected at most ", remaining_,
          " bytes to the declared total_size, found ", data.size()));
    }
    remaining_ -= static_cast<int64_t>(data.size());
    if (admission_.refusal.has_value()) return absl::OkStatus();
    return payload_.Append({data.data(), data.size()});
  }

  void Finish() {
    const Response response =
        admission_.refusal.has_value()
            ? *std::move(admission_.refusal)
            : table_.Put(std::move(admission_.room), payload_.Release());
    admission_ = {};
    // False: the actor is gone; the next Read says so too.
    stream_.Write(response);
  }

  Table& table_;
  grpc::ServerContext& context_;
  PutStream& stream_;
  Table::Admission admission_;
  // The table's bound holds, through Admit.
  rpc::ChunkAssembler payload_;
  // Bytes of the current segment that are still to come.
  int64_t remaining_ = 0;
};

bool SendSegment(const v1::Segment& segment,
                 grpc::ServerWriter<v1::TakeResponse>& writer) {
  const std::string bytes = segment.SerializeAsString();
  v1::TakeResponse chunk;
  chunk.set_order_id(segment.order_id());
  return rpc::ForEachChunk(bytes, 0, [&](absl::string_view data, bool first) {
    chunk.set_total_size(first ? static_cast<int64_t>(bytes.size()) : 0);
    chunk.set_data(data.data(), data.size());
    return writer.Write(chunk);
  });
}

}  // namespace

grpc::Status ReplayService::Open(grpc::ServerContext* /*context*/,
                                 const v1::OpenRequest* request,
                                 v1::OpenResponse* /*response*/) {
  return rpc::ToGrpc(table_.Open(*request));
}

grpc::Status ReplayService::Put(grpc::ServerContext* context,
                                PutStream* stream) {
  return rpc::ToGrpc(Receiver(table_, *context, *stream).Run());
}

grpc::Status ReplayService::Take(grpc::ServerContext* context,
                                 const v1::TakeRequest* request,
                                 grpc::ServerWriter<v1::TakeResponse>* writer) {
  const absl::Time deadline =
      GiveUpAt(absl::Now(), absl::FromChrono(context->deadline()));
  // The caller hears that it waits.
  writer->SendInitialMetadata();
  const auto segments =
      table_.Collect(request->run_id(), request->order_ids(), deadline,
                     [context] { return context->IsCancelled(); });
  if (!segments.ok()) return rpc::ToGrpc(segments.status());
  for (const SegmentPtr& segment : *segments) {
    // Nothing is removed: the learner can ask again.
    if (!SendSegment(*segment, *writer)) return grpc::Status::CANCELLED;
  }
  table_.Remove(request->run_id(), request->order_ids());
  return grpc::Status::OK;
}

grpc::Status ReplayService::GetStatus(
    grpc::ServerContext* /*context*/,
    const v1::GetReplayStatusRequest* /*request*/,
    v1::GetReplayStatusResponse* response) {
  *response = table_.Status();
  return grpc::Status::OK;
}

}  // namespace sinew::replay
