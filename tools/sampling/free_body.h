#ifndef SINEW_TOOLS_SAMPLING_FREE_BODY_H_
#define SINEW_TOOLS_SAMPLING_FREE_BODY_H_

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "deploy/bundle/bundle.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/character/model_ptr.h"
#include "sim/import/retarget/ground_points.h"
#include "sim/world/action.h"
#include "sim/world/actuation.h"
#include "sim/world/body_state.h"
#include "sim/world/observation.h"

namespace sinew::sampling {

// What the bodies of a bundle share when no reference leads them: the blocks
// of the observation that are the body's own state, and the laws of action and
// torque, as in training. No library is needed.
//
// Thread-safety: immutable. Ownership: shares the bundle's character. Blocking:
// never. Errors: Create names bundle, field, expected and found: a law of
// action that needs a reference, leading blocks that are not of this width.
class BodyLaw {
 public:
  // `self_width` S: columns that the networks see.
  static absl::StatusOr<std::shared_ptr<const BodyLaw>> Create(
      const bundle::Bundle& bundle, int64_t self_width);

  const character::Character& character() const { return *character_; }
  const v1::Recipe& recipe() const { return recipe_; }
  double control_hz() const { return recipe_.physics().control_hz(); }
  int num_joints() const { return reader_.num_joints(); }
  int num_bodies() const { return reader_.num_bodies(); }

  const world::BodyReader& reader() const { return reader_; }
  const world::ActionLaw& action() const { return action_; }
  const world::Actuation& actuation() const { return actuation_; }
  // [S] the leading blocks.
  const world::ObservationBuilder& self() const { return self_; }
  // Whose points count as soles, and the foot of each.
  const std::vector<import::GroundPoint>& soles() const { return soles_; }
  const std::vector<int>& foot_of_sole() const { return foot_of_sole_; }

  // Model body whose height says what is upright: the head, or the root where
  // the character names none; and its height in the default pose, standing, m.
  int upright_body() const { return upright_body_; }
  double standing_height() const { return standing_height_; }

 private:
  BodyLaw(const bundle::Bundle& bundle, v1::Recipe recipe,
          world::ObservationBuilder self, world::Actuation actuation);
  void FindSoles();
  void MeasureStanding();

  const std::shared_ptr<const character::Character> character_;
  const v1::Recipe recipe_;
  const world::BodyReader reader_;
  const world::ActionLaw action_;
  const world::Actuation actuation_;
  const world::ObservationBuilder self_;
  std::vector<import::GroundPoint> soles_;
  std::vector<int> foot_of_sole_;
  int upright_body_ = 1;
  double standing_height_ = 0;
};

// One body in MuJoCo, moved by actions alone:
//
//   FreeBody body(law);
//   body.Start(qpos, qvel);
//   each control step:
//     body.Observe(observation);
//     if (!body.Step(action)) break;   // diverged
//
// Thread-safety: one caller. Ownership: shares the law. Blocking: Step steps
// the physics (~0.1 ms); nothing allocates after construction. Errors: none.
class FreeBody {
 public:
  explicit FreeBody(std::shared_ptr<const BodyLaw> law);

  // [nq], [nv]; the previous target is where the joints are.
  void Start(absl::Span<const double> qpos, absl::Span<const double> qvel);

  // [S] float32 of the state; may use data's scratch memory.
  void Observe(absl::Span<float> out);

  // One control step under an action [J]. False: the simulation has diverged,
  // and nothing but Start may follow.
  bool Step(absl::Span<const float> action);

  const BodyLaw& law() const { return *law_; }
  const world::BodyState& state() const { return state_; }
  absl::Span<const double> qpos() const;
  // [soles] their lowest points, m, world. Valid until the next call.
  absl::Span<const Eigen::Vector3d> SolePoints();
  // Of the body whose height says what is upright, m.
  double UprightHeight();

 private:
  // Places bodies in data for the position, once per state.
  void Place();

  const std::shared_ptr<const BodyLaw> law_;
  const character::DataPtr data_;
  world::BodyState state_;
  std::vector<double> previous_target_, target_;
  std::vector<float> contact_;
  std::vector<Eigen::Vector3d> sole_points_;
  bool placed_ = false;
};

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_FREE_BODY_H_
