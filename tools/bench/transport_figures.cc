#include "tools/bench/transport_figures.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>
#include <memory>
#include <numeric>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "common/config/recipe.h"
#include "common/digest.h"
#include "common/metrics/registry.h"
#include "common/policy/builder.h"
#include "common/rpc/channel.h"
#include "common/rpc/server.h"
#include "common/segment/segment_layout.h"
#include "common/status_macros.h"
#include "common/temporary_folder.h"
#include "learner/ppo/synthetic_segments.h"
#include "replay/client/segment_stream.h"
#include "replay/local_replay.h"
#include "replay/replay_metrics.h"
#include "replay/service/replay_service.h"
#include "replay/table.h"

namespace sinew::bench {
namespace {

constexpr char kRun[] = "bench";
constexpr absl::Duration kTimeout = absl::Minutes(2);
// Row of a humanoid's state: time, 35 positions, 34 velocities, warm start.
constexpr int kPhysicsNumbers = 110;

// The segments of one iteration and what replay is to expect of them.
struct Iteration {
  v1::OpenRequest open;
  std::vector<std::string> bytes;
  std::vector<int64_t> ids;
};

absl::StatusOr<std::vector<v1::Segment>> MakeSegments(
    const TransportOptions& options) {
  const policy::TrackingPolicyOptions network = {
      .observation_width = options.observation_width,
      .action_width = options.action_width,
      .network = WithDefaults(v1::Recipe()).network()};
  SINEW_ASSIGN_OR_RETURN(const v1::PolicyGraph graph,
                         policy::BuildTrackingPolicy(network));
  SINEW_ASSIGN_OR_RETURN(const TensorMap weights,
                         policy::InitialWeights(network, 1));
  return learner::MakeSyntheticSegments(
      {.observation_width = options.observation_width,
       .action_width = options.action_width,
       .orders = options.orders,
       .environments = options.environments,
       .steps = options.steps,
       .terminated_share = 0.005,
       .truncated_share = 0.003},
      graph, weights, /*iteration=*/0);
}

Iteration MakeIteration(const TransportOptions& options, int iteration,
                        std::vector<v1::Segment>& segments) {
  Iteration result;
  const std::string snapshot = Sha256Hex("snapshot");
  result.open.set_run_id(kRun);
  result.open.set_reset(iteration == 0);
  *result.open.mutable_layout() =
      MakeSegmentLayout(options.observation_width, options.action_width);
  const std::string layout = LayoutSha256(result.open.layout());
  for (size_t i = 0; i < segments.size(); ++i) {
    v1::Segment& segment = segments[i];
    segment.set_run_id(kRun);
    segment.set_order_id(iteration * options.orders + static_cast<int64_t>(i));
    segment.set_iteration(iteration);
    segment.set_snapshot_sha256(snapshot);
    segment.set_layout_sha256(layout);
    segment.clear_end_states();
    for (int e = 0; e < options.environments; ++e) {
      v1::EnvironmentState& state = *segment.add_end_states();
      state.mutable_physics()->Resize(kPhysicsNumbers, 0.5);
      state.set_episode(options.steps);  // as many as may have ended
    }
    v1::OpenRequest::Expected& expected = *result.open.add_expected();
    expected.set_order_id(segment.order_id());
    expected.set_iteration(iteration);
    expected.set_snapshot_sha256(snapshot);
    expected.set_layout_sha256(layout);
    expected.set_environments(options.environments);
    expected.set_steps(options.steps);
    result.ids.push_back(segment.order_id());
    result.bytes.push_back(segment.SerializeAsString());
  }
  return result;
}

// An actor's side: writes all, then reads a verdict for each.
absl::Status Send(const Iteration& iteration, replay::SegmentStream& stream) {
  for (size_t i = 0; i < iteration.ids.size(); ++i) {
    stream.Write(kRun, iteration.ids[i], iteration.bytes[i]);
  }
  for (const int64_t id : iteration.ids) {
    SINEW_ASSIGN_OR_RETURN(const v1::PutSegmentResponse verdict, stream.Read());
    if (verdict.verdict() == v1::PutSegmentResponse::VERDICT_ACCEPTED) continue;
    return absl::InternalError(
        absl::StrCat("segment ", id, " was not accepted: ", verdict.detail()));
  }
  return absl::OkStatus();
}

// Seconds of wall and processor of one iteration.
struct Cost {
  double wall = 0, cpu = 0;
};

absl::StatusOr<Cost> Measure(const Iteration& iteration,
                             replay::SegmentStream& stream,
                             replay::Replay& replay) {
  SINEW_RETURN_IF_ERROR(replay.Open(iteration.open, {}));
  const std::clock_t cpu = std::clock();
  const auto begin = std::chrono::steady_clock::now();
  absl::Status sent;
  std::stop_source refused;
  std::jthread actor([&] {
    sent = Send(iteration, stream);
    if (!sent.ok()) refused.request_stop();
  });
  const auto taken =
      replay.Take(kRun, iteration.ids, kTimeout, refused.get_token());
  const std::chrono::duration<double> wall =
      std::chrono::steady_clock::now() - begin;
  actor.join();
  SINEW_RETURN_IF_ERROR(sent);
  SINEW_RETURN_IF_ERROR(taken.status());
  return Cost{wall.count(),
              static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC};
}

}  // namespace

absl::StatusOr<TransportFigures> MeasureTransport(
    const TransportOptions& options) {
  metrics::Registry registry({.role = "replay", .build = "bench"});
  replay::ReplayMetrics metrics(registry);
  replay::Table table({}, metrics);
  replay::ReplayService service(table);
  SINEW_ASSIGN_OR_RETURN(const std::unique_ptr<TemporaryFolder> folder,
                         TemporaryFolder::Create());
  SINEW_ASSIGN_OR_RETURN(
      const std::unique_ptr<rpc::Server> server,
      rpc::Server::Start(
          {.address = absl::StrCat("unix:", folder->path(), "/replay")},
          {&service}));
  SINEW_ASSIGN_OR_RETURN(const auto channel,
                         rpc::MakeChannel(server->address(), {}));
  SINEW_ASSIGN_OR_RETURN(std::vector<v1::Segment> segments,
                         MakeSegments(options));
  replay::LocalReplay replay(table);
  replay::SegmentStream stream(channel, "replay", kTimeout);
  TransportFigures figures;
  double wall = std::numeric_limits<double>::infinity(), cpu = wall;
  double bytes = 0;
  for (int i = 0; i < options.iterations; ++i) {
    const Iteration iteration = MakeIteration(options, i, segments);
    bytes = 0;
    for (const std::string& one : iteration.bytes) {
      bytes += static_cast<double>(one.size());
    }
    SINEW_ASSIGN_OR_RETURN(const Cost cost, Measure(iteration, stream, replay));
    figures.bytes += static_cast<int64_t>(bytes);
    wall = std::min(wall, cost.wall);
    cpu = std::min(cpu, cost.cpu);
  }
  table.Close();
  figures.bytes_per_sample =
      bytes / (options.orders * options.environments * options.steps);
  figures.gb_per_s = bytes / wall * 1e-9;
  figures.core_s_per_gb = cpu / bytes * 1e9;
  figures.core_share = figures.core_s_per_gb * 1e-9 * figures.bytes_per_sample *
                       options.samples_per_s;
  return figures;
}

}  // namespace sinew::bench
