#include "actor/service/testing/fake_engine.h"

#include <chrono>
#include <limits>
#include <stop_token>
#include <utility>

#include "replay/testing/segments.h"

namespace sinew::actor {

class FakeEngine::FakeWorker : public Engine::Worker {
 public:
  explicit FakeWorker(FakeEngine& engine) : engine_(engine) {}

  absl::StatusOr<v1::Segment> Run(const v1::Order& order,
                                  const Snapshot& /*snapshot*/,
                                  const std::atomic<bool>& cancel) override {
    return engine_.Run(order, cancel);
  }

 private:
  FakeEngine& engine_;
};

absl::StatusOr<Engine::AssetsPtr> FakeEngine::LoadAssets(
    const std::map<std::string, SharedBytes>& by_role) {
  if (!by_role.contains("model")) {
    return absl::InvalidArgumentError("assets: expected a model");
  }
  return std::make_shared<const Assets>();
}

absl::StatusOr<Engine::SnapshotPtr> FakeEngine::LoadSnapshot(
    const std::string& /*bytes*/, const std::string& /*sha256*/,
    const Assets& /*assets*/) {
  ++snapshots_loaded_;
  return std::make_shared<const Snapshot>();
}

absl::StatusOr<std::unique_ptr<Engine::Worker>> FakeEngine::MakeWorker(
    AssetsPtr /*assets*/, int /*max_environments*/) {
  return std::make_unique<FakeWorker>(*this);
}

void FakeEngine::Hold() {
  MutexLock lock(mu_);
  hold_ = true;
}

void FakeEngine::Release() {
  MutexLock lock(mu_);
  hold_ = false;
  changed_.NotifyAll();
}

void FakeEngine::WaitUntilHeld(int count) {
  MutexLock lock(mu_);
  while (held_ < count) changed_.Wait(mu_, std::stop_token());
}

void FakeEngine::Fail(int64_t order_id, absl::Status status) {
  MutexLock lock(mu_);
  failures_[order_id] = std::move(status);
}

void FakeEngine::Spoil(int64_t order_id) {
  MutexLock lock(mu_);
  spoilt_.insert(order_id);
}

absl::StatusOr<v1::Segment> FakeEngine::Run(const v1::Order& order,
                                            const std::atomic<bool>& cancel) {
  MutexLock lock(mu_);
  ++held_;
  changed_.NotifyAll();
  while (hold_ && !cancel) {
    changed_.WaitUntil(
        mu_, std::chrono::steady_clock::now() + std::chrono::milliseconds(1));
  }
  --held_;
  if (cancel) return absl::CancelledError("rollout");
  const auto failure = failures_.find(order.order_id());
  if (failure != failures_.end()) return failure->second;
  v1::Segment segment =
      replay::MakeSegment(order.order_id(), order.iteration());
  segment.set_physics_steps(1);
  if (spoilt_.contains(order.order_id())) {
    segment.mutable_end_states(0)->set_physics(
        0, std::numeric_limits<double>::quiet_NaN());
  }
  return segment;
}

}  // namespace sinew::actor
