#ifndef SINEW_ACTOR_SERVICE_ACTOR_METRICS_H_
#define SINEW_ACTOR_SERVICE_ACTOR_METRICS_H_

#include <map>

#include "common/metrics/registry.h"
#include "common/metrics/stage_seconds.h"
#include "proto/sinew/v1/replay.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor {

// The series of an actor. Thread-safe; valid as long as the registry.
struct ActorMetrics {
  explicit ActorMetrics(metrics::Registry& registry);

  // Adds what a finished rollout says of itself.
  void Count(const v1::Order& order, const v1::Segment& segment);
  // Adds replay's answer.
  void Count(const v1::PutSegmentResponse& response);

  // "simulate", "infer", "observe" inside rollouts; "encode" of segments;
  // "fetch" of assets and snapshots; "idle" without orders; "blocked" by
  // replay; "send".
  metrics::StageSeconds stage_seconds;
  metrics::Counter& env_steps;
  metrics::Counter& physics_steps;
  metrics::Counter& diverged;
  metrics::Counter& orders_taken;
  metrics::Counter& orders_returned;
  metrics::Counter& reconnects;
  metrics::Gauge& applied_policy_version;
  metrics::Histogram& publish_to_apply_seconds;
  metrics::Gauge& queue_bytes;
  metrics::Gauge& queue_limit_bytes;
  metrics::Gauge& orders_held;
  metrics::Gauge& threads;
  metrics::Counter& accepted;

 private:
  std::map<v1::PutSegmentResponse::Verdict, metrics::Counter*> refused_;
  std::map<v1::EpisodeEnd::Reason, metrics::Counter*> episode_ends_;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_ACTOR_METRICS_H_
