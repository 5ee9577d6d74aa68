#ifndef SINEW_SIM_WORLD_BODY_STATE_H_
#define SINEW_SIM_WORLD_BODY_STATE_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <vector>

#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::world {

// Kinematic state of a simulated body or of a reference frame: B tracked bodies
// (0 is the root), J joints in action order. World frame (z up), SI units,
// float64. Plain data, sized once.
struct BodyState {
  BodyState() = default;
  BodyState(int bodies, int joints);

  std::vector<Eigen::Vector3d> position;          // [B] frame origins, m
  std::vector<Eigen::Quaterniond> rotation;       // [B] body to world, unit
  std::vector<Eigen::Vector3d> linear_velocity;   // [B] of frame origins, m/s
  std::vector<Eigen::Vector3d> angular_velocity;  // [B] rad/s
  std::vector<double> joint_position;             // [J] rad
  std::vector<double> joint_velocity;             // [J] rad/s
};

// Rotation about world z by the heading of a rotation: the twist about z of its
// swing-twist decomposition (what is left is the shortest rotation that tilts
// the vertical). Smooth except where the body is exactly upside down, where it
// is the identity. For a body turned by yaw only, it is that yaw.
Eigen::Quaterniond Heading(const Eigen::Quaterniond& rotation);

// Where a character's tracked bodies and joints lie in mjData and in library
// rows.
//
// Thread-safety: immutable. Ownership: copies what it needs. Blocking: never;
// nothing allocates after construction. Errors: none.
class BodyReader {
 public:
  explicit BodyReader(const character::Character& character);

  int num_bodies() const { return static_cast<int>(body_ids_.size()); }
  int num_joints() const { return static_cast<int>(qpos_addresses_.size()); }

  // Recomputes from qpos and qvel all that Read reads: body poses and
  // com-based velocities. After mj_step they are one physics step old.
  static void Refresh(const mjModel* model, mjData* data);

  // Refreshed data to state. MuJoCo's com-based velocities become those of the
  // frame origins here and nowhere else.
  void Read(const mjModel* model, const mjData* data, BodyState* state) const;

  // A library row to state.
  void Read(const motion::FrameView& frame, BodyState* state) const;

 private:
  std::vector<int> body_ids_;        // [B] mjModel bodies
  std::vector<int> columns_;         // [B] body columns of a library
  std::vector<int> qpos_addresses_;  // [J]
  std::vector<int> dof_addresses_;   // [J]
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_BODY_STATE_H_
