#include "deploy/runtime/runtime.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "common/policy/ports.h"
#include "common/status_macros.h"
#include "deploy/bundle/latent_graphs.h"
#include "deploy/runtime/root_estimate.h"
#include "sim/motion/library.h"
#include "sim/world/actuation.h"
#include "sim/world/foot_contact.h"

namespace sinew::runtime {
namespace {

int Count(size_t size) { return static_cast<int>(size); }

}  // namespace

absl::StatusOr<std::unique_ptr<Runtime>> Runtime::Open(
    const std::string& bundle_directory) {
  SINEW_ASSIGN_OR_RETURN(bundle::Bundle bundle,
                         bundle::ReadBundle(bundle_directory));
  const character::Character& character = *bundle.character;
  SINEW_ASSIGN_OR_RETURN(
      world::ObservationBuilder observation,
      world::ObservationBuilder::Create(bundle.manifest.observation(),
                                        Count(character.tracked().size()),
                                        Count(character.joints().size()),
                                        Count(character.foot_bodies().size())));
  // Simulation (simulation.h) relies on it.
  const v1::Recipe recipe = bundle::TaskRecipe(bundle.manifest);
  SINEW_RETURN_IF_ERROR(world::Actuation::Create(recipe.task().actuator_model(),
                                                 character,
                                                 /*substeps=*/1, /*ramp=*/false)
                            .status());
  auto runtime =
      absl::WrapUnique(new Runtime(std::move(bundle), std::move(observation)));
  SINEW_RETURN_IF_ERROR(runtime->Bind());
  return runtime;
}

Runtime::Runtime(bundle::Bundle bundle, world::ObservationBuilder observation)
    : bundle_(std::move(bundle)),
      builder_(std::move(observation)),
      self_builder_(builder_.SelfPart()),
      reader_(character()),
      law_(bundle::TaskRecipe(bundle_.manifest).task().action(),
           character().joints()),
      data_(mj_makeData(character().model())),
      body_(reader_.num_bodies(), reader_.num_joints()),
      self_contact_(character().foot_bodies().size()),
      previous_target_(reader_.num_joints()),
      shown_target_(reader_.num_joints()),
      new_target_(reader_.num_joints()) {
  const v1::Recipe recipe = bundle::TaskRecipe(bundle_.manifest);
  recovery_ = world::RecoveryLaw(recipe.task().recovery());
  feed_ = std::make_unique<ReferenceFeed>(character(), recipe,
                                          builder_.frames_ahead());
  state_needs_.joints = reader_.num_joints();
  state_needs_.feet = Count(self_contact_.size());
  reference_needs_ = state_needs_;
  reference_needs_.root = true;
  reference_needs_.contact =
      builder_.Has(v1::Observation::BLOCK_REFERENCE_CONTACT);
  reference_needs_.torque = recipe.task().action().torque_feedforward();
}

absl::Status Runtime::Bind() {
  SINEW_ASSIGN_OR_RETURN(
      const auto pack,
      policy::PackWeights(bundle_.graph, "policy", bundle_.weights));
  SINEW_ASSIGN_OR_RETURN(executor_, policy::Executor::Create(pack, 1));
  SINEW_ASSIGN_OR_RETURN(const policy::Ports ports,
                         policy::FindPorts(bundle_.graph, "policy"));
  observation_ = executor_->input(executor_->input_index(ports.observation));
  observation_ = observation_.first(builder_.width());
  action_tap_ = executor_->tap_index(ports.action);
  if (!bundle::HasLatent(bundle_)) return absl::OkStatus();
  SINEW_ASSIGN_OR_RETURN(latent_, LatentNetworks::Create(bundle_));
  self_observation_.resize(self_builder_.width());
  latent_input_.resize(latent_->width());
  return absl::OkStatus();
}

int Runtime::num_joints() const { return reader_.num_joints(); }

absl::Span<const float> Runtime::action() const {
  return executor_->tap(action_tap_).first(previous_target_.size());
}

absl::Status Runtime::LoadLibrary(const std::string& directory) {
  SINEW_RETURN_IF_ERROR(feed_->LoadLibrary(directory));
  is_reset_ = false;
  return absl::OkStatus();
}

absl::Status Runtime::Play(absl::string_view clip, double seconds,
                           Align align) {
  SINEW_RETURN_IF_ERROR(feed_->Play(clip, seconds, align));
  is_reset_ = false;
  return absl::OkStatus();
}

absl::StatusOr<double> Runtime::PlayNearest(const Pose& state, Among among,
                                            int stand) {
  SINEW_RETURN_IF_ERROR(CheckPose(state, state_needs_, "state"));
  if (stand < 0 || stand > kMostStand) {
    return absl::InvalidArgumentError(absl::StrCat(
        "stand: expected 0 to ", kMostStand, " steps, found ", stand));
  }
  PlaceBody(state);
  return feed_->PlayNearest(body_, among, stand);
}

int Runtime::get_up_steps() const {
  const v1::Recovery& recovery = bundle_.manifest.task().recovery();
  return recovery.get_up_share() > 0 ? recovery.get_up_steps() : 0;
}

absl::string_view Runtime::clip_name() const {
  if (!feed_->playing()) return "";
  return library()->clip(feed_->clip()).name();
}

double Runtime::clip_seconds() const {
  if (!feed_->playing()) return 0;
  return static_cast<double>(feed_->frame()) / control_hz();
}

absl::Status Runtime::ReadReference(int ahead, PoseBuffer* out) {
  if (!feed_->playing()) {
    return absl::FailedPreconditionError("reference: expected a clip to play");
  }
  if (ahead < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("ahead: expected >= 0, found ", ahead));
  }
  feed_->ReadPlayed(ahead, out);
  return absl::OkStatus();
}

absl::Status Runtime::Reset(const Pose& state, const Pose* reference) {
  SINEW_RETURN_IF_ERROR(CheckPose(state, state_needs_, "state"));
  if (reference == nullptr && !feed_->playing() && latent_ == nullptr) {
    return absl::FailedPreconditionError(
        "reset: expected a clip to play or a reference frame, found neither");
  }
  const absl::Span<const double> q(state.joint_position,
                                   previous_target_.size());
  const absl::Span<double> target = absl::MakeSpan(previous_target_);
  if (reference != nullptr) {
    SINEW_RETURN_IF_ERROR(CheckPose(*reference, reference_needs_, "reference"));
    law_.InitialTarget(q, feed_->RowOf(*reference), target);
  } else if (!feed_->playing()) {
    // The law of a bundle with a latent looks at no frame.
    law_.InitialTarget(q, motion::FrameView(), target);
  } else {
    if (feed_->aligns()) {
      feed_->AlignTo(state.root_position, state.root_rotation);
    }
    if (feed_->is_nearest()) {
      std::copy(q.begin(), q.end(), target.begin());
    } else {
      law_.InitialTarget(q, feed_->RowOfNow(), target);
    }
  }
  is_reset_ = true;
  return absl::OkStatus();
}

absl::Status Runtime::CheckReset(absl::string_view call,
                                 const Pose& state) const {
  if (!is_reset_) {
    return absl::FailedPreconditionError(
        absl::StrCat(call, ": expected a reset first"));
  }
  return CheckPose(state, state_needs_, "state");
}

absl::Status Runtime::CheckTarget(absl::Span<double> target) const {
  if (target.size() == previous_target_.size()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("target: expected room for ", previous_target_.size(),
                   " joints, found ", target.size()));
}

absl::Status Runtime::CheckFrames(absl::Span<const Pose> frames) const {
  if (frames.size() != feed_->offsets().size()) {
    return absl::InvalidArgumentError(absl::StrCat("frames: expected ",
                                                   feed_->offsets().size(),
                                                   ", found ", frames.size()));
  }
  for (size_t i = 0; i < frames.size(); ++i) {
    // Its name is made where it is needed: nothing else may allocate.
    if (CheckPose(frames[i], reference_needs_, "frames").ok()) continue;
    return CheckPose(frames[i], reference_needs_,
                     absl::StrCat("frames[", i, "]"));
  }
  return absl::OkStatus();
}

absl::Status Runtime::CheckFinite(absl::string_view what,
                                  absl::Span<const float> values) {
  for (const float value : values) {
    if (std::isfinite(value)) continue;
    return absl::InternalError(
        absl::StrCat(what, ": expected finite numbers, found ", value));
  }
  return absl::OkStatus();
}

absl::Status Runtime::CheckObserved(absl::Span<const float> observation) {
  for (size_t i = 0; i < observation.size(); ++i) {
    if (std::isfinite(observation[i])) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("observation[", i, "] of this state and reference: ",
                     "expected a finite float32, found ", observation[i]));
  }
  return absl::OkStatus();
}

absl::Status Runtime::Step(const Pose& state, absl::Span<double> target) {
  SINEW_RETURN_IF_ERROR(CheckReset("step", state));
  SINEW_RETURN_IF_ERROR(CheckTarget(target));
  if (!feed_->playing()) {
    return absl::FailedPreconditionError("step: expected a clip to play");
  }
  feed_->LoadPlayed();
  SINEW_RETURN_IF_ERROR(Act(state, target));
  feed_->Advance();
  return absl::OkStatus();
}

absl::Status Runtime::StepTo(const Pose& state, absl::Span<const Pose> frames,
                             absl::Span<double> target) {
  SINEW_RETURN_IF_ERROR(CheckReset("step", state));
  SINEW_RETURN_IF_ERROR(CheckTarget(target));
  SINEW_RETURN_IF_ERROR(CheckFrames(frames));
  feed_->LoadGiven(frames);
  return Act(state, target);
}

// The body's state into data_ and body_, with what an IMU cannot give.
void Runtime::PlaceBody(const Pose& state) {
  SetPose(character(), state, data_.get());
  double* position = data_->qpos + character().root_qpos_address();
  double* velocity = data_->qvel + character().root_dof_address();
  if (state.root_position == nullptr || state.root_linear_velocity == nullptr) {
    std::fill_n(velocity, 3, 0.0);
    const RootEstimate estimate = EstimateRoot(character(), data_.get());
    const double guess[3] = {plane_.x(), plane_.y(), estimate.height};
    std::copy_n(state.root_position == nullptr ? guess : state.root_position, 3,
                position);
    std::copy_n(state.root_linear_velocity == nullptr
                    ? estimate.linear_velocity.data()
                    : state.root_linear_velocity,
                3, velocity);
  }
  reader_.Read(data_.get(), &body_);
}

void Runtime::ReadBody(const Pose& state,
                       const world::ObservationBuilder& builder) {
  PlaceBody(state);
  if (builder.Has(v1::Observation::BLOCK_SELF_CONTACT)) {
    world::ReadFootContacts(character(), data_.get(),
                            absl::MakeSpan(self_contact_));
  }
  std::copy_n(state.previous_target == nullptr ? previous_target_.data()
                                               : state.previous_target,
              shown_target_.size(), shown_target_.begin());
}

absl::Status Runtime::Observe(const Pose& state) {
  plane_ = feed_->RootNow();
  ReadBody(state, builder_);
  is_out_of_sight_ = recovery_.on() && feed_->Hide(recovery_, body_);
  builder_.Build({.body = &body_,
                  .reference = feed_->observed(),
                  .reference_contact = feed_->observed_contact(),
                  .previous_target = shown_target_,
                  .self_contact = self_contact_},
                 observation_);
  return CheckObserved(observation_);
}

absl::Status Runtime::Act(const Pose& state, absl::Span<double> target) {
  SINEW_RETURN_IF_ERROR(Observe(state));
  executor_->Run(1);
  SINEW_RETURN_IF_ERROR(CheckFinite("action", action()));
  law_.Target(body_.joint_position, is_out_of_sight_ ? nullptr : &feed_->next(),
              action(), absl::MakeSpan(new_target_));
  TakeTarget(target);
  return absl::OkStatus();
}

void Runtime::TakeTarget(absl::Span<double> target) {
  previous_target_.swap(new_target_);
  std::copy(previous_target_.begin(), previous_target_.end(), target.begin());
}

}  // namespace sinew::runtime
