#include "deploy/runtime/reference_feed.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/check.h"
#include "common/status_macros.h"
#include "sim/motion/rotation.h"
#include "sim/world/get_up_frames.h"
#include "sim/world/task_check.h"
#include "sim/world/termination.h"

namespace sinew::runtime {
namespace {

// Far beyond any clip, yet safe to count on from.
constexpr double kMaxSeconds = 1e9;

bool NeedsNext(const v1::Action& action) {
  return action.placement() == v1::Action::PLACEMENT_UNSPECIFIED ||
         action.placement() == v1::Action::PLACEMENT_AROUND_NEXT_REFERENCE;
}

void CopyOrZero(const double* from, std::vector<float>& to) {
  for (size_t i = 0; i < to.size(); ++i) {
    to[i] = from == nullptr ? 0.F : static_cast<float>(from[i]);
  }
}

absl::StatusOr<int64_t> FrameAt(double seconds, double rate) {
  if (!(seconds >= 0) || seconds > kMaxSeconds) {
    return absl::InvalidArgumentError(
        absl::StrCat("seconds: expected >= 0, found ", seconds));
  }
  return static_cast<int64_t>(std::llround(seconds * rate));
}

}  // namespace

ReferenceFeed::ReferenceFeed(const character::Character& character,
                             const v1::Recipe& recipe,
                             absl::Span<const int> frames_ahead)
    : character_(character),
      reader_(character),
      control_hz_(recipe.physics().control_hz()),
      offsets_(frames_ahead.begin(), frames_ahead.end()),
      data_(mj_makeData(character.model())) {
  const world::BodyState state(reader_.num_bodies(), reader_.num_joints());
  observed_.assign(offsets_.size(), state);
  reference_ = state;
  auto next = std::find(offsets_.begin(), offsets_.end(), 1);
  if (next == offsets_.end() && NeedsNext(recipe.task().action())) {
    next = offsets_.insert(next, 1);
  }
  if (next != offsets_.end()) next_ = next - offsets_.begin();
  const auto joints = static_cast<size_t>(reader_.num_joints());
  numbers_.assign(
      offsets_.size(),
      {.joint_position = std::vector<float>(joints),
       .joint_velocity = std::vector<float>(joints),
       .torque = std::vector<float>(joints),
       .contact = std::vector<float>(character.foot_bodies().size())});
  views_.resize(offsets_.size());
  contact_.resize(observed_.size());
  no_contact_.resize(character.foot_bodies().size());
}

absl::Status ReferenceFeed::LoadLibrary(const std::string& directory) {
  SINEW_ASSIGN_OR_RETURN(auto library, motion::Library::Load(directory));
  SINEW_RETURN_IF_ERROR(library->Verify());
  v1::Recipe recipe;
  recipe.mutable_physics()->set_control_hz(control_hz_);
  recipe.mutable_physics()->set_physics_hz(1 /
                                           character_.model()->opt.timestep);
  SINEW_RETURN_IF_ERROR(world::CheckTask(recipe, character_, *library));
  clip_ = -1;
  for (auto& frames : nearest_) frames = nullptr;
  rows_.clear();
  library_ = std::move(library);
  for (size_t i = 0; i < offsets_.size(); ++i) {
    rows_.push_back(std::make_unique<motion::ReferenceFrame>(*library_));
  }
  row_of_now_ = std::make_unique<motion::ReferenceFrame>(*library_);
  return absl::OkStatus();
}

absl::Status ReferenceFeed::Play(absl::string_view clip, double seconds,
                                 Align align) {
  if (library_ == nullptr) {
    return absl::FailedPreconditionError(
        "play: expected a motion library to be loaded first");
  }
  const int found = library_->FindClip(clip);
  if (found < 0) {
    std::vector<std::string> names;
    for (const v1::ClipInfo& info : library_->manifest().clips()) {
      names.push_back(info.name());
    }
    return absl::NotFoundError(absl::StrCat("clip: expected one of ",
                                            absl::StrJoin(names, ", "),
                                            ", found \"", clip, "\""));
  }
  SINEW_ASSIGN_OR_RETURN(const int64_t frame, FrameAt(seconds, control_hz_));
  clip_ = found;
  frame_ = std::min(frame, motion::LastFrame(library_->clip(clip_)));
  stand_ = 0;
  turn_ = Eigen::Quaterniond::Identity();
  move_ = Eigen::Vector3d::Zero();
  is_moved_ = false;
  align_ = align;
  is_nearest_ = false;
  return absl::OkStatus();
}

const world::NearestFrames& ReferenceFeed::Frames(Among among) {
  auto& frames = nearest_[static_cast<size_t>(among)];
  if (frames != nullptr) return *frames;
  const v1::Start all;
  switch (among) {
    case Among::kAll:
      frames =
          std::make_unique<const world::NearestFrames>(all, *library_, reader_);
      break;
    case Among::kGetUps:
      frames = std::make_unique<const world::NearestFrames>(
          world::GetUpFrames(all, character_, *library_), *library_, reader_);
      break;
    case Among::kUpright:
      frames = std::make_unique<const world::NearestFrames>(
          world::UprightFrames(all, character_, *library_), *library_, reader_);
      break;
  }
  posture_.resize(frames->width());
  return *frames;
}

absl::StatusOr<double> ReferenceFeed::PlayNearest(const world::BodyState& body,
                                                  Among among, int stand) {
  if (library_ == nullptr) {
    return absl::FailedPreconditionError(
        "play nearest: expected a motion library to be loaded first");
  }
  const auto nearest = Frames(among).Find(body, absl::MakeSpan(posture_));
  if (!nearest.has_value()) {
    constexpr const char* kNames[] = {
        "a clip that goes on for half a second",
        "a get-up, a clip from the floor to standing,",
        "a clip that stays upright for a second"};
    return absl::NotFoundError(
        absl::StrCat("play nearest: expected the library to have ",
                     kNames[static_cast<size_t>(among)],
                     " and is not left out, found none"));
  }
  clip_ = nearest->clip;
  frame_ = nearest->frame;
  stand_ = stand;
  align_ = Align::kNone;
  is_nearest_ = true;
  double root[4];
  motion::ToWxyz(body.rotation[0], root);
  AlignTo(body.position[0].data(), root);
  reader_.Read(RowOfNow(), &reference_);
  Transform(&reference_);
  return world::MeasureDistances(body, reference_, character_.terminating())
      .mean;
}

absl::Status ReferenceFeed::Seek(double seconds) {
  if (!playing()) {
    return absl::FailedPreconditionError("seek: expected a clip to play");
  }
  SINEW_ASSIGN_OR_RETURN(const int64_t frame, FrameAt(seconds, control_hz_));
  frame_ = std::min(frame, motion::LastFrame(library_->clip(clip_)));
  stand_ = 0;
  return absl::OkStatus();
}

bool ReferenceFeed::is_over() const {
  return playing() && frame_ >= motion::LastFrame(library_->clip(clip_));
}

const motion::FrameView& ReferenceFeed::RowOfNow() {
  SINEW_CHECK(playing());
  row_of_now_->Load(clip_, frame_);
  return row_of_now_->view();
}

void ReferenceFeed::AlignTo(const double* position,
                            const double* rotation_wxyz) {
  const motion::FrameView& row = RowOfNow();
  const Eigen::Quaterniond body = motion::FromWxyz(rotation_wxyz).normalized();
  turn_ = world::Heading(body) *
          world::Heading(motion::FromWxyz(row.root_rotation)).conjugate();
  const Eigen::Vector3d from(row.root_position[0], row.root_position[1], 0);
  const Eigen::Vector3d to =
      position == nullptr ? from : Eigen::Vector3d(position[0], position[1], 0);
  move_ = to - turn_ * from;
  is_moved_ = true;
}

void ReferenceFeed::Transform(world::BodyState* state) const {
  if (!is_moved_) return;
  for (size_t b = 0; b < state->position.size(); ++b) {
    state->position[b] = turn_ * state->position[b] + move_;
    state->rotation[b] = turn_ * state->rotation[b];
    state->linear_velocity[b] = turn_ * state->linear_velocity[b];
    state->angular_velocity[b] = turn_ * state->angular_velocity[b];
  }
}

void ReferenceFeed::LoadPlayed() {
  SINEW_CHECK(playing());
  for (size_t i = 0; i < offsets_.size(); ++i) {
    rows_[i]->Load(clip_, frame_ + offsets_[i]);
    views_[i] = rows_[i]->view();
    if (i >= observed_.size()) continue;
    reader_.Read(views_[i], &observed_[i]);
    Transform(&observed_[i]);
    contact_[i] = views_[i].contact;
  }
  const float* root = views_[next_].root_position;
  next_root_ = Eigen::Vector3d(root[0], root[1], root[2]);
  if (is_moved_) next_root_ = turn_ * next_root_ + move_;
}

void ReferenceFeed::Copy(const Pose& pose, size_t index) {
  Numbers& numbers = numbers_[index];
  CopyOrZero(pose.joint_position, numbers.joint_position);
  CopyOrZero(pose.joint_velocity, numbers.joint_velocity);
  CopyOrZero(pose.feedforward_torque, numbers.torque);
  CopyOrZero(pose.contact, numbers.contact);
  views_[index] = {};
  views_[index].joint_position = numbers.joint_position.data();
  views_[index].joint_velocity = numbers.joint_velocity.data();
  views_[index].feedforward_torque = numbers.torque.data();
}

const motion::FrameView& ReferenceFeed::RowOf(const Pose& pose) {
  Copy(pose, 0);
  return views_[0];
}

void ReferenceFeed::LoadGiven(absl::Span<const Pose> frames) {
  SINEW_CHECK(frames.size() == offsets_.size());
  for (size_t i = 0; i < offsets_.size(); ++i) {
    Copy(frames[i], i);
    if (i >= observed_.size()) continue;
    SetPose(character_, frames[i], data_.get());
    reader_.Read(data_.get(), &observed_[i]);
    contact_[i] = numbers_[i].contact.data();
  }
  next_root_ = Eigen::Map<const Eigen::Vector3d>(frames[next_].root_position);
}

bool ReferenceFeed::Hide(const world::RecoveryLaw& law,
                         const world::BodyState& body) {
  for (size_t i = 0; i < observed_.size(); ++i) {
    if (law.Hide(body, &observed_[i])) contact_[i] = no_contact_.data();
  }
  return law.IsFar((next_root_ - body.position[0]).norm());
}

Eigen::Vector2d ReferenceFeed::RootNow() const {
  const world::BodyState& first = observed_.front();
  const double seconds = offsets_.front() / control_hz_;
  return (first.position[0] - seconds * first.linear_velocity[0]).head<2>();
}

void ReferenceFeed::ReadPlayed(int ahead, PoseBuffer* out) {
  SINEW_CHECK(playing());
  row_of_now_->Load(clip_, frame_ + ahead);
  out->Read(row_of_now_->view());
  if (is_moved_) out->Move(turn_, move_);
}

}  // namespace sinew::runtime
