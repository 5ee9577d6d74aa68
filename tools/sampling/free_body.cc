#include "tools/sampling/free_body.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/check.h"
#include "common/config/recipe.h"
#include "common/status_macros.h"
#include "sim/world/foot_contact.h"

namespace sinew::sampling {
namespace {

// The body's own blocks, which the observation begins with.
absl::StatusOr<world::ObservationBuilder> OwnBlocks(
    const bundle::Bundle& bundle, const v1::Recipe& recipe, int64_t width) {
  const character::Character& character = *bundle.character;
  SINEW_ASSIGN_OR_RETURN(const world::ObservationBuilder all,
                         world::ObservationBuilder::Create(
                             recipe.task().observation(),
                             static_cast<int>(character.tracked().size()),
                             static_cast<int>(character.joints().size()),
                             static_cast<int>(character.foot_bodies().size())));
  if (all.self_width() == width) return all.SelfPart();
  return absl::InvalidArgumentError(absl::StrCat(
      bundle.directory, ": graph \"sample\": expected an input of the ",
      "observation's first blocks, the body's own (", all.self_width(),
      "), found width ", width));
}

}  // namespace

absl::StatusOr<std::shared_ptr<const BodyLaw>> BodyLaw::Create(
    const bundle::Bundle& bundle, int64_t self_width) {
  v1::Recipe recipe = bundle::TaskRecipe(bundle.manifest);
  const v1::Action& action = recipe.task().action();
  if (!IsBlindPlacement(action.placement())) {
    return absl::InvalidArgumentError(absl::StrCat(
        bundle.directory, ": action.placement: expected AROUND_CURRENT or ",
        "ABSOLUTE, which need no reference, found ",
        v1::Action::Placement_Name(action.placement())));
  }
  SINEW_ASSIGN_OR_RETURN(world::ObservationBuilder self,
                         OwnBlocks(bundle, recipe, self_width));
  SINEW_ASSIGN_OR_RETURN(world::Actuation actuation,
                         world::Actuation::Create(
                             recipe.task().actuator_model(), *bundle.character,
                             world::Substeps(recipe.physics()), action.ramp()));
  return std::shared_ptr<const BodyLaw>(new BodyLaw(
      bundle, std::move(recipe), std::move(self), std::move(actuation)));
}

BodyLaw::BodyLaw(const bundle::Bundle& bundle, v1::Recipe recipe,
                 world::ObservationBuilder self, world::Actuation actuation)
    : character_(bundle.character),
      recipe_(std::move(recipe)),
      reader_(*character_),
      action_(recipe_.task().action(), character_->joints()),
      actuation_(std::move(actuation)),
      self_(std::move(self)) {
  FindSoles();
  MeasureStanding();
}

void BodyLaw::FindSoles() {
  const std::vector<int>& feet = character_->foot_bodies();
  for (const import::GroundPoint& point : import::MakeGroundPoints(
           *character_->model(), character_->floor_geom())) {
    const auto foot = std::find(feet.begin(), feet.end(), point.body);
    if (foot == feet.end()) continue;
    soles_.push_back(point);
    foot_of_sole_.push_back(static_cast<int>(foot - feet.begin()));
  }
}

void BodyLaw::MeasureStanding() {
  const mjModel* model = character_->model();
  if (character_->head_body() > 0) upright_body_ = character_->head_body();
  const character::DataPtr data(mj_makeData(model));
  for (const character::JointInfo& joint : character_->joints()) {
    data->qpos[joint.qpos_address] = joint.default_position;
  }
  data->qpos[character_->root_qpos_address() + 2] =
      character_->proto().standing_root_height();
  mj_kinematics(model, data.get());
  standing_height_ = data->xpos[3 * upright_body_ + 2];
}

FreeBody::FreeBody(std::shared_ptr<const BodyLaw> law)
    : law_(std::move(law)),
      data_(mj_makeData(law_->character().model())),
      state_(law_->num_bodies(), law_->num_joints()),
      previous_target_(law_->num_joints()),
      target_(law_->num_joints()),
      contact_(law_->character().foot_bodies().size()),
      sole_points_(law_->soles().size()) {}

void FreeBody::Start(absl::Span<const double> qpos,
                     absl::Span<const double> qvel) {
  const mjModel* model = law_->character().model();
  SINEW_CHECK(qpos.size() == static_cast<size_t>(model->nq) &&
              qvel.size() == static_cast<size_t>(model->nv));
  mj_resetData(model, data_.get());
  std::copy(qpos.begin(), qpos.end(), data_->qpos);
  std::copy(qvel.begin(), qvel.end(), data_->qvel);
  law_->reader().Read(data_.get(), &state_);
  previous_target_ = state_.joint_position;
  placed_ = false;
}

void FreeBody::Observe(absl::Span<float> out) {
  if (law_->self().Has(v1::Observation::BLOCK_SELF_CONTACT)) {
    world::ReadFootContacts(law_->character(), data_.get(),
                            absl::MakeSpan(contact_));
  }
  law_->self().Build({.body = &state_,
                      .reference = {},
                      .reference_contact = {},
                      .previous_target = previous_target_,
                      .self_contact = contact_},
                     out);
}

bool FreeBody::Step(absl::Span<const float> action) {
  // Without a reference around which a target could be placed, in sight or
  // out of it is the same.
  law_->action().Target(state_.joint_position, /*next=*/nullptr, action,
                        absl::MakeSpan(target_));
  placed_ = false;
  if (law_->actuation().Run(previous_target_, target_, data_.get()).diverged) {
    return false;
  }
  previous_target_ = target_;
  law_->reader().Read(data_.get(), &state_);
  return true;
}

absl::Span<const double> FreeBody::qpos() const {
  return {data_->qpos, static_cast<size_t>(law_->character().model()->nq)};
}

void FreeBody::Place() {
  if (placed_) return;
  mj_kinematics(law_->character().model(), data_.get());
  placed_ = true;
}

absl::Span<const Eigen::Vector3d> FreeBody::SolePoints() {
  Place();
  for (size_t i = 0; i < sole_points_.size(); ++i) {
    const import::GroundPoint& sole = law_->soles()[i];
    const double* position = data_->xpos + 3 * sole.body;
    double turned[3];
    mju_rotVecQuat(turned, sole.position.data(), data_->xquat + 4 * sole.body);
    for (int axis = 0; axis < 3; ++axis) {
      sole_points_[i][axis] = position[axis] + turned[axis];
    }
    sole_points_[i].z() -= sole.radius;
  }
  return sole_points_;
}

double FreeBody::UprightHeight() {
  Place();
  return data_->xpos[3 * law_->upright_body() + 2];
}

}  // namespace sinew::sampling
