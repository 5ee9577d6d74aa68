#ifndef SINEW_ACTOR_SERVICE_ENGINE_H_
#define SINEW_ACTOR_SERVICE_ENGINE_H_

#include <atomic>
#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/blobs/blob_source.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor {

// What the service needs to know of rollouts: how bytes become assets and
// snapshots, and how a thread runs an order. rollout_engine.h is the real one,
// testing/fake_engine.h a fast one without physics.
//
// Thread-safety: any thread; a Worker belongs to one. Ownership: results are
// shared and may outlive the engine. Blocking: they compute. Errors:
// INVALID_ARGUMENT and FAILED_PRECONDITION for what can never work with this
// build (names asset or field, expected, found); CANCELLED.
class Engine {
 public:
  // Opaque; each engine has its own kinds and is given back only those.
  class Assets {
   public:
    virtual ~Assets() = default;
  };
  class Snapshot {
   public:
    virtual ~Snapshot() = default;
  };
  using AssetsPtr = std::shared_ptr<const Assets>;
  using SnapshotPtr = std::shared_ptr<const Snapshot>;

  // Runs orders on one thread; see actor/rollout.h.
  class Worker {
   public:
    virtual ~Worker() = default;
    // Looks at `cancel` every control step.
    virtual absl::StatusOr<v1::Segment> Run(
        const v1::Order& order, const Snapshot& snapshot,
        const std::atomic<bool>& cancel) = 0;
  };

  virtual ~Engine() = default;

  // From the assets' bytes by role (rollout.proto, TaskAssets).
  virtual absl::StatusOr<AssetsPtr> LoadAssets(
      const std::map<std::string, SharedBytes>& by_role) = 0;
  // From the bytes whose digest is `sha256`.
  virtual absl::StatusOr<SnapshotPtr> LoadSnapshot(const std::string& bytes,
                                                   const std::string& sha256,
                                                   const Assets& assets) = 0;
  // For orders of at most `max_environments` environments.
  virtual absl::StatusOr<std::unique_ptr<Worker>> MakeWorker(
      AssetsPtr assets, int max_environments) = 0;
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_ENGINE_H_
