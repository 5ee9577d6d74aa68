#include "sim/import/retarget/model_motion.h"

#include <algorithm>

#include "common/check.h"
#include "sim/import/retarget/joint_fit.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Moves a pose by the cycle once, forwards or back. `origin` is the root of the
// motion's first frame.
void MoveByCycle(const Cycle& cycle, const Vector3d& origin, bool forward,
                 VectorXd* qpos) {
  const Quaterniond turn =
      motion::YawRotation(forward ? cycle.yaw : -cycle.yaw);
  qpos->head<3>() = cycle.Move(qpos->head<3>(), origin, forward);
  motion::ToWxyz(turn * motion::FromWxyz(qpos->data() + 3), qpos->data() + 3);
}

// Rotation of a mapped body in its parent that the source asks for.
Quaterniond Target(const BodyMap& map, const MappedBody& body,
                   const std::vector<Quaterniond>& world) {
  const MappedBody& parent = map.bodies[body.parent];
  return (world[parent.role] * parent.alignment).conjugate() *
         (world[body.role] * body.alignment);
}

// Hinge angles of a chain in a pose.
VectorXd ChainAngles(const HingeChain& chain, const mjModel& model,
                     const VectorXd& qpos) {
  VectorXd angles(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const int address = model.jnt_qposadr[chain.joints[i]];
    angles[i] = qpos[address] - model.qpos0[address];
  }
  return angles;
}

Vector3d MiddleOfHips(const RoleTrack& track, int t) {
  return (track.position[t][track.Find("left_hip")] +
          track.position[t][track.Find("right_hip")]) /
         2;
}

Quaterniond RootRotation(const RoleTrack& track, const BodyMap& map, int t) {
  return track.rotation[t][0] * map.bodies[0].alignment;
}

Vector3d RootPlace(const RoleTrack& track, const BodyMap& map, int t) {
  return map.scale * MiddleOfHips(track, t) -
         RootRotation(track, map, t) * map.model_hips;
}

// The track's cycle as the model's root sees it: where the roots lie apart, a
// turn moves them differently.
Cycle ScaleCycle(const RoleTrack& track, const BodyMap& map) {
  const Cycle scaled = {map.scale * track.cycle.x, map.scale * track.cycle.y,
                        track.cycle.yaw};
  return MovePivot(scaled, map.scale * track.position[0][0],
                   RootPlace(track, map, 0));
}

}  // namespace

VectorXd Displacement(const mjModel& model, const VectorXd& a,
                      const VectorXd& b) {
  VectorXd difference(model.nv);
  mj_differentiatePos(&model, difference.data(), 1, a.data(), b.data());
  return difference;
}

void ClampHinges(const mjModel& model, ModelMotion* motion) {
  for (int id = 0; id < model.njnt; ++id) {
    if (model.jnt_type[id] != mjJNT_HINGE || !model.jnt_limited[id]) continue;
    const int address = model.jnt_qposadr[id];
    for (VectorXd& qpos : motion->qpos) {
      qpos[address] = std::clamp(qpos[address], model.jnt_range[2 * id],
                                 model.jnt_range[2 * id + 1]);
    }
  }
}

VectorXd FrameAt(const ModelMotion& motion, int t) {
  const int frames = motion.frames();
  SINEW_CHECK(motion.loops || (t >= 0 && t < frames)) << "frame " << t;
  const int cycles =
      t >= 0 ? t / frames : -((frames - 1 - t) / frames);  // floor
  VectorXd qpos = motion.qpos[t - cycles * frames];
  const Vector3d origin = motion.qpos[0].head<3>();
  for (int i = 0; i < std::abs(cycles); ++i) {
    MoveByCycle(motion.cycle, origin, /*forward=*/cycles > 0, &qpos);
  }
  return qpos;
}

void KeepCycle(const Vector3d& old_root, ModelMotion* motion) {
  if (!motion->loops) return;
  motion->cycle = MovePivot(motion->cycle, old_root, motion->qpos[0].head<3>());
}

void Rates(const mjModel& model, const ModelMotion& motion, int t,
           VectorXd* qvel, VectorXd* qacc) {
  const double dt = motion.dt();
  const int last = motion.frames() - 1;
  if (!motion.loops && last < 2) {
    *qvel = Displacement(model, motion.qpos[0], motion.qpos[last]) / dt;
    qacc->setZero(model.nv);
    return;
  }
  const int middle = motion.loops ? t : std::clamp(t, 1, last - 1);
  const VectorXd at = FrameAt(motion, middle);
  const VectorXd after = Displacement(model, at, FrameAt(motion, middle + 1));
  const VectorXd before = Displacement(model, at, FrameAt(motion, middle - 1));
  *qacc = (after + before) / (dt * dt);
  *qvel = (after - before) / (2 * dt) + (t - middle) * dt * *qacc;
}

ModelMotion FitMotion(const RoleTrack& track, const BodyMap& map,
                      const mjModel& model, double* cut_share) {
  ModelMotion motion;
  motion.rate = track.rate;
  motion.loops = track.loops;
  motion.cycle = ScaleCycle(track, map);
  const int frames = track.frames();
  motion.qpos.assign(frames, Eigen::Map<const VectorXd>(model.qpos0, model.nq));
  int cut = 0, hinges = 0;
  for (int t = 0; t < frames; ++t) {
    motion.qpos[t].head<3>() = RootPlace(track, map, t);
    motion::ToWxyz(RootRotation(track, map, t), motion.qpos[t].data() + 3);
  }
  for (const MappedBody& body : map.bodies) {
    if (body.parent < 0) continue;
    std::vector<Quaterniond> targets;
    for (const auto& rotations : track.rotation) {
      targets.push_back(Target(map, body, rotations));
    }
    const std::vector<VectorXd> angles =
        FitJoints(body.chain, targets, track.loops, &cut);
    hinges += body.chain.size();
    for (int t = 0; t < frames; ++t) {
      for (int i = 0; i < body.chain.size(); ++i) {
        const int address = model.jnt_qposadr[body.chain.joints[i]];
        motion.qpos[t][address] = model.qpos0[address] + angles[t][i];
      }
    }
  }
  if (cut_share != nullptr) {
    *cut_share = hinges == 0 ? 0 : cut / (1.0 * hinges * frames);
  }
  return motion;
}

JointFitError MeasureJointFit(const RoleTrack& track, const BodyMap& map,
                              const mjModel& model, const ModelMotion& motion) {
  JointFitError error;
  double sum = 0;
  for (int t = 0; t < motion.frames(); ++t) {
    for (size_t i = 1; i < map.bodies.size(); ++i) {
      const MappedBody& body = map.bodies[i];
      const double angle = motion::AngleBetween(
          Target(map, body, track.rotation[t]),
          body.chain.Rotation(ChainAngles(body.chain, model, motion.qpos[t])));
      sum += angle;
      error.max_rad = std::max(error.max_rad, angle);
    }
  }
  const size_t count = (map.bodies.size() - 1) * motion.qpos.size();
  error.mean_rad = count == 0 ? 0 : sum / static_cast<double>(count);
  return error;
}

}  // namespace sinew::import
