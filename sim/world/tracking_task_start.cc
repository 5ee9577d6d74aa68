// How episodes of a tracking task begin.

#include <algorithm>
#include <cstdint>
#include <optional>

#include "common/check.h"
#include "sim/motion/rotation.h"
#include "sim/world/termination.h"
#include "sim/world/tracking_task.h"

namespace sinew::world {

void SetReferencePose(const character::Character& character,
                      const motion::FrameView& frame, mjData* data) {
  double* qpos = data->qpos + character.root_qpos_address();
  double* qvel = data->qvel + character.root_dof_address();
  const Eigen::Quaterniond rotation =
      motion::FromWxyz(frame.root_rotation).normalized();
  const Eigen::Vector3d world_rate(frame.root_angular_velocity[0],
                                   frame.root_angular_velocity[1],
                                   frame.root_angular_velocity[2]);
  const Eigen::Vector3d local_rate = rotation.conjugate() * world_rate;
  for (int i = 0; i < 3; ++i) {
    qpos[i] = frame.root_position[i];
    qvel[i] = frame.root_linear_velocity[i];
    qvel[3 + i] = local_rate[i];
  }
  motion::ToWxyz(rotation, qpos + 3);
  for (size_t j = 0; j < character.joints().size(); ++j) {
    const character::JointInfo& joint = character.joints()[j];
    data->qpos[joint.qpos_address] = frame.joint_position[j];
    data->qvel[joint.dof_address] = frame.joint_velocity[j];
  }
}

namespace {

// Puts a root over a place on the floor, turned about the vertical.
void PlaceRoot(const character::Character& character, double x, double y,
               const Eigen::Quaterniond& turn, mjData* data) {
  double* root = data->qpos + character.root_qpos_address();
  double* rate = data->qvel + character.root_dof_address();
  root[0] = x;
  root[1] = y;
  motion::ToWxyz(turn * motion::FromWxyz(root + 3), root + 3);
  // The angular velocity is the body's own: it turns with it.
  const Eigen::Vector3d velocity =
      turn * Eigen::Vector3d(rate[0], rate[1], rate[2]);
  for (int i = 0; i < 3; ++i) rate[i] = velocity[i];
}

}  // namespace

void TrackingTask::AddNoise(const RandomKey& key, mjData* data,
                            Workspace* work) const {
  const double position = recipe_.task().start().joint_position_noise();
  const double velocity = recipe_.task().start().joint_velocity_noise();
  if (position == 0 && velocity == 0) return;
  FillNormal(key, absl::MakeSpan(work->noise));
  const int joints = reader_.num_joints();
  for (int j = 0; j < joints; ++j) {
    const character::JointInfo& joint = character_->joints()[j];
    data->qpos[joint.qpos_address] += position * work->noise[j];
    data->qvel[joint.dof_address] += velocity * work->noise[joints + j];
  }
}

void TrackingTask::Reset(const Episode& episode, const RandomKey* noise,
                         mjData* data, absl::Span<double> previous_target,
                         Workspace* work, const Conditions* conditions) const {
  work->frame->Load(episode.clip, episode.start_frame);
  mj_setState(character_->model(), data, fresh_row_.data(),
              mjSTATE_INTEGRATION);
  SetReferencePose(*character_, work->frame->view(), data);
  if (noise != nullptr) AddNoise(*noise, data, work);
  ReadJoints(data, conditions, absl::MakeSpan(work->joint_position));
  action_.InitialTarget(work->joint_position, work->frame->view(),
                        previous_target);
  Refresh(data, work);
}

BodyStart TrackingTask::DrawStart(const RandomKey& key) const {
  return recovery_.on() ? recovery_.Draw(key, num_fallen_states())
                        : BodyStart();
}

void TrackingTask::Begin(const BodyStart& start, const RandomKey* noise,
                         mjData* data, Episode* episode,
                         absl::Span<double> previous_target, Workspace* work,
                         const Conditions* conditions) const {
  episode->start_kind = start.kind;
  episode->recovery_steps_left = start.recovery_steps;
  Reset(*episode, noise, data, previous_target, work, conditions);
  if (start.kind != v1::START_KIND_REFERENCE) {
    Place(start, conditions, data, previous_target);
    Refresh(data, work);
  }
  if (start.kind == v1::START_KIND_GET_UP) BeginGetUp(data, episode, work);
  if (!recovery_.on()) return;
  // What stands is the frame that the next step is compared with.
  work->frame->Load(episode->clip, int64_t{episode->start_frame} +
                                       (start.recovery_steps > 0 ? 1 : 0));
  reader_.Read(work->frame->view(), &work->reference);
  episode->goal_distance = GoalDistance(work->body, work->reference);
}

void TrackingTask::BeginGetUp(mjData* data, Episode* episode,
                              Workspace* work) const {
  const std::optional<StartFrame> nearest =
      get_ups_.Find(work->body, absl::MakeSpan(work->posture));
  SINEW_CHECK(nearest.has_value()) << "a get-up without a body or a frame";
  MoveOnto(*nearest, data, episode, work);
}

void TrackingTask::Place(const BodyStart& start, const Conditions* conditions,
                         mjData* data,
                         absl::Span<double> previous_target) const {
  const double* root = data->qpos + character_->root_qpos_address();
  const double x = root[0] + start.offset_x, y = root[1] + start.offset_y;
  if (start.kind != v1::START_KIND_FAR) {
    const absl::Span<const double> qpos = fallen_->qpos(start.fallen_state);
    std::copy(qpos.begin(), qpos.end(), data->qpos);
    std::fill_n(data->qvel, character_->model()->nv, 0.0);
    ReadJoints(data, conditions, previous_target);
  }
  PlaceRoot(*character_, x, y,
            Eigen::Quaterniond(
                Eigen::AngleAxisd(start.turn, Eigen::Vector3d::UnitZ())),
            data);
}

void TrackingTask::MoveOnto(const StartFrame& frame, mjData* data,
                            Episode* episode, Workspace* work) const {
  work->frame->Load(frame.clip, frame.frame);
  reader_.Read(work->frame->view(), &work->reference);
  const Eigen::Vector3d& root = work->reference.position[0];
  PlaceRoot(*character_, root.x(), root.y(),
            Heading(work->reference.rotation[0]) *
                Heading(work->body.rotation[0]).conjugate(),
            data);
  // Of accelerations in the world that it has no more.
  std::fill_n(data->qacc_warmstart, character_->model()->nv, 0.0);
  Refresh(data, work);
  episode->clip = frame.clip;
  episode->start_frame = frame.frame;
}

bool TrackingTask::CarryOn(const NearestFrames& frames, double max_distance,
                           mjData* data, Episode* episode,
                           Workspace* work) const {
  Refresh(data, work);
  const std::optional<StartFrame> nearest =
      frames.Find(work->body, absl::MakeSpan(work->posture));
  if (!nearest.has_value()) return false;
  const Episode before = *episode;
  MoveOnto(*nearest, data, episode, work);
  const BodyDistances distances =
      MeasureDistances(work->body, work->reference, character_->terminating());
  if (!(distances.max_terminating <= max_distance &&
        distances.mean <= max_distance)) {
    *episode = before;
    return false;
  }
  episode->start_kind = v1::START_KIND_CARRIED;
  if (recovery_.on()) {
    episode->goal_distance = GoalDistance(work->body, work->reference);
  }
  return true;
}

void TrackingTask::DrawConditions(const RandomKey& key, Conditions* conditions,
                                  Workspace* work) const {
  if (!randomisation_.on()) return;
  randomisation_.Draw(key, conditions);
  work->variant->Compute(conditions);
}

}  // namespace sinew::world
