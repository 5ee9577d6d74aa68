#include "deploy/runtime/simulation.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"

namespace sinew::runtime {
namespace {

// The torque law that the policy was trained with.
world::Actuation MakeActuation(const Runtime& policy) {
  const v1::BundleManifest& manifest = policy.bundle().manifest;
  auto actuation = world::Actuation::Create(
      bundle::TaskRecipe(manifest).task().actuator_model(), policy.character(),
      world::Substeps(manifest.physics()), manifest.action().ramp());
  // A runtime has refused what does not fit.
  SINEW_CHECK(actuation.ok()) << actuation.status().ToString();
  return *std::move(actuation);
}

}  // namespace

Simulation::Simulation(const Runtime& policy)
    : character_(policy.character()),
      actuation_(MakeActuation(policy)),
      data_(mj_makeData(character_.model())),
      pose_(policy.num_joints()),
      previous_target_(policy.num_joints()),
      target_(policy.num_joints()) {
  pose_.Read(character_, *data_);
}

absl::Status Simulation::Start(Runtime& policy) {
  SINEW_RETURN_IF_ERROR(policy.ReadReference(/*ahead=*/0, &pose_));
  mj_resetData(character_.model(), data_.get());
  SetPose(character_, pose_.pose(), data_.get());
  pose_.Read(character_, *data_);
  SINEW_RETURN_IF_ERROR(policy.Reset(pose_.pose(), /*reference=*/nullptr));
  previous_target_.assign(policy.previous_target().begin(),
                          policy.previous_target().end());
  return absl::OkStatus();
}

void Simulation::Place(absl::Span<const double> qpos) {
  SINEW_CHECK(qpos.size() == static_cast<size_t>(character_.model()->nq));
  mj_resetData(character_.model(), data_.get());
  std::copy(qpos.begin(), qpos.end(), data_->qpos);
  pose_.Read(character_, *data_);
  std::copy_n(pose_.pose().joint_position, previous_target_.size(),
              previous_target_.begin());
}

absl::Status Simulation::Step() {
  const world::ActuationResult result =
      actuation_.Run(previous_target_, target_, data_.get());
  previous_target_ = target_;
  if (result.diverged) {
    return absl::InternalError(
        absl::StrCat("simulation diverged at ", data_->time, " s"));
  }
  pose_.Read(character_, *data_);
  return absl::OkStatus();
}

}  // namespace sinew::runtime
