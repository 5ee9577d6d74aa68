#include "actor/service/rollout_engine.h"

#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "actor/prepared_snapshot.h"
#include "actor/rollout.h"
#include "actor/rollout_assets.h"
#include "common/status_macros.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::actor {
namespace {

struct RealAssets : Engine::Assets {
  std::shared_ptr<const RolloutAssets> assets;
};

struct RealSnapshot : Engine::Snapshot {
  std::shared_ptr<const PreparedSnapshot> snapshot;
};

class RealWorker : public Engine::Worker {
 public:
  explicit RealWorker(std::unique_ptr<RolloutWorker> worker)
      : worker_(std::move(worker)) {}

  absl::StatusOr<v1::Segment> Run(const v1::Order& order,
                                  const Engine::Snapshot& snapshot,
                                  const std::atomic<bool>& cancel) override {
    return worker_->Run(
        order, *static_cast<const RealSnapshot&>(snapshot).snapshot, &cancel);
  }

 private:
  const std::unique_ptr<RolloutWorker> worker_;
};

}  // namespace

absl::StatusOr<Engine::AssetsPtr> RolloutEngine::LoadAssets(
    const std::map<std::string, SharedBytes>& by_role) {
  for (const char* role :
       {"character", "model", "library", "frames", "recipe"}) {
    if (by_role.contains(role)) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "assets: expected one of role \"", role, "\", found none"));
  }
  const auto bytes = [&](const char* role) { return by_role.at(role).view(); };
  const std::shared_ptr<const MappedFile>& file = by_role.at("frames").file;
  RolloutAssets::Frames frames = bytes("frames");
  if (file != nullptr) frames = file;
  auto assets = std::make_shared<RealAssets>();
  SINEW_ASSIGN_OR_RETURN(
      assets->assets,
      RolloutAssets::Create(
          bytes("character"), bytes("model"), bytes("library"), frames,
          bytes("recipe"),
          by_role.contains("fallen") ? bytes("fallen") : absl::string_view()));
  return assets;
}

absl::StatusOr<Engine::SnapshotPtr> RolloutEngine::LoadSnapshot(
    const std::string& bytes, const std::string& sha256, const Assets& assets) {
  v1::Snapshot message;
  if (!message.ParseFromString(bytes)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "snapshot ", sha256, ": ", bytes.size(), " bytes that do not parse"));
  }
  auto snapshot = std::make_shared<RealSnapshot>();
  SINEW_ASSIGN_OR_RETURN(
      snapshot->snapshot,
      PreparedSnapshot::Create(message, sha256,
                               *static_cast<const RealAssets&>(assets).assets));
  return snapshot;
}

absl::StatusOr<std::unique_ptr<Engine::Worker>> RolloutEngine::MakeWorker(
    AssetsPtr assets, int max_environments) {
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<RolloutWorker> worker,
      RolloutWorker::Create(static_cast<const RealAssets&>(*assets).assets,
                            max_environments));
  return std::make_unique<RealWorker>(std::move(worker));
}

}  // namespace sinew::actor
