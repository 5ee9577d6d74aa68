#ifndef SINEW_SIM_WORLD_TRACKING_TASK_H_
#define SINEW_SIM_WORLD_TRACKING_TASK_H_

#include <mujoco/mujoco.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "common/random/philox.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"
#include "sim/world/action.h"
#include "sim/world/actuation.h"
#include "sim/world/body_state.h"
#include "sim/world/episode.h"
#include "sim/world/fallen_states.h"
#include "sim/world/model_variant.h"
#include "sim/world/nearest_frame.h"
#include "sim/world/observation.h"
#include "sim/world/randomisation.h"
#include "sim/world/recovery.h"
#include "sim/world/start.h"

namespace sinew::world {

// Which clock belongs to what (control step t -> t+1):
//   reference "current" at state s_t is frame start_frame + step (minus the
//   steps in which it stood: episode.h);
//   the observation at s_t shows frames current + frames_ahead (1 = next);
//   the target of step t is placed around frame current + 1;
//   reward and termination compare s_{t+1} with frame current + 1.
// A step while recovery steps are left does not move the current frame.

// Outcome of one control step. All numbers are finite; after a divergence they
// are zero.
struct StepResult {
  float reward = 0;
  float reward_terms[4] = {0, 0, 0, 0};  // unweighted kernels: position,
                                         // rotation, linear, angular velocity
  float mean_body_distance = 0;          // metres, over tracked bodies
  float power = 0;                       // watts, mean over the step
  bool terminated = false;               // failed, or diverged
  bool truncated = false;                // time limit or clip end
  bool clip_end = false;                 // of truncated: by the clip
  bool diverged = false;                 // physics became unusable
};

// The result of a step whose physics is unusable.
inline StepResult DivergedStep() {
  StepResult result;
  result.terminated = true;
  result.diverged = true;
  return result;
}

// Motion tracking of a library by a character: observation, action law,
// reward, termination and starts, as pure functions of an mjData that holds a
// physics row, an Episode and the reference. Holds no state of its own.
//
// One episode:
//
//   Episode e = ...;  // clip and frame from a StartTable
//   BodyStart start = task.DrawStart(key);
//   task.Begin(start, &noise_key, data, &e, previous_target, work);
//   loop:
//     task.Observe(data, e, previous_target, observation, work);
//     task.Target(data, e, action, target, work);
//     StepResult r = task.Step(data, target, &e, previous_target, work);
//
// Reset and Step leave the state of the data in work->body, where Observe wants
// it; a data into which a physics row was put needs Refresh before Observe
// (Target and Step need nothing). Of the data they read the physics row alone.
//
// Thread-safety: immutable; scratch is per thread in Workspace. Ownership:
// borrows character and library, which must outlive it. Blocking: never; the
// per-step methods neither allocate nor lock nor log. Errors: Create names the
// field that does not fit (rates, joints, bodies, feet, digests).
class TrackingTask {
 public:
  // Per-thread scratch; which fields mean something when is said at the
  // methods. Made by MakeWorkspace.
  struct Workspace {
    BodyState body;       // of the last Reset, Refresh or Step
    BodyState reference;  // what Step or CarryOn compared `body` with
    // Frames ahead of the last observation.
    std::vector<BodyState> ahead;
    std::vector<std::unique_ptr<motion::ReferenceFrame>> ahead_frames;
    std::vector<const float*> ahead_contact;
    std::unique_ptr<motion::ReferenceFrame> frame;
    std::vector<float> self_contact, noise;
    std::vector<float> no_contact;  // [F] zeros
    // Where the recipe randomises: the body as its encoders have it, and the
    // model with its masses.
    BodyState sensed;
    std::unique_ptr<ModelVariant> variant;
    std::vector<double> joint_position;
    std::vector<float> posture;  // of NearestFrames
  };

  // `recipe` has its defaults filled (common/config/recipe.h). `fallen` are of
  // this character and outlive the task; without any, none can be started in.
  static absl::StatusOr<std::unique_ptr<TrackingTask>> Create(
      const v1::Recipe& recipe, const character::Character& character,
      const motion::Library& library, const FallenStates* fallen = nullptr);

  std::unique_ptr<Workspace> MakeWorkspace() const;

  int observation_width() const { return observation_.width(); }
  // Columns that the observation begins with and that need no reference.
  int self_observation_width() const { return observation_.self_width(); }
  int action_width() const { return reader_.num_joints(); }
  int substeps() const { return actuation_.substeps(); }
  // Doubles of a physics row (mjSTATE_INTEGRATION).
  int state_size() const { return static_cast<int>(fresh_row_.size()); }
  const character::Character& character() const { return *character_; }
  const motion::Library& library() const { return *library_; }
  const v1::Recipe& recipe() const { return recipe_; }
  const ActionLaw& action_law() const { return action_; }
  const Actuation& actuation() const { return actuation_; }
  const RecoveryLaw& recovery() const { return recovery_; }
  const Randomisation& randomisation() const { return randomisation_; }
  int num_fallen_states() const {
    return fallen_ == nullptr ? 0 : fallen_->size();
  }
  // Frames of the library's get-ups (get_up_frames.h) that fallen bodies are
  // put onto; 0 without fallen states.
  int num_get_up_frames() const { return static_cast<int>(get_ups_.size()); }
  // Column names of the observation, for reports and golden tests.
  std::vector<std::string> ObservationNames() const;
  const ObservationBuilder& observation() const { return observation_; }

  // Sets data to the reference pose of the episode's start, previous target to
  // what action.h says; warm start, time and applied forces cleared. `noise`,
  // if given, keys the recipe's start noise; under conditions a previous target
  // that is where the joints are is where their encoders say.
  void Reset(const Episode& episode, const RandomKey* noise, mjData* data,
             absl::Span<double> previous_target, Workspace* work,
             const Conditions* conditions = nullptr) const;

  // How the body begins an episode: on the reference unless the recipe has
  // recovery. Precondition: there are fallen states and get-ups if it draws
  // them.
  BodyStart DrawStart(const RandomKey& key) const;

  // Reset, then what `start` says; sets the episode's recovery fields. A fallen
  // body lies below the reference's root, its previous target where its joints
  // are; a far one has the reference's pose and velocities, turned, elsewhere.
  // A get-up has a fallen body, moved over the floor and turned by yaw onto the
  // nearest frame of a get-up, which becomes the episode's clip and start.
  // Precondition: start.fallen_state < num_fallen_states() if it is fallen or a
  // get-up, and num_get_up_frames() > 0 for a get-up.
  void Begin(const BodyStart& start, const RandomKey* noise, mjData* data,
             Episode* episode, absl::Span<double> previous_target,
             Workspace* work, const Conditions* conditions = nullptr) const;

  // Begins an episode with the body as it is: moves it over the floor, turned
  // by yaw, onto the frame that is nearest to it, which becomes the episode's
  // start; root and heading are then that frame's. Clock and previous target
  // go on. False where nothing is near: there is no such frame, or the body
  // would be farther than `max_distance` (m) off it, on the mean or at a
  // terminating body; the data may have moved then, and nothing but Begin may
  // follow. Leaves work->body and work->reference. `frames` are of this task's
  // library and character; of the episode, number and clock (step and
  // frozen_steps, which are equal) may be set.
  bool CarryOn(const NearestFrames& frames, double max_distance, mjData* data,
               Episode* episode, Workspace* work) const;

  // Of an environment, for DrawConditions.
  Conditions MakeConditions() const { return randomisation_.MakeConditions(); }

  // What an episode has of its own, by (seed, environment, episode) of the key.
  // Begin, Observe, Target and Step of the episode take it; null: the nominal
  // body. Does nothing unless the recipe randomises; does not allocate but the
  // first time for these conditions.
  void DrawConditions(const RandomKey& key, Conditions* conditions,
                      Workspace* work) const;

  // Works out work->body from qpos and qvel.
  void Refresh(mjData* data, Workspace* work) const;

  // [observation_width] float32 of the state in work->body, which is that of
  // data; not normalised. May place data's geoms (foot_contact.h).
  void Observe(mjData* data, const Episode& episode,
               absl::Span<const double> previous_target, absl::Span<float> out,
               Workspace* work, const Conditions* conditions = nullptr) const;

  // Target of this control step, [J] rad, from the policy's action [J].
  void Target(const mjData* data, const Episode& episode,
              absl::Span<const float> action, absl::Span<double> target,
              Workspace* work, const Conditions* conditions = nullptr) const;

  // The same from an action of the teacher, by its law. Precondition: the
  // recipe has distillation.
  void TeacherTarget(const mjData* data, const Episode& episode,
                     absl::Span<const float> action, absl::Span<double> target,
                     Workspace* work,
                     const Conditions* conditions = nullptr) const;

  // What Target and TeacherTarget of this control step add to scaled actions
  // before they limit the sum, [J] rad each. Precondition: as above.
  void Bases(const mjData* data, const Episode& episode,
             absl::Span<double> base, absl::Span<double> teacher_base,
             Workspace* work, const Conditions* conditions = nullptr) const;

  // One control step under `target`: physics, reward, termination;
  // advances the episode (step + 1, sums) and copies target into
  // previous_target. Never resets. Is Finish after Simulate.
  StepResult Step(mjData* data, absl::Span<const double> target,
                  Episode* episode, absl::Span<double> previous_target,
                  Workspace* work,
                  const Conditions* conditions = nullptr) const;

  // The physics half of Step alone: what needs no reference.
  ActuationResult Simulate(mjData* data, absl::Span<const double> target,
                           absl::Span<double> previous_target) const;
  // The same under conditions (null: as above), at the episode's state.
  ActuationResult Simulate(mjData* data, const Episode& episode,
                           absl::Span<const double> target,
                           absl::Span<double> previous_target,
                           const Conditions* conditions, Workspace* work) const;

  // The other half: compares the state with the frame after the episode's
  // current one, advances the episode. Leaves work->body and work->reference.
  StepResult Finish(mjData* data, const ActuationResult& physics,
                    Episode* episode, Workspace* work) const;

 private:
  TrackingTask(const v1::Recipe& recipe, const character::Character& character,
               const motion::Library& library, const FallenStates* fallen,
               ObservationBuilder observation, Actuation actuation,
               Randomisation randomisation);
  // Moves the body in work->body over the floor and by yaw onto a frame, which
  // becomes the episode's clip and start; leaves work->body and
  // work->reference.
  void MoveOnto(const StartFrame& frame, mjData* data, Episode* episode,
                Workspace* work) const;
  void BeginGetUp(mjData* data, Episode* episode, Workspace* work) const;
  void Place(const BodyStart& start, const Conditions* conditions, mjData* data,
             absl::Span<double> previous_target) const;
  // Whether the reference's root is too far from the body's to be seen.
  bool IsFar(const mjData* data, const motion::FrameView& reference) const;
  StepResult Judge(double power, Episode* episode, Workspace* work) const;
  // The frame that targets are placed around, null if it is out of sight;
  // leaves the joints as the encoders have them in work->joint_position.
  const motion::FrameView* SeeNext(const mjData* data, const Episode& episode,
                                   Workspace* work,
                                   const Conditions* conditions) const;
  // As the encoders have them under these conditions (null: the truth).
  void ReadJoints(const mjData* data, const Conditions* conditions,
                  absl::Span<double> out) const;
  void AddNoise(const RandomKey& key, mjData* data, Workspace* work) const;

  v1::Recipe recipe_;
  const character::Character* character_;
  const motion::Library* library_;
  const FallenStates* fallen_;  // may be null
  BodyReader reader_;
  ObservationBuilder observation_;
  ActionLaw action_;
  ActionLaw teacher_action_;  // unused without distillation
  Actuation actuation_;
  RecoveryLaw recovery_;
  Randomisation randomisation_;
  NearestFrames get_ups_;
  std::vector<double> fresh_row_;  // physics row of a new mjData
};

// The pose of a row: root and joints to qpos and qvel (MuJoCo's free joint
// wants its angular velocity in the body's frame). Other fields stay.
void SetReferencePose(const character::Character& character,
                      const motion::FrameView& frame, mjData* data);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_TRACKING_TASK_H_
