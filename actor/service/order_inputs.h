#ifndef SINEW_ACTOR_SERVICE_ORDER_INPUTS_H_
#define SINEW_ACTOR_SERVICE_ORDER_INPUTS_H_

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "actor/service/actor_metrics.h"
#include "actor/service/engine.h"
#include "common/blobs/blob_source.h"
#include "common/mutex.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor {

// The latest few results of a slow computation by key. Whoever asks first
// computes, others wait for that; a failure is not kept.
//
// Thread-safety: any thread. Blocking: as long as the computation, which has
// deadlines of its own. Errors: the computation's.
template <typename T>
class LatestResults {
 public:
  using Result = absl::StatusOr<std::shared_ptr<const T>>;

  explicit LatestResults(size_t capacity) : capacity_(capacity) {}

  Result Get(const std::string& key, const std::function<Result()>& compute)
      SINEW_EXCLUDES(mu_) {
    std::promise<Result> promise;
    std::shared_future<Result> future;
    {
      MutexLock lock(mu_);
      for (const auto& [known, result] : results_) {
        if (known == key) future = result;
      }
      if (!future.valid()) {
        results_.emplace_back(key, promise.get_future().share());
        if (results_.size() > capacity_) results_.pop_front();
      }
    }
    if (future.valid()) return future.get();
    Result result = compute();
    if (!result.ok()) Forget(key);
    promise.set_value(result);
    return result;
  }

 private:
  void Forget(const std::string& key) SINEW_EXCLUDES(mu_) {
    MutexLock lock(mu_);
    std::erase_if(results_,
                  [&key](const auto& entry) { return entry.first == key; });
  }

  const size_t capacity_;
  Mutex mu_;
  std::deque<std::pair<std::string, std::shared_future<Result>>> results_
      SINEW_GUARDED_BY(mu_);
};

// Assets and snapshots that orders name by digest: fetched once, made ready
// once, the latest few kept for all threads.
//
// Thread-safety: any thread. Ownership: borrows engine and metrics, shares the
// rest. Blocking: while something is fetched. Errors: those of source and
// engine, naming digest and role; FAILED_PRECONDITION before SetSources.
class OrderInputs {
 public:
  struct Inputs {
    Engine::AssetsPtr assets;
    Engine::SnapshotPtr snapshot;
  };

  OrderInputs(Engine& engine, ActorMetrics& metrics)
      : engine_(engine), metrics_(metrics) {}

  // Where to fetch from now on.
  void SetSources(std::shared_ptr<BlobSource> assets,
                  std::shared_ptr<BlobSource> snapshots) SINEW_EXCLUDES(mu_);

  absl::StatusOr<Engine::AssetsPtr> GetAssets(const std::string& sha256);
  absl::StatusOr<Inputs> Get(const v1::Order& order);

 private:
  struct Sources {
    std::shared_ptr<BlobSource> assets;
    std::shared_ptr<BlobSource> snapshots;
  };

  absl::StatusOr<Sources> sources() SINEW_EXCLUDES(mu_);
  absl::StatusOr<Blob> Fetch(BlobSource& source, const std::string& sha256);
  // Assets are large and stay: where they can be, they are shared.
  absl::StatusOr<SharedBytes> FetchShared(BlobSource& source,
                                          const v1::Asset& asset);
  void CountFetch(std::chrono::steady_clock::time_point since);
  absl::StatusOr<Engine::AssetsPtr> LoadAssets(const std::string& sha256);
  absl::StatusOr<Engine::SnapshotPtr> LoadSnapshot(
      const v1::Order& order, const Engine::Assets& assets);

  Engine& engine_;
  ActorMetrics& metrics_;
  LatestResults<Engine::Assets> assets_{2};
  // Under lag 1, evaluation included, three versions are in use.
  LatestResults<Engine::Snapshot> snapshots_{4};
  Mutex mu_;
  Sources sources_ SINEW_GUARDED_BY(mu_);
};

}  // namespace sinew::actor

#endif  // SINEW_ACTOR_SERVICE_ORDER_INPUTS_H_
