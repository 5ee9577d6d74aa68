#include "tools/training/run_store.h"

#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/digest.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/state/state_store.h"
#include "proto/sinew/v1/checkpoint.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::tools {
namespace {

constexpr char kSnapshot[] = "snapshot";
constexpr char kEvaluated[] = "evaluated.pb";
constexpr char kAssetList[] = "assets.pb";

std::string AssetsId(const std::string& assets_sha256) {
  return absl::StrCat("assets-", assets_sha256.substr(0, 16));
}

}  // namespace

absl::StatusOr<std::unique_ptr<RunStore>> RunStore::Open(
    const std::string& where, const rpc::Security& security,
    const Clock& clock) {
  SINEW_ASSIGN_OR_RETURN(
      std::unique_ptr<checkpoint::ArtifactStore> store,
      checkpoint::OpenStore(where, checkpoint::StoreAccess::kWrite, security,
                            clock));
  return std::unique_ptr<RunStore>(new RunStore(std::move(store)));
}

absl::Status RunStore::PutAssets(const TaskSetup& setup) {
  v1::Artifact record;
  record.set_id(AssetsId(setup.assets_sha256));
  record.set_kind("assets");
  checkpoint::ArtifactFiles files = setup.assets;
  files[kAssetList] = setup.list;
  return PutFiles(*store_, record, files);
}

absl::StatusOr<learner::Trainer::State> RunStore::LoadState(
    std::vector<std::string>* warnings) {
  return learner::LoadLatestState(*store_, warnings);
}

absl::StatusOr<std::vector<std::string>> RunStore::ChangedAssets(
    const std::string& assets_sha256, const TaskSetup& setup) {
  SINEW_ASSIGN_OR_RETURN(const v1::Artifact record,
                         store_->GetArtifact(AssetsId(assets_sha256)));
  std::map<std::string, std::string> before;
  for (const v1::Artifact::File& file : record.files()) {
    if (file.path() != kAssetList) before[file.path()] = file.sha256();
  }
  return ChangedRoles(before, setup);
}

absl::StatusOr<std::vector<std::string>> ChangedRoles(
    const std::map<std::string, std::string>& before, const TaskSetup& setup) {
  v1::TaskAssets now;
  if (!now.ParseFromString(*setup.list)) {
    return absl::InternalError("the list of assets does not parse");
  }
  std::vector<std::string> changed;
  for (const v1::Asset& asset : now.assets()) {
    const auto old = before.find(asset.role());
    if (old == before.end() || old->second != asset.sha256()) {
      changed.push_back(asset.role());
    }
  }
  return changed;
}

absl::Status RunStore::PutBest(const Policy& policy) {
  v1::Artifact record;
  const int64_t iteration = policy.evaluated.iteration();
  // Of this library's run: another may have been at this iteration, too.
  record.set_id(absl::StrFormat("policy-%08d-%s", iteration,
                                policy.evaluated.assets_sha256().substr(0, 8)));
  record.set_kind("policy");
  record.set_iteration(iteration);
  const checkpoint::ArtifactFiles files = {
      {kSnapshot, policy.snapshot},
      {kEvaluated, std::make_shared<const std::string>(
                       SerializeDeterministically(policy.evaluated))}};
  const absl::Status put = PutFiles(*store_, record, files);
  // A run that went on from an older state comes here again, with the same
  // snapshot; only seconds and build may differ, and those of before stay.
  if (!put.ok() && !absl::IsAlreadyExists(put)) return put;
  SINEW_RETURN_IF_ERROR(store_->SetAlias(checkpoint::kBest, record.id()));
  return store_->Retain("policy", 1);
}

absl::StatusOr<std::optional<RunStore::Policy>> RunStore::GetBest() {
  absl::StatusOr<checkpoint::ArtifactFiles> files =
      GetFiles(*store_, checkpoint::kBest);
  if (absl::IsNotFound(files.status())) return std::nullopt;
  SINEW_RETURN_IF_ERROR(files.status());
  Policy policy;
  policy.snapshot = (*files)[kSnapshot];
  const Blob evaluated = (*files)[kEvaluated];
  if (policy.snapshot == nullptr || evaluated == nullptr ||
      !policy.evaluated.ParseFromString(*evaluated)) {
    return absl::DataLossError(absl::StrCat(
        "artifact \"", checkpoint::kBest, "\": expected files ", kSnapshot,
        " and ", kEvaluated, ", found ", files->size(), " others"));
  }
  return policy;
}

bool IsBetter(const v1::EvaluatedPolicy& a, const v1::EvaluatedPolicy& b) {
  const auto rank = [](const v1::EvaluatedPolicy& policy) {
    return std::make_tuple(policy.metrics().succeeded_starts(),
                           policy.survived_share(),
                           -policy.metrics().e_g_mpjpe_mm());
  };
  return rank(a) > rank(b);
}

}  // namespace sinew::tools
