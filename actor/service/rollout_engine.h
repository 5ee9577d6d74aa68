#ifndef SINEW_ACTOR_SERVICE_ROLLOUT_ENGINE_H_
#define SINEW_ACTOR_SERVICE_ROLLOUT_ENGINE_H_

#include <map>
#include <memory>
#include <string>

#include "actor/service/engine.h"

namespace sinew::actor {

// The engine that simulates: actor/rollout.h behind the service's interface.
class RolloutEngine : public Engine {
 public:
  absl::StatusOr<AssetsPtr> LoadAssets(
      const std::map<std::string, SharedBytes>& by_role) override;
  absl::StatusOr<SnapshotPtr> LoadSnapshot(const std::string& bytes,
                                           const std::string& sha256,
                                           const Assets& assets) override;
  absl::StatusOr<std::unique_ptr<Worker>> MakeWorker(
      AssetsPtr assets, int max_environments) override;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_ROLLOUT_ENGINE_H_
