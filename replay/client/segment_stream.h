#ifndef SINEW_REPLAY_CLIENT_SEGMENT_STREAM_H_
#define SINEW_REPLAY_CLIENT_SEGMENT_STREAM_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/sync_stream.h"
#include "proto/sinew/v1/replay.grpc.pb.h"

namespace sinew::replay {

// One stream of segments to replay, with one verdict for each, in order.
//
//   writer thread: Write(1) Write(2) Write(3) ...            CloseWrites
//   reader thread:      Read(1) Read(2) Read(3) ... Read -> OUT_OF_RANGE
//
// Thread-safety: one thread writes, one reads, any cancels. Ownership: shares
// the channel. Blocking: Write while replay has no room (that is the
// back-pressure) and Read until a verdict; Cancel ends both at once, and
// whoever waits watches over progress. Errors: UNAVAILABLE and such name the
// peer; the stream is over then, and what has no verdict yet is to be sent
// again on another one, which is harmless.
class SegmentStream {
 public:
  // `peer` says who it is in errors, e.g. "replay unix:/run/r.sock". The whole
  // stream lasts at most `timeout` (DEADLINE_EXCEEDED); infinite for an
  // actor's, which watches over progress itself.
  SegmentStream(std::shared_ptr<grpc::Channel> channel, std::string peer,
                absl::Duration timeout);
  // Cancels.
  ~SegmentStream();
  SegmentStream(const SegmentStream&) = delete;
  SegmentStream& operator=(const SegmentStream&) = delete;

  // False: the stream is broken; Read says why.
  bool Write(const std::string& run_id, int64_t order_id,
             absl::string_view bytes);

  // No more segments; verdicts still come.
  void CloseWrites();

  // The next verdict. OUT_OF_RANGE: the stream ended in good order.
  absl::StatusOr<v1::PutSegmentResponse> Read();

  void Cancel();

 private:
  using Stream =
      grpc::ClientReaderWriter<v1::PutSegmentRequest, v1::PutSegmentResponse>;

  const std::unique_ptr<v1::Replay::Stub> stub_;
  const std::string peer_;
  grpc::ClientContext context_;
  std::unique_ptr<Stream> stream_;
  // By the reader.
  bool finished_ = false;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_CLIENT_SEGMENT_STREAM_H_
