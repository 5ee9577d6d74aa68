#include "tools/training/compact_state.h"

#include <memory>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/blobs/blob_source.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/logging.h"
#include "common/rpc/credentials.h"
#include "common/status_macros.h"
#include "deploy/checkpoint/client/artifact_store.h"
#include "deploy/checkpoint/open_store.h"
#include "learner/state/newest_state.h"
#include "learner/state/state_files.h"
#include "learner/state/state_store.h"
#include "proto/sinew/v1/checkpoint.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::tools {
namespace {

using checkpoint::ArtifactFiles;
using checkpoint::ArtifactStore;
using learner::Trainer;

constexpr char kAssetList[] = "assets.pb";
constexpr char kSourceList[] = "sources.pb";

absl::StatusOr<std::unique_ptr<ArtifactStore>> Open(
    const std::string& folder, checkpoint::StoreAccess access,
    const Clock& clock) {
  return checkpoint::OpenStore(folder, access, rpc::Security(), clock);
}

absl::StatusOr<std::optional<std::vector<v1::RunInputs::Source>>> SourcesFrom(
    const ArtifactFiles& files) {
  const auto list = files.find(kSourceList);
  if (list == files.end()) return std::nullopt;
  v1::RunInputs inputs;
  if (!inputs.ParseFromString(*list->second)) {
    return absl::DataLossError(absl::StrCat(
        "compact state: expected RunInputs in ", kSourceList, ", found ",
        list->second->size(), " bytes of something else"));
  }
  return std::vector<v1::RunInputs::Source>(inputs.sources().begin(),
                                            inputs.sources().end());
}

Blob SerializeSources(absl::Span<const v1::RunInputs::Source> sources) {
  v1::RunInputs inputs;
  inputs.mutable_sources()->Assign(sources.begin(), sources.end());
  return std::make_shared<const std::string>(
      SerializeDeterministically(inputs));
}

absl::StatusOr<CompactState> FromFiles(const ArtifactFiles& files) {
  CompactState compact;
  SINEW_ASSIGN_OR_RETURN(compact.state, learner::StateFromFiles(files));
  const auto list = files.find(kAssetList);
  const std::string& expected = compact.state.counters.assets_sha256();
  v1::TaskAssets assets;
  if (list == files.end() || Sha256Hex(*list->second) != expected ||
      !assets.ParseFromString(*list->second)) {
    return absl::DataLossError(absl::StrCat(
        "compact state: expected a file ", kAssetList, " of SHA-256 ", expected,
        ", found ", list == files.end() ? "none" : Sha256Hex(*list->second)));
  }
  for (const v1::Asset& asset : assets.assets()) {
    compact.assets[asset.role()] = asset.sha256();
  }
  SINEW_ASSIGN_OR_RETURN(compact.sources, SourcesFrom(files));
  return compact;
}

}  // namespace

Trainer::State Compact(const Trainer::State& state) {
  Trainer::State compact;
  compact.counters = state.counters;
  compact.tensors = state.tensors;
  v1::TrainingState& counters = compact.counters;
  counters.clear_open_orders();
  counters.clear_pending_evaluations();
  counters.clear_snapshots();
  // What is forgotten was inserted and learnt from all the same: weights that
  // are annealed, and draws, go on from there.
  if (counters.has_memory()) counters.mutable_memory()->clear_chunks();
  const std::vector<v1::EnvironmentState> next =
      Trainer::NextEpisodes(state.counters);
  counters.mutable_environments()->Assign(next.begin(), next.end());
  return compact;
}

absl::Status WriteCompactState(
    ArtifactStore& from, const std::string& folder, const Clock& clock,
    absl::Span<const v1::RunInputs::Source> sources) {
  if (FileExists(folder)) {
    return absl::AlreadyExistsError(
        absl::StrCat(folder, ": expected no such folder, found one"));
  }
  std::vector<std::string> warnings;
  SINEW_ASSIGN_OR_RETURN(const Trainer::State state,
                         learner::LoadLatestState(from, &warnings));
  for (const std::string& warning : warnings) LogWarning(warning);
  ArtifactFiles files = learner::StateToFiles(Compact(state));
  // The list is a blob by the name of its digest.
  const auto list = from.GetBlob(state.counters.assets_sha256());
  if (!list.ok()) {
    return absl::DataLossError(absl::StrCat(
        "expected the list of the run's assets: ", list.status().message()));
  }
  files[kAssetList] = *list;
  files[kSourceList] = SerializeSources(sources);
  v1::Artifact record;
  record.set_kind(learner::kStateKind);
  record.set_iteration(state.counters.iteration());
  record.set_id(absl::StrFormat("state-%08d", record.iteration()));
  SINEW_ASSIGN_OR_RETURN(const auto to,
                         Open(folder, checkpoint::StoreAccess::kWrite, clock));
  SINEW_RETURN_IF_ERROR(PutFiles(*to, record, files));
  return to->SetAlias(checkpoint::kLatest, record.id());
}

absl::StatusOr<CompactState> ReadCompactState(const std::string& folder,
                                              const Clock& clock) {
  if (!FileExists(folder)) {
    return absl::NotFoundError(absl::StrCat(
        folder,
        ": expected a compact state (sinew export --state), found no "
        "such folder"));
  }
  SINEW_ASSIGN_OR_RETURN(const auto store,
                         Open(folder, checkpoint::StoreAccess::kRead, clock));
  std::vector<std::string> warnings;
  auto compact = learner::LoadNewestState<CompactState>(
      *store,
      [&](const v1::Artifact& artifact) -> absl::StatusOr<CompactState> {
        SINEW_ASSIGN_OR_RETURN(const ArtifactFiles files,
                               GetFiles(*store, artifact.id()));
        return FromFiles(files);
      },
      &warnings);
  if (compact.ok()) return compact;
  return absl::Status(compact.status().code(),
                      absl::StrCat(folder, ": ", compact.status().message()));
}

}  // namespace sinew::tools
