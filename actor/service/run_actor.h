#ifndef SINEW_ACTOR_SERVICE_RUN_ACTOR_H_
#define SINEW_ACTOR_SERVICE_RUN_ACTOR_H_

#include <string>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "common/rpc/credentials.h"
#include "common/stop.h"

namespace sinew::actor {

struct RunActorOptions {
  // Where the learner's dispatcher listens.
  std::string dispatcher_address;
  rpc::Security security;
  // HOST:PORT of the metrics endpoint, port 0 for a free one; empty: none.
  std::string metrics_address;
  // Folder for fetched assets; empty: "cache" in the current folder.
  std::string cache_folder;
  // Worker threads; 0: one per available CPU.
  int threads = 0;
  // Name in the learner's logs; empty: host and process id.
  std::string name;
  // See Actor::Options.
  absl::Duration drain_timeout = absl::Seconds(20);
  absl::Duration reconnect_timeout = absl::Minutes(2);
};

// The role `sinew actor`: works until `stop` or until the learner drains, see
// actor.h, with which it also fails; ALREADY_EXISTS: the metrics port is in
// use.
absl::Status RunActor(const RunActorOptions& options, const StopToken& stop);

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_RUN_ACTOR_H_
