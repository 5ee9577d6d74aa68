#include "sim/world/tracking_task.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/status_macros.h"
#include "sim/world/foot_contact.h"
#include "sim/world/get_up_frames.h"
#include "sim/world/reward.h"
#include "sim/world/task_check.h"
#include "sim/world/termination.h"

namespace sinew::world {
namespace {

std::vector<double> FreshRow(const mjModel* model) {
  std::vector<double> row(mj_stateSize(model, mjSTATE_INTEGRATION));
  const character::DataPtr data(mj_makeData(model));
  mj_getState(model, data.get(), row.data(), mjSTATE_INTEGRATION);
  return row;
}

void AddOffsets(const Conditions& conditions, absl::Span<double> position) {
  for (size_t j = 0; j < position.size(); ++j) {
    position[j] += conditions.joint_offset[j];
  }
}

std::string BodyName(const mjModel* model, int body) {
  const char* name = mj_id2name(model, mjOBJ_BODY, body);
  return name == nullptr ? "" : name;
}

}  // namespace

absl::StatusOr<std::unique_ptr<TrackingTask>> TrackingTask::Create(
    const v1::Recipe& recipe, const character::Character& character,
    const motion::Library& library, const FallenStates* fallen) {
  SINEW_RETURN_IF_ERROR(CheckTask(recipe, character, library));
  SINEW_ASSIGN_OR_RETURN(ObservationBuilder observation,
                         ObservationBuilder::Create(
                             recipe.task().observation(),
                             static_cast<int>(character.tracked().size()),
                             static_cast<int>(character.joints().size()),
                             static_cast<int>(character.foot_bodies().size())));
  SINEW_ASSIGN_OR_RETURN(
      Actuation actuation,
      Actuation::Create(recipe.task().actuator_model(), character,
                        Substeps(recipe.physics()),
                        recipe.task().action().ramp()));
  SINEW_ASSIGN_OR_RETURN(Randomisation randomisation,
                         Randomisation::Create(recipe, character));
  return std::unique_ptr<TrackingTask>(new TrackingTask(
      recipe, character, library, fallen, std::move(observation),
      std::move(actuation), std::move(randomisation)));
}

TrackingTask::TrackingTask(const v1::Recipe& recipe,
                           const character::Character& character,
                           const motion::Library& library,
                           const FallenStates* fallen,
                           ObservationBuilder observation, Actuation actuation,
                           Randomisation randomisation)
    : recipe_(recipe),
      character_(&character),
      library_(&library),
      fallen_(fallen),
      reader_(character),
      observation_(std::move(observation)),
      action_(recipe.task().action(), character.joints()),
      teacher_action_(recipe.distillation().teacher_action(),
                      character.joints()),
      actuation_(std::move(actuation)),
      recovery_(recipe.task().recovery()),
      randomisation_(std::move(randomisation)),
      get_ups_(fallen == nullptr
                   ? std::vector<StartFrame>()
                   : GetUpFrames(recipe.task().start(), character, library),
               library, reader_),
      fresh_row_(FreshRow(character.model())) {}

std::unique_ptr<TrackingTask::Workspace> TrackingTask::MakeWorkspace() const {
  auto work = std::make_unique<Workspace>();
  work->body = BodyState(reader_.num_bodies(), reader_.num_joints());
  work->reference = work->body;
  work->ahead.assign(observation_.frames_ahead().size(), work->body);
  for (size_t i = 0; i < work->ahead.size(); ++i) {
    work->ahead_frames.push_back(
        std::make_unique<motion::ReferenceFrame>(*library_));
  }
  work->ahead_contact.resize(work->ahead.size());
  work->frame = std::make_unique<motion::ReferenceFrame>(*library_);
  work->self_contact.resize(character_->foot_bodies().size());
  work->no_contact.resize(work->self_contact.size());
  work->noise.resize(2 * reader_.num_joints());
  work->joint_position.resize(reader_.num_joints());
  work->posture.resize(get_ups_.width());
  if (randomisation_.on()) {
    work->sensed = work->body;
    work->variant = std::make_unique<ModelVariant>(*character_);
  }
  return work;
}

std::vector<std::string> TrackingTask::ObservationNames() const {
  world::ObservationNames names;
  const mjModel* model = character_->model();
  for (const auto& joint : character_->joints()) {
    names.joints.push_back(joint.name);
  }
  for (int column : character_->tracked()) {
    names.bodies.push_back(BodyName(model, column + 1));
  }
  for (int id : character_->foot_bodies()) {
    names.feet.push_back(BodyName(model, id));
  }
  return observation_.Names(names);
}

void TrackingTask::Refresh(mjData* data, Workspace* work) const {
  reader_.Read(data, &work->body);
}

void TrackingTask::ReadJoints(const mjData* data, const Conditions* conditions,
                              absl::Span<double> out) const {
  for (size_t j = 0; j < out.size(); ++j) {
    out[j] = data->qpos[character_->joints()[j].qpos_address];
  }
  if (conditions != nullptr) AddOffsets(*conditions, out);
}

void TrackingTask::Observe(mjData* data, const Episode& episode,
                           absl::Span<const double> previous_target,
                           absl::Span<float> out, Workspace* work,
                           const Conditions* conditions) const {
  const int64_t current = CurrentFrame(episode);
  const BodyState* body = &work->body;
  if (conditions != nullptr) {
    work->sensed = work->body;
    AddOffsets(*conditions, absl::MakeSpan(work->sensed.joint_position));
    body = &work->sensed;
  }
  for (size_t i = 0; i < work->ahead.size(); ++i) {
    work->ahead_frames[i]->Load(episode.clip,
                                current + observation_.frames_ahead()[i]);
    reader_.Read(work->ahead_frames[i]->view(), &work->ahead[i]);
    const bool hidden =
        recovery_.on() && recovery_.Hide(*body, &work->ahead[i]);
    work->ahead_contact[i] = hidden ? work->no_contact.data()
                                    : work->ahead_frames[i]->view().contact;
  }
  if (observation_.Has(v1::Observation::BLOCK_SELF_CONTACT)) {
    ReadFootContacts(*character_, data, absl::MakeSpan(work->self_contact));
  }
  observation_.Build({.body = body,
                      .reference = work->ahead,
                      .reference_contact = work->ahead_contact,
                      .previous_target = previous_target,
                      .self_contact = work->self_contact},
                     out);
}

void TrackingTask::Target(const mjData* data, const Episode& episode,
                          absl::Span<const float> action,
                          absl::Span<double> target, Workspace* work,
                          const Conditions* conditions) const {
  const motion::FrameView* next = SeeNext(data, episode, work, conditions);
  action_.Target(work->joint_position, next, action, target);
}

void TrackingTask::TeacherTarget(const mjData* data, const Episode& episode,
                                 absl::Span<const float> action,
                                 absl::Span<double> target, Workspace* work,
                                 const Conditions* conditions) const {
  const motion::FrameView* next = SeeNext(data, episode, work, conditions);
  teacher_action_.Target(work->joint_position, next, action, target);
}

void TrackingTask::Bases(const mjData* data, const Episode& episode,
                         absl::Span<double> base,
                         absl::Span<double> teacher_base, Workspace* work,
                         const Conditions* conditions) const {
  const motion::FrameView* next = SeeNext(data, episode, work, conditions);
  action_.Base(work->joint_position, next, base);
  teacher_action_.Base(work->joint_position, next, teacher_base);
}

const motion::FrameView* TrackingTask::SeeNext(
    const mjData* data, const Episode& episode, Workspace* work,
    const Conditions* conditions) const {
  work->frame->Load(episode.clip, CurrentFrame(episode) + 1);
  ReadJoints(data, conditions, absl::MakeSpan(work->joint_position));
  const motion::FrameView& next = work->frame->view();
  return recovery_.on() && IsFar(data, next) ? nullptr : &next;
}

bool TrackingTask::IsFar(const mjData* data,
                         const motion::FrameView& reference) const {
  const double* root = data->qpos + character_->root_qpos_address();
  const double between[3] = {reference.root_position[0] - root[0],
                             reference.root_position[1] - root[1],
                             reference.root_position[2] - root[2]};
  return recovery_.IsFar(mju_norm3(between));
}

ActuationResult TrackingTask::Simulate(
    mjData* data, absl::Span<const double> target,
    absl::Span<double> previous_target) const {
  const ActuationResult result = actuation_.Run(previous_target, target, data);
  std::copy(target.begin(), target.end(), previous_target.begin());
  return result;
}

ActuationResult TrackingTask::Simulate(mjData* data, const Episode& episode,
                                       absl::Span<const double> target,
                                       absl::Span<double> previous_target,
                                       const Conditions* conditions,
                                       Workspace* work) const {
  if (conditions == nullptr) return Simulate(data, target, previous_target);
  const Push push = randomisation_.PushAt(*conditions, episode.step);
  double* force = data->xfrc_applied + 6 * push.body;
  if (push.body > 0) std::copy_n(push.force, 3, force);
  const ActuationResult result =
      actuation_.Run(previous_target, target,
                     {.model = work->variant->Use(*conditions),
                      .joint_offset = conditions->joint_offset,
                      .gain_scale = conditions->gain_scale},
                     data);
  if (push.body > 0) std::fill_n(force, 3, 0.0);
  std::copy(target.begin(), target.end(), previous_target.begin());
  return result;
}

StepResult TrackingTask::Step(mjData* data, absl::Span<const double> target,
                              Episode* episode,
                              absl::Span<double> previous_target,
                              Workspace* work,
                              const Conditions* conditions) const {
  return Finish(
      data, Simulate(data, *episode, target, previous_target, conditions, work),
      episode, work);
}

StepResult TrackingTask::Finish(mjData* data, const ActuationResult& physics,
                                Episode* episode, Workspace* work) const {
  ++episode->step;
  if (physics.diverged) return DivergedStep();
  work->frame->Load(episode->clip, CurrentFrame(*episode));
  reader_.Read(work->frame->view(), &work->reference);
  Refresh(data, work);
  return Judge(physics.power, episode, work);
}

StepResult TrackingTask::Judge(double power, Episode* episode,
                               Workspace* work) const {
  const v1::Task& task = recipe_.task();
  RewardValue reward =
      ComputeReward(task.reward(), work->body, work->reference, power);
  if (recovery_.on()) {
    const double distance = GoalDistance(work->body, work->reference);
    reward.total +=
        recovery_.Reward(reward.tracking, episode->goal_distance, distance) -
        reward.tracking;
    episode->goal_distance = distance;
  }
  const BodyDistances distances =
      MeasureDistances(work->body, work->reference, character_->terminating());
  EpisodeEnding ending;
  if (episode->recovery_steps_left > 0) {
    --episode->recovery_steps_left;
    ++episode->frozen_steps;
  } else {
    ending = JudgeEpisode(
        distances.max_terminating, task.termination().max_body_distance(),
        episode->start_frame, episode->step - episode->frozen_steps,
        motion::LastFrame(library_->clip(episode->clip)),
        task.max_episode_steps());
  }
  StepResult result;
  result.reward = static_cast<float>(reward.total);
  for (int i = 0; i < 4; ++i) {
    result.reward_terms[i] = static_cast<float>(reward.terms[i]);
  }
  result.mean_body_distance = static_cast<float>(distances.mean);
  result.power = static_cast<float>(power);
  result.terminated = ending.terminated;
  result.truncated = ending.clip_end || ending.time_limit;
  result.clip_end = ending.clip_end;
  episode->episode_return += reward.total;
  episode->episode_error += distances.mean;
  return result;
}

}  // namespace sinew::world
