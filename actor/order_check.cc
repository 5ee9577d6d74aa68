#include "actor/order_check.h"

#include "absl/strings/str_cat.h"
#include "common/config/recipe.h"
#include "common/policy/latent_graphs.h"
#include "common/policy/teacher_graph.h"
#include "common/segment/segment_layout.h"
#include "common/segment/state_limits.h"
#include "common/status_macros.h"
#include "sim/world/tracking_task.h"

namespace sinew::actor {
namespace {

// Most steps of an evaluation on a get-up, whichever it will be.
constexpr int32_t kMostGetUpSteps = 1 << 16;

template <typename Expected, typename Found>
absl::Status Error(const v1::Order& order, absl::string_view field,
                   const Expected& expected, const Found& found) {
  return absl::InvalidArgumentError(
      absl::StrCat("order ", order.order_id(), " field ", field, ": expected ",
                   expected, ", found ", found));
}

// That there is what acts in a share of a distillation's episodes.
absl::Status CheckActs(const v1::Order& order, double share,
                       absl::string_view field, const ActingGraph* graph,
                       absl::string_view name) {
  if (share == 0 || graph != nullptr) return absl::OkStatus();
  return Error(
      order, "snapshot_sha256",
      absl::StrCat("a snapshot with a graph \"", name,
                   "\", since recipe field distillation.", field, " is not 0"),
      "none");
}

// What a recipe needs of snapshot and assets.
absl::Status CheckNeeds(const v1::Order& order,
                        const PreparedSnapshot& snapshot,
                        const world::TrackingTask& task) {
  const v1::Recovery& recovery = task.recipe().task().recovery();
  if (FallenShare(recovery) > 0 && task.num_fallen_states() == 0) {
    return Error(order, "assets_sha256",
                 absl::StrCat("assets of role \"fallen\", since recipe field "
                              "task.recovery.",
                              recovery.fallen_share() > 0 ? "fallen" : "get_up",
                              "_share is not 0"),
                 "none");
  }
  if (recovery.get_up_share() > 0 && task.num_get_up_frames() == 0) {
    return Error(order, "assets_sha256",
                 "a library with a clip that begins on the floor and ends "
                 "upright, since recipe field task.recovery.get_up_share is "
                 "not 0",
                 "none");
  }
  const v1::Distillation& shares = task.recipe().distillation();
  SINEW_RETURN_IF_ERROR(CheckActs(order, shares.teacher_share(),
                                  "teacher_share", snapshot.teacher(),
                                  policy::kTeacherGraph));
  SINEW_RETURN_IF_ERROR(CheckActs(order, shares.prior_share(), "prior_share",
                                  snapshot.prior(), policy::kSampleGraph));
  const int latent = RecordedLatentWidth(task.recipe());
  const int recorded = snapshot.policy().latent_noise_width;
  if (latent > 0 && recorded != latent) {
    return Error(order, "snapshot_sha256",
                 absl::StrCat("a snapshot whose graph \"policy\" has a tap \"",
                              column::kLatentNoise, "\" of width ", latent,
                              ", since recipe field network.latent is set "
                              "without distillation"),
                 recorded);
  }
  return absl::OkStatus();
}

absl::Status CheckTraining(const v1::Order& order,
                           const PreparedSnapshot& snapshot,
                           const world::TrackingTask& task,
                           int max_environments) {
  if (snapshot.starts().num_frames() == 0) {
    return Error(order, "kind",
                 "KIND_EVALUATE, since all clips of the library are left out "
                 "of training",
                 "KIND_TRAIN");
  }
  SINEW_RETURN_IF_ERROR(CheckNeeds(order, snapshot, task));
  if (order.horizon() < 1) {
    return Error(order, "horizon", ">= 1", order.horizon());
  }
  if (order.states_size() < 1 || order.states_size() > max_environments) {
    return Error(order, "states",
                 absl::StrCat("1 to ", max_environments, " environments"),
                 order.states_size());
  }
  if (order.first_environment() < 0) {
    return Error(order, "first_environment", ">= 0", order.first_environment());
  }
  if (order.starts_size() > 0) {
    return Error(order, "starts", "none in a training order",
                 order.starts_size());
  }
  return absl::OkStatus();
}

absl::Status CheckFallen(const v1::Order& order, const std::string& field,
                         const v1::EvaluationStart& start, int fallen_states) {
  if (!start.has_fallen_state()) {
    if (start.get_up()) {
      return Error(order, field + ".get_up", "false without fallen_state",
                   "true");
    }
    return start.recovery_steps() == 0
               ? absl::OkStatus()
               : Error(order, field + ".recovery_steps",
                       "none without fallen_state", start.recovery_steps());
  }
  if (start.fallen_state() < 0 || start.fallen_state() >= fallen_states) {
    return Error(order, field + ".fallen_state",
                 absl::StrCat("an index below ", fallen_states,
                              ", the states of asset \"fallen\""),
                 start.fallen_state());
  }
  if (start.recovery_steps() < 0) {
    return Error(order, field + ".recovery_steps", ">= 0",
                 start.recovery_steps());
  }
  return absl::OkStatus();
}

// That there are get-ups for a start that asks for one, and that it names no
// other clip and ends.
absl::Status CheckGetUp(const v1::Order& order, const std::string& field,
                        const v1::EvaluationStart& start,
                        const world::TrackingTask& task) {
  if (task.num_get_up_frames() == 0) {
    return Error(order, field + ".get_up",
                 "false, since no clip of the library begins on the floor and "
                 "ends upright",
                 "true");
  }
  if (start.clip() != 0 || start.start_frame() != 0) {
    return Error(order, field + ".clip", "0 with start_frame 0 beside get_up",
                 absl::StrCat(start.clip(), " with ", start.start_frame()));
  }
  if (start.steps() < 1 || start.steps() > kMostGetUpSteps) {
    return Error(order, field + ".steps",
                 absl::StrCat("1 to ", kMostGetUpSteps), start.steps());
  }
  return absl::OkStatus();
}

absl::Status CheckStart(const v1::Order& order, int index,
                        const RolloutAssets& assets) {
  const world::TrackingTask& task = assets.task();
  const v1::EvaluationStart& start = order.starts(index);
  const std::string field = absl::StrCat("starts[", index, "]");
  const absl::Status place =
      CheckPlace(start.clip(), start.start_frame(), assets.limits());
  if (!place.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "order ", order.order_id(), " field ", field, ".", place.message()));
  }
  const v1::ClipInfo& clip = task.library().clip(start.clip());
  SINEW_RETURN_IF_ERROR(
      CheckFallen(order, field, start, task.num_fallen_states()));
  if (start.get_up()) return CheckGetUp(order, field, start, task);
  const int64_t most =
      motion::LastFrame(clip) - start.start_frame() + start.recovery_steps();
  if (start.steps() < 1 || start.steps() > most) {
    return Error(order, field + ".steps", absl::StrCat("1 to ", most),
                 start.steps());
  }
  return absl::OkStatus();
}

absl::Status CheckEvaluation(const v1::Order& order,
                             const RolloutAssets& assets,
                             int max_environments) {
  if (order.starts_size() < 1 || order.starts_size() > max_environments) {
    return Error(order, "starts", absl::StrCat("1 to ", max_environments),
                 order.starts_size());
  }
  if (order.states_size() > 0) {
    return Error(order, "states", "none in an evaluation order",
                 order.states_size());
  }
  for (int i = 0; i < order.starts_size(); ++i) {
    SINEW_RETURN_IF_ERROR(CheckStart(order, i, assets));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckOrder(const v1::Order& order,
                        const PreparedSnapshot& snapshot,
                        const RolloutAssets& assets, int max_environments) {
  if (order.layout_sha256() != assets.layout_sha256()) {
    return Error(order, "layout_sha256", assets.layout_sha256(),
                 order.layout_sha256());
  }
  if (order.snapshot_version() != snapshot.version()) {
    return Error(order, "snapshot_version", snapshot.version(),
                 order.snapshot_version());
  }
  if (order.snapshot_sha256() != snapshot.sha256()) {
    return Error(order, "snapshot_sha256", snapshot.sha256(),
                 order.snapshot_sha256());
  }
  switch (order.kind()) {
    case v1::Order::KIND_TRAIN:
      return CheckTraining(order, snapshot, assets.task(), max_environments);
    case v1::Order::KIND_EVALUATE:
      return CheckEvaluation(order, assets, max_environments);
    default:
      return Error(order, "kind", "KIND_TRAIN or KIND_EVALUATE",
                   static_cast<int>(order.kind()));
  }
}

}  // namespace sinew::actor
