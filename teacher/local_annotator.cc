#include "teacher/local_annotator.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/build_info.h"
#include "common/cpu.h"
#include "common/finite.h"
#include "common/status_macros.h"
#include "teacher/client/rows.h"

namespace sinew::teacher {
namespace {

constexpr char kGraph[] = "policy";
// Rows of a block: enough that weights, which every block reads once, cost
// little beside the products.
constexpr int64_t kBlockRows = 128;
// A small batch goes to all threads in blocks that still fill the kernel's.
constexpr int64_t kLeastBlockRows = 16;

absl::Status CheckWidth(const char* field, int64_t manifest, int64_t graph) {
  if (manifest == graph) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("manifest: ", field, ": expected ", graph,
                   " as graph \"policy\" has, found ", manifest));
}

v1::DescribeTeacherResponse Describe(const v1::BundleManifest& manifest,
                                     const TargetLaw& law) {
  v1::DescribeTeacherResponse description;
  description.set_bundle_sha256(manifest.manifest_sha256());
  description.set_build(BuildIdentity());
  description.set_cpu_class(CpuClass());
  description.set_character_sha256(manifest.character_sha256());
  *description.mutable_action() = law.action();
  *description.mutable_observation() = manifest.observation();
  description.set_observation_width(manifest.observation_width());
  description.set_action_width(manifest.action_width());
  description.set_max_rows(std::numeric_limits<int32_t>::max());
  description.set_control_hz(manifest.control_hz());
  *description.mutable_provenance() = manifest.provenance();
  return description;
}

// The executed tap's standard deviation in radians; 0 where it has none, as a
// student's whose only noise is its latent. The graph is valid.
std::vector<double> Spread(const TeacherPolicy& policy, const v1::Graph& graph,
                           const TargetLaw& law) {
  std::vector<double> spread(policy.manifest.joints_size(), 0.0);
  for (const v1::Tap& tap : graph.taps()) {
    if (!tap.executed() || !tap.has_gaussian()) continue;
    const absl::Span<const float> std =
        policy.weights.at(tap.gaussian().std_parameter()).float32();
    for (size_t j = 0; j < spread.size(); ++j) {
      spread[j] = law.scale(j) * static_cast<double>(std[j]);
    }
  }
  return spread;
}

}  // namespace

absl::StatusOr<std::unique_ptr<LocalAnnotator>> LocalAnnotator::Create(
    const TeacherPolicy& policy, int threads) {
  if (threads < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("threads: expected >= 1, found ", threads));
  }
  return CreateOn(std::make_shared<BlockPool>(threads), policy);
}

absl::StatusOr<std::unique_ptr<LocalAnnotator>> LocalAnnotator::CreateBeside(
    const LocalAnnotator& other, const TeacherPolicy& policy) {
  return CreateOn(other.pool_, policy);
}

absl::StatusOr<std::unique_ptr<LocalAnnotator>> LocalAnnotator::CreateOn(
    std::shared_ptr<BlockPool> pool, const TeacherPolicy& policy) {
  SINEW_RETURN_IF_ERROR(CheckFinite(policy.weights, "weights of the teacher"));
  SINEW_ASSIGN_OR_RETURN(
      const std::shared_ptr<const policy::WeightsPack> pack,
      policy::PackWeights(policy.graph, kGraph, policy.weights));
  SINEW_ASSIGN_OR_RETURN(const policy::Ports ports,
                         policy::FindPorts(policy.graph, kGraph));
  SINEW_ASSIGN_OR_RETURN(const v1::Graph* graph,
                         policy::FindGraph(policy.graph, kGraph));
  SINEW_RETURN_IF_ERROR(CheckWidth("observation_width",
                                   policy.manifest.observation_width(),
                                   ports.observation_width));
  SINEW_RETURN_IF_ERROR(CheckWidth(
      "action_width", policy.manifest.action_width(), ports.action_width));
  SINEW_ASSIGN_OR_RETURN(TargetLaw law, TargetLaw::Create(policy));
  std::vector<Workspace> workspaces;
  for (int i = 0; i < pool->workers(); ++i) {
    SINEW_ASSIGN_OR_RETURN(auto executor,
                           policy::Executor::Create(pack, kBlockRows));
    const int observation = executor->input_index(ports.observation);
    const int action = executor->tap_index(ports.action);
    workspaces.push_back({std::move(executor), observation, action});
  }
  std::vector<double> spread = Spread(policy, *graph, law);
  v1::DescribeTeacherResponse description = Describe(policy.manifest, law);
  return std::unique_ptr<LocalAnnotator>(new LocalAnnotator(
      std::move(law), std::move(description), std::move(spread),
      std::move(workspaces), std::move(pool)));
}

LocalAnnotator::LocalAnnotator(TargetLaw law,
                               v1::DescribeTeacherResponse description,
                               std::vector<double> spread,
                               std::vector<Workspace> workspaces,
                               std::shared_ptr<BlockPool> pool)
    : law_(std::move(law)),
      description_(std::move(description)),
      spread_(std::move(spread)),
      workspaces_(std::move(workspaces)),
      pool_(std::move(pool)) {}

absl::Status LocalAnnotator::Annotate(const Rows& rows,
                                      absl::Span<double> targets) {
  SINEW_ASSIGN_OR_RETURN(const int64_t count,
                         CheckRows(description_, rows, targets));
  const auto threads = static_cast<int64_t>(workspaces_.size());
  const int64_t size =
      std::clamp((count + threads - 1) / threads, kLeastBlockRows, kBlockRows);
  const int64_t blocks = (count + size - 1) / size;
  std::vector<absl::Status> statuses(blocks);
  pool_->Run(blocks, [&](int worker, int64_t block) {
    const int64_t first = block * size;
    statuses[block] = RunRows(workspaces_[worker], rows, first,
                              std::min(size, count - first), targets);
  });
  for (const absl::Status& status : statuses) SINEW_RETURN_IF_ERROR(status);
  return absl::OkStatus();
}

absl::Status LocalAnnotator::RunRows(Workspace& workspace, const Rows& rows,
                                     int64_t first, int64_t count,
                                     absl::Span<double> targets) const {
  const int64_t observation = description_.observation_width();
  const int64_t action = description_.action_width();
  policy::Executor& executor = *workspace.executor;
  std::memcpy(executor.input(workspace.observation).data(),
              rows.observations.data() + first * observation,
              count * observation * sizeof(float));
  executor.Run(static_cast<int>(count));
  const absl::Span<const float> actions =
      executor.tap(workspace.action).first(count * action);
  const absl::Span<double> block =
      targets.subspan(first * action, count * action);
  for (int64_t r = 0; r < count; ++r) {
    law_.Target(rows.bases.subspan((first + r) * action, action),
                actions.subspan(r * action, action),
                block.subspan(r * action, action));
  }
  if (AllFinite32(Bytes(actions)) && AllFinite64(Bytes<double>(block))) {
    return absl::OkStatus();
  }
  int64_t i = 0;
  while (std::isfinite(actions[i]) && std::isfinite(block[i])) ++i;
  return absl::InternalError(absl::StrCat(
      "teacher ", description_.bundle_sha256(), ": row ", first + i / action,
      ", joint ", i % action, ": expected a finite target, found action ",
      actions[i], ", target ", block[i]));
}

}  // namespace sinew::teacher
