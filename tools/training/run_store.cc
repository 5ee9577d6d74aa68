#include "tools/training/run_store.h"

#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/digest.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/state/state_store.h"

namespace sinew::tools {
namespace {

constexpr char kBest[] = "best";
constexpr char kSnapshot[] = "snapshot";
constexpr char kEvaluated[] = "evaluated.pb";

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
  record.set_id(absl::StrCat("assets-", setup.assets_sha256.substr(0, 16)));
  record.set_kind("assets");
  checkpoint::ArtifactFiles files = setup.assets;
  files["assets.pb"] = setup.list;
  return PutFiles(*store_, record, files);
}

absl::StatusOr<bool> RunStore::HasState() {
  SINEW_ASSIGN_OR_RETURN(const v1::ListArtifactsResponse list,
                         store_->ListArtifacts("state"));
  return list.artifacts_size() > 0;
}

absl::StatusOr<learner::Trainer::State> RunStore::LoadState(
    std::vector<std::string>* warnings) {
  return learner::LoadLatestState(*store_, warnings);
}

absl::Status RunStore::PutBest(const Policy& policy) {
  v1::Artifact record;
  const int64_t iteration = policy.evaluated.iteration();
  record.set_id(absl::StrFormat("policy-%08d", iteration));
  record.set_kind("policy");
  record.set_iteration(iteration);
  const checkpoint::ArtifactFiles files = {
      {kSnapshot, policy.snapshot},
      {kEvaluated, std::make_shared<const std::string>(
                       SerializeDeterministically(policy.evaluated))}};
  const absl::Status put = PutFiles(*store_, record, files);
  // A run that went on from an older state comes here again; only the seconds
  // that it took may differ.
  if (!put.ok() && !absl::IsAlreadyExists(put)) return put;
  SINEW_RETURN_IF_ERROR(store_->SetAlias(kBest, record.id()));
  return store_->Retain("policy", 1);
}

absl::StatusOr<std::optional<RunStore::Policy>> RunStore::GetBest() {
  absl::StatusOr<checkpoint::ArtifactFiles> files = GetFiles(*store_, kBest);
  if (absl::IsNotFound(files.status())) return std::nullopt;
  SINEW_RETURN_IF_ERROR(files.status());
  Policy policy;
  policy.snapshot = (*files)[kSnapshot];
  const Blob evaluated = (*files)[kEvaluated];
  if (policy.snapshot == nullptr || evaluated == nullptr ||
      !policy.evaluated.ParseFromString(*evaluated)) {
    return absl::DataLossError(absl::StrCat(
        "artifact \"", kBest, "\": expected files ", kSnapshot, " and ",
        kEvaluated, ", found ", files->size(), " others"));
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
