#include "teacher/service/teacher_service.h"

#include <algorithm>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "absl/types/span.h"
#include "common/metrics/registry.h"
#include "common/rpc/channel.h"
#include "common/rpc/server.h"
#include "common/rpc/status.h"
#include "common/rpc/testing/held_grpc.h"
#include "common/rpc/testing/socket_folder.h"
#include "common/testing/matchers.h"
#include "common/testing/simulated_clock.h"
#include "gmock/gmock.h"
#include "grpcpp/client_context.h"
#include "gtest/gtest.h"

namespace sinew::teacher {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::SimulatedClock;

[[maybe_unused]] const auto* const held_grpc =
    ::testing::AddGlobalTestEnvironment(new rpc::HeldGrpc());

// One observation, one action: the target is the base.
class Echo final : public Annotator {
 public:
  Echo() {
    description_.set_observation_width(1);
    description_.set_action_width(1);
    description_.set_bundle_sha256(std::string(64, 'a'));
  }
  const v1::DescribeTeacherResponse& description() const override {
    return description_;
  }
  absl::Span<const double> spread() const override { return {}; }
  absl::Status Annotate(const Rows& rows, absl::Span<double> targets) override {
    std::copy(rows.bases.begin(), rows.bases.end(), targets.begin());
    return absl::OkStatus();
  }

 private:
  v1::DescribeTeacherResponse description_;
};

v1::AnnotateRequest OneRow() {
  v1::AnnotateRequest request;
  request.set_bundle_sha256(std::string(64, 'a'));
  request.set_rows(1);
  request.set_observations(std::string(sizeof(float), '\0'));
  request.set_bases(std::string(sizeof(double), '\0'));
  return request;
}

// Rows wait 90 s for others, by a clock that stands until it is told.
TEST(TeacherService, LetsACallWaitAsLongAsItsOwnDeadline) {
  SimulatedClock clock;
  metrics::Registry registry({.role = "teacher", .build = ""});
  TeacherMetrics metrics(registry);
  Echo annotator;
  Batcher batcher(
      annotator,
      {.max_batch_rows = 4, .batch_delay = absl::Seconds(90), .queue_rows = 8},
      clock, metrics);
  TeacherService service(annotator, batcher, /*max_batch_rows=*/4, clock,
                         metrics);
  const rpc::SocketFolder folder;
  const auto server =
      rpc::Server::Start({.address = folder.Address("t")}, {&service});
  ASSERT_THAT(server, IsOk());
  const auto stub =
      v1::Teacher::NewStub(*rpc::MakeChannel((*server)->address(), {}));
  absl::Status status;
  std::jthread caller([&] {
    grpc::ClientContext context;
    rpc::SetTimeout(context, absl::Minutes(5));
    v1::AnnotateResponse response;
    status = rpc::FromGrpc(stub->Annotate(&context, OneRow(), &response), "t");
  });
  while (metrics.queue_rows.Value() != 1) std::this_thread::yield();

  // The call, and the thread that computes batches.
  clock.AwaitWaiters(2);
  clock.Advance(absl::Seconds(90) + absl::Milliseconds(1));
  caller.join();

  EXPECT_THAT(status, IsOk());
}

}  // namespace
}  // namespace sinew::teacher
