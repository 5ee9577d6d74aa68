#include "actor/service/order_inputs.h"

#include <chrono>
#include <map>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/status_context.h"
#include "common/status_macros.h"

namespace sinew::actor {

void OrderInputs::SetSources(std::shared_ptr<BlobSource> assets,
                             std::shared_ptr<BlobSource> snapshots) {
  MutexLock lock(mu_);
  sources_ = {std::move(assets), std::move(snapshots)};
}

absl::StatusOr<OrderInputs::Sources> OrderInputs::sources() {
  MutexLock lock(mu_);
  if (sources_.assets == nullptr) {
    return absl::FailedPreconditionError("no peer to fetch from yet");
  }
  return sources_;
}

void OrderInputs::CountFetch(std::chrono::steady_clock::time_point since) {
  metrics_.stage_seconds.Add(
      "fetch",
      std::chrono::duration<double>(std::chrono::steady_clock::now() - since)
          .count());
}

absl::StatusOr<Blob> OrderInputs::Fetch(BlobSource& source,
                                        const std::string& sha256) {
  const auto start = std::chrono::steady_clock::now();
  absl::StatusOr<Blob> blob = source.GetBlob(sha256);
  CountFetch(start);
  return blob;
}

absl::StatusOr<SharedBytes> OrderInputs::FetchShared(BlobSource& source,
                                                     const v1::Asset& asset) {
  const auto start = std::chrono::steady_clock::now();
  absl::StatusOr<SharedBytes> bytes = source.MapBlob(asset.sha256());
  CountFetch(start);
  return bytes;
}

absl::StatusOr<Engine::AssetsPtr> OrderInputs::LoadAssets(
    const std::string& sha256) {
  SINEW_ASSIGN_OR_RETURN(const Sources from, sources());
  SINEW_ASSIGN_OR_RETURN(const Blob list, Fetch(*from.assets, sha256));
  v1::TaskAssets assets;
  if (!assets.ParseFromString(*list)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "assets ", sha256, ": ", list->size(), " bytes that do not parse"));
  }
  std::map<std::string, SharedBytes> by_role;
  for (const v1::Asset& asset : assets.assets()) {
    absl::StatusOr<SharedBytes> bytes = FetchShared(*from.assets, asset);
    if (!bytes.ok()) {
      return WithContext(bytes.status(),
                         absl::StrCat("asset \"", asset.role(), "\""));
    }
    by_role[asset.role()] = *std::move(bytes);
  }
  return engine_.LoadAssets(by_role);
}

absl::StatusOr<Engine::AssetsPtr> OrderInputs::GetAssets(
    const std::string& sha256) {
  return assets_.Get(sha256, [&] { return LoadAssets(sha256); });
}

absl::StatusOr<Engine::SnapshotPtr> OrderInputs::LoadSnapshot(
    const v1::Order& order, const Engine::Assets& assets) {
  SINEW_ASSIGN_OR_RETURN(const Sources from, sources());
  const absl::StatusOr<Blob> blob =
      Fetch(*from.snapshots, order.snapshot_sha256());
  if (!blob.ok()) {
    return WithContext(blob.status(),
                       absl::StrCat("snapshot ", order.snapshot_version()));
  }
  return engine_.LoadSnapshot(**blob, order.snapshot_sha256(), assets);
}

absl::StatusOr<OrderInputs::Inputs> OrderInputs::Get(const v1::Order& order) {
  Inputs inputs;
  SINEW_ASSIGN_OR_RETURN(inputs.assets, GetAssets(order.assets_sha256()));
  SINEW_ASSIGN_OR_RETURN(
      inputs.snapshot,
      snapshots_.Get(
          absl::StrCat(order.snapshot_sha256(), "/", order.assets_sha256()),
          [&] { return LoadSnapshot(order, *inputs.assets); }));
  return inputs;
}

}  // namespace sinew::actor
