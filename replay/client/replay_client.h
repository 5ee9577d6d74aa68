#ifndef SINEW_REPLAY_CLIENT_REPLAY_CLIENT_H_
#define SINEW_REPLAY_CLIENT_REPLAY_CLIENT_H_

#include <cstdint>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "grpcpp/channel.h"
#include "proto/sinew/v1/replay.grpc.pb.h"
#include "replay/client/replay.h"

namespace sinew::replay {

// Replay behind gRPC. Thread-safe; shares the channel; blocks and fails as
// Replay says. Calls wait for a peer that is not up yet, within their timeout.
class ReplayClient : public Replay {
 public:
  struct Options {
    // Says who the peer is in errors, e.g. "replay host:7001".
    std::string peer = "replay";
    // For Open and GetStatus.
    absl::Duration timeout = absl::Seconds(30);
    // A larger segment is refused before it is allocated.
    int64_t max_segment_bytes = int64_t{1} << 30;
  };

  ReplayClient(std::shared_ptr<grpc::Channel> channel, Options options);

  absl::Status Open(const v1::OpenRequest& request,
                    const std::stop_token& stop) override;
  absl::StatusOr<v1::PutSegmentResponse> Put(const std::string& run_id,
                                             int64_t order_id,
                                             absl::string_view bytes,
                                             absl::Duration timeout) override;
  absl::StatusOr<std::vector<SegmentPtr>> Take(
      const std::string& run_id, absl::Span<const int64_t> order_ids,
      absl::Duration timeout, const std::stop_token& stop) override;
  absl::StatusOr<v1::GetReplayStatusResponse> GetStatus(
      const std::stop_token& stop) override;

 private:
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<v1::Replay::Stub> stub_;
  const Options options_;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_CLIENT_REPLAY_CLIENT_H_
