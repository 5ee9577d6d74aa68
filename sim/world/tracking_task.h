#ifndef SINEW_SIM_WORLD_TRACKING_TASK_H_
#define SINEW_SIM_WORLD_TRACKING_TASK_H_

#include <mujoco/mujoco.h>

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::world {

// Which clock belongs to what (control step t -> t+1):
//   reference "current" at state s_t is frame start_frame + step;
//   the observation at s_t shows frames current + frames_ahead (1 = next);
//   the target of step t is placed around frame current + 1;
//   reward and termination compare s_{t+1} with frame current + 1.

// One environment's episode, between steps: plain data, mirrors
// v1::EnvironmentState without the physics row.
struct Episode {
  int64_t episode = 0;
  int32_t step = 0;
  int32_t clip = 0;
  int32_t start_frame = 0;
  double episode_return = 0;
  double episode_error = 0;  // sum of mean body distances, m
};

// Outcome of one control step.
struct StepResult {
  float reward = 0;
  float reward_terms[4] = {0, 0, 0, 0};  // unweighted kernels: position,
                                         // rotation, linear, angular velocity
  float mean_body_distance = 0;          // metres, over tracked bodies
  bool terminated = false;               // failed
  bool truncated = false;                // time limit or clip end
  bool clip_end = false;                 // of truncated: by the clip
  bool diverged = false;                 // physics became non-finite
};

// Motion tracking of a library by a character: observation, action law,
// reward, termination and starts, as pure functions of an mjData that holds a
// physics row, an Episode and the reference. Holds no state of its own.
//
// Thread-safety: immutable; scratch is per thread in Workspace. Ownership:
// borrows character and library, which must outlive it. Blocking: never; the
// per-step methods neither allocate nor lock nor log. Errors: Create names the
// field that does not fit (rates, joints, bodies, digests).
class TrackingTask {
 public:
  static absl::StatusOr<std::unique_ptr<TrackingTask>> Create(
      const v1::Recipe& recipe, const character::Character& character,
      const motion::Library& library);

  // Per-thread scratch (reference frames, previous target).
  struct Workspace;
  std::unique_ptr<Workspace, void (*)(Workspace*)> MakeWorkspace() const;

  int observation_width() const;
  int action_width() const;  // = number of joints
  int substeps() const;      // physics steps per control step
  const character::Character& character() const;
  const motion::Library& library() const;
  const v1::Recipe& recipe() const;
  // Column names of the observation, for reports and golden tests.
  std::vector<std::string> ObservationNames() const;

  // Draws the start of episode `episode` of `environment` (clip, frame) from
  // the curriculum; pure in its arguments.
  void DrawStart(uint64_t seed, int environment, int64_t episode,
                 const v1::CurriculumTable& curriculum, Episode* out) const;

  // Sets data to the reference pose of the episode's start (plus start noise),
  // previous target to that pose's base target; warm start cleared.
  void Reset(uint64_t seed, int environment, const Episode& episode,
             mjData* data, absl::Span<double> previous_target,
             Workspace* work) const;

  // Recomputes what observation and reward read (kinematics, com velocities)
  // from qpos and qvel. Call after setting a physics row.
  void Refresh(mjData* data) const;

  // [observation_width] float32 of the refreshed state. Non-normalised.
  void Observe(const mjData* data, const Episode& episode,
               absl::Span<const double> previous_target,
               absl::Span<float> out, Workspace* work) const;

  // Target of this control step, [J] rad, from the policy's action [J].
  void Target(const mjData* data, const Episode& episode,
              absl::Span<const float> action, absl::Span<double> target,
              Workspace* work) const;

  // One control step under `target`: physics substeps with the torque law,
  // refresh, reward, termination; advances the episode (step + 1, sums) and
  // writes target into previous_target. Never resets.
  StepResult Step(mjData* data, absl::Span<const double> target,
                  Episode* episode, absl::Span<double> previous_target,
                  Workspace* work) const;

 private:
  struct Impl;
  explicit TrackingTask(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;

 public:
  ~TrackingTask();
};

// Fills unset fields of a recipe with the defaults of recipe.proto and checks
// ranges: INVALID_ARGUMENT "recipe field task.action.scale: expected > 0,
// found -1". common to all roles: lives in common/config/recipe.h.

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_TRACKING_TASK_H_
