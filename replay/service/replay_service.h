#ifndef SINEW_REPLAY_SERVICE_REPLAY_SERVICE_H_
#define SINEW_REPLAY_SERVICE_REPLAY_SERVICE_H_

#include "proto/sinew/v1/replay.grpc.pb.h"
#include "replay/table.h"

namespace sinew::replay {

// A table behind gRPC (replay.proto). Back-pressure: while the table has no
// room for a segment, its stream is not read, so that gRPC's window closes and
// the actor's write blocks; what was refused by its key is read and dropped
// chunk by chunk.
//
//   Put:  read first chunk -> Admit -> read the rest -> Put -> write verdict
//   Take: write headers -> Collect (waits) -> write segments -> Remove
//
// Thread-safety: gRPC calls it from many threads, one per stream. Ownership:
// borrows the table; close the table before the server shuts down. Blocking:
// handlers see cancellation within 100 ms. Errors: as replay.proto says.
class ReplayService final : public v1::Replay::Service {
 public:
  explicit ReplayService(Table& table) : table_(table) {}

  grpc::Status Open(grpc::ServerContext* context,
                    const v1::OpenRequest* request,
                    v1::OpenResponse* response) override;
  grpc::Status Put(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::PutSegmentResponse, v1::PutSegmentRequest>*
          stream) override;
  grpc::Status Take(grpc::ServerContext* context,
                    const v1::TakeRequest* request,
                    grpc::ServerWriter<v1::TakeResponse>* writer) override;
  grpc::Status GetStatus(grpc::ServerContext* context,
                         const v1::GetReplayStatusRequest* request,
                         v1::GetReplayStatusResponse* response) override;

 private:
  Table& table_;
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_SERVICE_REPLAY_SERVICE_H_
