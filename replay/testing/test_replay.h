#ifndef SINEW_REPLAY_TESTING_TEST_REPLAY_H_
#define SINEW_REPLAY_TESTING_TEST_REPLAY_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/metrics/registry.h"
#include "grpcpp/impl/codegen/service_type.h"
#include "proto/sinew/v1/replay.pb.h"
#include "replay/client/replay.h"
#include "replay/replay_metrics.h"
#include "replay/service/replay_service.h"
#include "replay/table.h"

namespace sinew::replay {

// The real table and service, for tests of who sends segments: register
// service() with a server, Open orders, Take what came. Runs are kRun's.
//
// Thread-safety: any thread. Blocking: Take, until the segments are there.
class TestReplay {
 public:
  explicit TestReplay(int64_t limit_bytes = int64_t{1} << 30)
      : table_({.limit_bytes = limit_bytes}, metrics_) {}

  // Bytes of the largest segment of segments.h's kind.
  static int64_t SegmentBytes();

  grpc::Service& service() { return service_; }

  absl::Status Open(const v1::OpenRequest& request) {
    return table_.Open(request);
  }
  absl::StatusOr<std::vector<SegmentPtr>> Take(absl::Span<const int64_t> ids);

  // A writer that has room for this order's segment (opened here) and does not
  // get on with it, until destroyed.
  std::unique_ptr<Table::Room> OccupyRoom(int64_t order_id);

  // Before the server's shutdown.
  void Close() { table_.Close(); }

 private:
  metrics::Registry registry_{{.role = "replay", .build = ""}};
  ReplayMetrics metrics_{registry_};
  Table table_;
  ReplayService service_{table_};
};

}  // namespace sinew::replay

#endif  // SINEW_REPLAY_TESTING_TEST_REPLAY_H_
