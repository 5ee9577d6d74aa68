#ifndef SINEW_SIM_WORLD_OBSERVATION_H_
#define SINEW_SIM_WORLD_OBSERVATION_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/world/body_state.h"

namespace sinew::world {

// What an observation is made of.
struct ObservationInput {
  const BodyState* body = nullptr;
  // [A] reference states, one per frame ahead.
  absl::Span<const BodyState> reference;
  // [A] pointers to F contact labels.
  absl::Span<const float* const> reference_contact;
  absl::Span<const double> previous_target;  // [J] rad
  absl::Span<const float> self_contact;      // [F] 0 or 1
};

// Names for the columns.
struct ObservationNames {
  std::vector<std::string> joints;  // [J]
  std::vector<std::string> bodies;  // [B] tracked, root first
  std::vector<std::string> feet;    // [F]
};

// The policy's observation: the recipe's blocks one after another, float32, not
// normalised. J joints, B tracked bodies, F feet, A frames ahead.
//
// h is the rotation by the body's heading (body_state.h), h^-1 x is x in the
// heading frame of the BODY, also where x belongs to the reference. r is the
// root, hats are the reference. 6D(R) are the first two columns of the matrix:
// R00 R10 R20 R01 R11 R21 (Zhou et al. 2019).
//
// SELF_JOINT_SPACE, 13 + 2 J + 3 (B - 1):
//   root height              1        p_r.z, m
//   root rotation            6        6D(h^-1 R_r)
//   root linear velocity     3        h^-1 v_r, m/s
//   root angular velocity    3        h^-1 w_r, rad/s
//   joint positions          J        q, rad
//   joint velocities         J        dq, rad/s
//   body positions           3 (B-1)  h^-1 (p_b - p_r), m
// REFERENCE_DIFFERENCE, for each frame ahead 15 + 2 J + 3 (B - 1):
//   root position            3        h^-1 (p^_r - p_r)
//   root rotation            6        6D(h^-1 (R^_r R_r^-1) h)
//   root linear velocity     3        h^-1 (v^_r - v_r)
//   root angular velocity    3        h^-1 (w^_r - w_r)
//   joint positions          J        q^ - q
//   joint velocities         J        dq^ - dq
//   body positions           3 (B-1)  h^-1 ((p^_b - p^_r) - (p_b - p_r))
// PREVIOUS_TARGET, J: previous target - q, rad
// REFERENCE_CONTACT, for each frame ahead F: label of the reference
// SELF_CONTACT, F: 1 where a sole is within 5 mm of the floor
// REFERENCE_KEYPOINTS, for each frame ahead 9 B, and REFERENCE_BODIES, 24 B:
// goals in body space, body_goal.h
// SELF_BODIES, 15 B - 2, quantity after quantity, each body after body:
//   root height              1        p_r.z, m
//   positions                3 (B-1)  h^-1 (p_b - p_r), m; not the root
//   rotations                6 B      6D(h^-1 R_b)
//   linear velocities        3 B      h^-1 v_b, m/s
//   angular velocities       3 B      h^-1 w_b, rad/s
// What PHC and PULSE (Luo et al. 2023, 2024) show of the body itself: 358
// numbers for their 24 bodies, as in their code. The 15 per body that PULSE's
// paper lists would be 360; the root's position, which is 0 relative to itself,
// is left out, and its height is put first.
//
// Nothing depends on where the world's origin is or on its yaw, except the root
// height. Sources: the choice of quantities follows DeepMimic and PHC
// (Luo et al. 2023); angular velocities are turned like linear ones.
//
// Thread-safety: immutable. Ownership: none. Blocking: Build neither allocates
// nor locks. Errors: Create refuses unspecified or repeated blocks and frames
// ahead < 1, naming the field.
class ObservationBuilder {
 public:
  static absl::StatusOr<ObservationBuilder> Create(
      const v1::Observation& recipe, int bodies, int joints, int feet);

  // Another observation of the same character.
  absl::StatusOr<ObservationBuilder> ForSameCharacter(
      const v1::Observation& recipe) const {
    return Create(recipe, bodies_, joints_, feet_);
  }

  int width() const { return width_; }
  // Columns of the body's own blocks (common/config/recipe.h: IsSelfBlock) that
  // the observation begins with: what needs no reference.
  int self_width() const { return self_width_; }
  // Frames ahead, A entries.
  absl::Span<const int> frames_ahead() const { return frames_ahead_; }
  // True if that block is part of the observation.
  bool Has(v1::Observation::Block block) const;

  // The body's own blocks that it begins with alone: its first self_width()
  // columns, bit for bit, and the same whatever the reference is.
  ObservationBuilder SelfPart() const;

  // Of each column of `part`, an observation of the same character, which of
  // this one's columns it is; none if one is not among them.
  std::optional<std::vector<int32_t>> ColumnsOf(
      const ObservationBuilder& part) const;

  // Writes [width] float32.
  void Build(const ObservationInput& input, absl::Span<float> out) const;

  // One name per column, e.g. "reference+1/joint_position/left_knee".
  std::vector<std::string> Names(const ObservationNames& names) const;

 private:
  ObservationBuilder() = default;
  int BlockWidth(v1::Observation::Block block) const;

  int bodies_ = 0;
  int joints_ = 0;
  int feet_ = 0;
  int width_ = 0;
  int self_width_ = 0;
  std::vector<v1::Observation::Block> blocks_;
  std::vector<int> frames_ahead_;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_OBSERVATION_H_
