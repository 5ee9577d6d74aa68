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

// Reads a character's tracked bodies and joints out of mjData and out of
// library rows.
//
// Thread-safety: immutable. Ownership: copies what it needs. Blocking: never;
// nothing allocates after construction. Errors: none.
class BodyReader {
 public:
  explicit BodyReader(const character::Character& character);

  int num_bodies() const { return static_cast<int>(columns_.size()); }
  int num_joints() const { return static_cast<int>(joints_.size()); }

  // The state of qpos and qvel, worked out from these alone: what mj_step
  // leaves in the data is one physics step old. It does what mj_kinematics,
  // mj_comPos and mj_comVel do, for the frames of the bodies that count and
  // nothing else, in a quarter of the instructions. Uses data's scratch memory,
  // changes nothing in it.
  void Read(mjData* data, BodyState* state) const;

  // A library row to state.
  void Read(const motion::FrameView& frame, BodyState* state) const;

 private:
  struct Hinge {
    int qpos_address, dof_address;
    double rest;             // qpos where the body's frame is not turned
    Eigen::Vector3d axis;    // in the body's frame, unit
    Eigen::Vector3d anchor;  // in the body's frame, m
    bool has_anchor;         // off the frame's origin
  };
  // A tracked body or an ancestor of one, parents first, the root first.
  struct Body {
    int parent;                   // index into bodies_
    Eigen::Vector3d position;     // at rest, in the parent's frame, m
    Eigen::Quaterniond rotation;  // at rest, in the parent's frame
    bool is_turned;               // rotation is not the identity
    int first_hinge, end_hinge;   // of hinges_, from the parent outwards
    int tracked;                  // index into the state's bodies; -1: none
  };
  // Position, rotation and velocities of a body's frame in the world.
  struct Motion;

  void AddBodies(const character::Character& character);
  // Sines and cosines of half the hinges' angles, each [hinges_, padded].
  void ReadHalfAngles(const double* qpos, double* sines, double* cosines) const;
  Motion RootMotion(const mjData& data) const;
  Motion Follow(const Body& body, const Motion& parent, const double* sines,
                const double* cosines, const double* qvel) const;

  std::vector<Body> bodies_;
  std::vector<Hinge> hinges_;
  int root_qpos_address_ = 0;
  int root_dof_address_ = 0;
  std::vector<int> columns_;  // [B] body columns of a library
  struct Joint {
    int qpos_address, dof_address;
  };
  std::vector<Joint> joints_;  // [J]
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_BODY_STATE_H_
