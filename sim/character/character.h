#ifndef SINEW_SIM_CHARACTER_CHARACTER_H_
#define SINEW_SIM_CHARACTER_CHARACTER_H_

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "proto/sinew/v1/character.pb.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/model_ptr.h"

namespace sinew::character {

// One actuated hinge, resolved against the compiled model.
struct JointInfo {
  std::string name;
  int joint_id;             // mjModel joint
  int qpos_address;         // index into qpos
  int dof_address;          // index into qvel
  double stiffness;         // Nm/rad
  double damping;           // Nm s/rad
  double torque_limit;      // Nm
  double lower, upper;      // rad; +-infinity if unlimited
  double default_position;  // rad
  double action_scale;      // rad per unit; 0: the recipe's
};

// A compiled body with its text proto: model, joints in action order, tracked
// bodies, feet. The model has a floor plane, the physics settings of the
// recipe (rate, solver, contact filters), joint damping equal to the gains'
// damping (integrated implicitly by the Euler integrator), no actuators of its
// own: torques enter through qfrc_applied (sim/world/actuation.h). Geoms that
// are only seen are left out; CompileForPictures has them.
//
// Thread-safety: immutable after Load. Ownership: owns the model. Blocking:
// Load reads files. Errors: NOT_FOUND listing where it looked;
// INVALID_ARGUMENT naming file and field: MJCF that does not compile (MuJoCo's
// message), unknown or missing joint, body, geom, non-positive gains, several
// or no free joints.
class Character {
 public:
  // By name ("humanoid", "g1": looked up in the character folders, see
  // character_path.h) or path of a character.textproto. Unset physics fields
  // mean the defaults of recipe.proto.
  static absl::StatusOr<std::unique_ptr<Character>> Load(
      const std::string& name_or_path, const v1::Physics& physics);

  // From assets: the text proto and a compiled model (MuJoCo binary format of
  // the same MuJoCo version).
  static absl::StatusOr<std::unique_ptr<Character>> FromAssets(
      absl::string_view character_text, absl::string_view model_binary,
      absl::string_view source);

  // The same bodies, joints and qpos with everything that can be seen, and a
  // scene around them (compile.h); for tools/render.
  static absl::StatusOr<ModelPtr> CompileForPictures(
      const std::string& name_or_path);

  const v1::Character& proto() const { return proto_; }
  const std::string& name() const { return proto_.name(); }
  const mjModel* model() const { return model_.get(); }

  // J joints in action order.
  const std::vector<JointInfo>& joints() const { return joints_; }
  // All bodies but the world: model body ids 1 .. nbody-1 in that order are
  // the B columns of a motion library. Tracked bodies as indices into those
  // columns (0 = root).
  const std::vector<int>& tracked() const { return tracked_; }
  // Indices into tracked(): those that may end an episode.
  const std::vector<int>& terminating() const { return terminating_; }
  // Model body ids of the feet, and their sole geoms' ids.
  const std::vector<int>& foot_bodies() const { return foot_bodies_; }
  const std::vector<std::vector<int>>& foot_geoms() const {
    return foot_geoms_;
  }
  int head_body() const { return head_body_; }  // model body id; -1: none
  // Where the root's free joint begins: in qpos x, y, z, then the quaternion w,
  // x, y, z; in qvel linear, then angular velocity.
  int root_qpos_address() const {
    return model_->jnt_qposadr[model_->body_jntadr[1]];
  }
  int root_dof_address() const {
    return model_->jnt_dofadr[model_->body_jntadr[1]];
  }
  int floor_geom() const { return floor_geom_; }
  double total_mass() const { return total_mass_; }  // kg

  // The compiled model as MuJoCo's binary image, and the text proto: assets.
  std::string model_binary() const;
  std::string character_text() const;
  // SHA-256 over the text proto and what of the model a motion depends on
  // (bodies, inertias, joints, geoms; model_digest.h): names the body that a
  // motion library was fitted to. Independent of the physics settings.
  const std::string& digest() const { return digest_; }

 private:
  Character() = default;
  absl::Status Resolve(absl::string_view source);

  v1::Character proto_;
  ModelPtr model_;
  std::vector<JointInfo> joints_;
  std::vector<int> tracked_, terminating_;
  std::vector<int> foot_bodies_;
  std::vector<std::vector<int>> foot_geoms_;
  int head_body_ = -1;
  int floor_geom_ = -1;
  double total_mass_ = 0;
  std::string digest_;
};

}  // namespace sinew::character

#endif  // SINEW_SIM_CHARACTER_CHARACTER_H_
