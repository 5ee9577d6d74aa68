#ifndef SINEW_ACTOR_SERVICE_TESTING_FAKE_ENGINE_H_
#define SINEW_ACTOR_SERVICE_TESTING_FAKE_ENGINE_H_

#include <atomic>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "actor/service/engine.h"
#include "common/mutex.h"

namespace sinew::actor {

// An engine without physics: its segments are those of replay/testing, a pure
// function of the order, made at once. It can be held, so that rollouts last
// until Release or their cancellation, and told to fail.
//
// Thread-safety: any thread.
class FakeEngine : public Engine {
 public:
  // Any assets with a role "model" and any snapshot bytes will do.
  absl::StatusOr<AssetsPtr> LoadAssets(
      const std::map<std::string, SharedBytes>& by_role) override;
  absl::StatusOr<SnapshotPtr> LoadSnapshot(const std::string& bytes,
                                           const std::string& sha256,
                                           const Assets& assets) override;
  absl::StatusOr<std::unique_ptr<Worker>> MakeWorker(
      AssetsPtr assets, int max_environments) override;

  // From now on rollouts wait.
  void Hold() SINEW_EXCLUDES(mu_);
  void Release() SINEW_EXCLUDES(mu_);
  // Waits until so many rollouts are held.
  void WaitUntilHeld(int count) SINEW_EXCLUDES(mu_);
  // Rollouts of this order fail with this status.
  void Fail(int64_t order_id, absl::Status status) SINEW_EXCLUDES(mu_);

  // Segments of this order hold a number that is not finite.
  void Spoil(int64_t order_id) SINEW_EXCLUDES(mu_);

  int snapshots_loaded() const { return snapshots_loaded_; }

 private:
  class FakeWorker;

  absl::StatusOr<v1::Segment> Run(const v1::Order& order,
                                  const std::atomic<bool>& cancel)
      SINEW_EXCLUDES(mu_);

  std::atomic<int> snapshots_loaded_ = 0;
  Mutex mu_;
  CondVar changed_;
  bool hold_ SINEW_GUARDED_BY(mu_) = false;
  int held_ SINEW_GUARDED_BY(mu_) = 0;
  std::map<int64_t, absl::Status> failures_ SINEW_GUARDED_BY(mu_);
  std::set<int64_t> spoilt_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_TESTING_FAKE_ENGINE_H_
