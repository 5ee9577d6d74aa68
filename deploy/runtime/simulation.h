#ifndef SINEW_DEPLOY_RUNTIME_SIMULATION_H_
#define SINEW_DEPLOY_RUNTIME_SIMULATION_H_

#include <mujoco/mujoco.h>

#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "deploy/runtime/pose.h"
#include "deploy/runtime/runtime.h"
#include "sim/character/model_ptr.h"
#include "sim/world/actuation.h"

namespace sinew::runtime {

// The body of a bundle in MuJoCo, as in training: a robot to try a policy on.
//
//   Simulation body(*policy);
//   body.Start(*policy);                       // where its clip begins
//   each control step:
//     policy->Step(body.pose(), body.target());
//     body.Step();
//
// Thread-safety: one caller. Ownership: borrows the runtime's model. Blocking:
// Step steps the physics (~0.1 ms); nothing allocates after construction.
// Errors: Step is INTERNAL once the simulation has diverged.
class Simulation {
 public:
  explicit Simulation(const Runtime& policy);

  // Puts the body into the pose of the policy's clip now, resets the policy.
  absl::Status Start(Runtime& policy);

  // Puts the body, at rest, into a pose of the model, [nq]. A policy that is to
  // move it from there wants a reference, then a Reset.
  void Place(absl::Span<const double> qpos);

  // The state; valid until the next call of a method that is not const.
  const Pose& pose() const { return pose_.pose(); }
  // Where the policy's targets go, [J] rad.
  absl::Span<double> target() { return absl::MakeSpan(target_); }

  // One control step under target().
  absl::Status Step();

  const mjData& data() const { return *data_; }

 private:
  const character::Character& character_;
  const world::Actuation actuation_;
  const character::DataPtr data_;
  PoseBuffer pose_;
  std::vector<double> previous_target_, target_;
};

}  // namespace sinew::runtime

#endif  // SINEW_DEPLOY_RUNTIME_SIMULATION_H_
