#include "actor/service/actor_metrics.h"

#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/strip.h"

namespace sinew::actor {
namespace {

using Response = v1::PutSegmentResponse;

// "VERDICT_STALE" -> "stale".
std::string Label(const std::string& name, const std::string& prefix) {
  return absl::AsciiStrToLower(absl::StripPrefix(name, prefix));
}

double EnvSteps(const v1::Order& order, const v1::Segment& segment) {
  if (order.kind() == v1::Order::KIND_TRAIN) {
    return static_cast<double>(order.horizon()) * order.states_size();
  }
  double steps = 0;
  for (const auto& result : segment.results()) steps += result.frames();
  return steps;
}

}  // namespace

ActorMetrics::ActorMetrics(metrics::Registry& registry)
    : stage_seconds(registry, {"simulate", "infer", "observe", "encode",
                               "fetch", "idle", "blocked", "send"}),
      env_steps(
          registry.AddCounter("sinew_env_steps_total", "Control steps taken.")),
      physics_steps(registry.AddCounter("sinew_physics_steps_total",
                                        "Physics steps taken.")),
      diverged(registry.AddCounter(
          "sinew_simulations_diverged_total",
          "Simulations that became non-finite and were reset.")),
      orders_taken(
          registry.AddCounter("sinew_orders_taken_total", "Orders received.")),
      orders_returned(registry.AddCounter("sinew_orders_returned_total",
                                          "Orders given back.")),
      reconnects(registry.AddCounter(
          "sinew_reconnects_total",
          "Streams to the dispatcher or to replay that broke.")),
      applied_policy_version(
          registry.AddGauge("sinew_applied_policy_version",
                            "Version of the snapshot acted with last.")),
      publish_to_apply_seconds(registry.AddHistogram(
          "sinew_publish_to_apply_seconds",
          "From first hearing of a version to acting with it.",
          metrics::SecondsBuckets())),
      queue_bytes(registry.AddGauge(
          "sinew_queue_bytes", "Bytes of segments that wait for a verdict.")),
      queue_limit_bytes(registry.AddGauge("sinew_queue_limit_bytes",
                                          "Bound of the queue in bytes.")),
      orders_held(
          registry.AddGauge("sinew_orders_held", "Orders waiting or running.")),
      threads(registry.AddGauge("sinew_worker_threads", "Worker threads.")),
      accepted(registry.AddCounter("sinew_segments_accepted_total",
                                   "Segments that replay accepted.")) {
  for (int i = Response::VERDICT_DUPLICATE; i <= Response::Verdict_MAX; ++i) {
    const auto verdict = static_cast<Response::Verdict>(i);
    refused_[verdict] = &registry.AddCounter(
        "sinew_segments_refused_total", "Segments that replay refused.",
        {{"reason", Label(Response::Verdict_Name(verdict), "VERDICT_")}});
  }
  for (int i = v1::EpisodeEnd::REASON_TERMINATED;
       i <= v1::EpisodeEnd::Reason_MAX; ++i) {
    const auto reason = static_cast<v1::EpisodeEnd::Reason>(i);
    episode_ends_[reason] = &registry.AddCounter(
        "sinew_episode_ends_total", "Episodes that ended, by reason.",
        {{"reason", Label(v1::EpisodeEnd::Reason_Name(reason), "REASON_")}});
  }
}

void ActorMetrics::Count(const v1::Order& order, const v1::Segment& segment) {
  stage_seconds.Add("simulate", segment.seconds().simulate());
  stage_seconds.Add("infer", segment.seconds().infer());
  stage_seconds.Add("observe", segment.seconds().observe());
  env_steps.Increment(EnvSteps(order, segment));
  physics_steps.Increment(static_cast<double>(segment.physics_steps()));
  diverged.Increment(segment.diverged());
  for (const auto& end : segment.episodes()) {
    const auto found = episode_ends_.find(end.reason());
    if (found != episode_ends_.end()) found->second->Increment();
  }
}

void ActorMetrics::Count(const v1::PutSegmentResponse& response) {
  const auto found = refused_.find(response.verdict());
  (found == refused_.end() ? accepted : *found->second).Increment();
}

}  // namespace sinew::actor
