#include "sim/character/gains.h"

#include <algorithm>
#include <set>

#include "sim/character/model_ptr.h"

namespace sinew::character {
namespace {

// Bodies between the root (excluded) and a foot (included), per foot.
std::set<int> LegBodies(const mjModel& model, const std::vector<int>& feet) {
  std::set<int> bodies;
  for (int body : feet) {
    for (; model.body_parentid[body] != 0; body = model.body_parentid[body]) {
      bodies.insert(body);
    }
  }
  return bodies;
}

int Depth(const mjModel& model, int body) {
  int depth = 0;
  for (; body != 0; body = model.body_parentid[body]) ++depth;
  return depth;
}

// m g h of what all legs together hold up at the level of the joint at `body`:
// everything but the bodies of legs from that level on towards the feet.
double GravityStiffness(const mjModel& model, const mjData& data,
                        const std::set<int>& legs, int body) {
  const mjtNum joint_height = data.xpos[3 * body + 2];
  const int level = Depth(model, body);
  double moment = 0;  // sum of m * (height over the joint)
  for (int other = 1; other < model.nbody; ++other) {
    if (legs.contains(other) && Depth(model, other) >= level) continue;
    moment += model.body_mass[other] *
              (data.xipos[3 * other + 2] - joint_height);
  }
  return std::max(0.0, -model.opt.gravity[2] * moment);
}

}  // namespace

std::vector<Gains> ComputeGains(const mjModel& model,
                                const std::vector<int>& feet,
                                const GainRule& rule) {
  const DataPtr data(mj_makeData(&model));
  mj_forward(&model, data.get());
  std::vector<mjtNum> mass(model.nv * model.nv);
  mj_fullM(&model, data.get(), mass.data());
  const std::set<int> legs = LegBodies(model, feet);
  const double square = rule.bandwidth * rule.bandwidth;

  std::vector<double> stiffness(model.nbody, 0);
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (model.jnt_type[joint] != mjJNT_HINGE) continue;
    const int body = model.jnt_bodyid[joint];
    const int dof = model.jnt_dofadr[joint];
    const double inertia =
        std::max(rule.least_inertia, mass[dof * model.nv + dof]);
    double kp = inertia * square;
    if (legs.contains(body)) {
      kp = std::max(kp, rule.stability_margin *
                            GravityStiffness(model, *data, legs, body) /
                            static_cast<double>(feet.size()));
    }
    stiffness[body] = std::max(stiffness[body], kp);
  }
  std::vector<Gains> gains(model.njnt, {0, 0});
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (model.jnt_type[joint] != mjJNT_HINGE) continue;
    const double kp = stiffness[model.jnt_bodyid[joint]];
    gains[joint] = {kp, 2 * rule.damping_ratio * kp / rule.bandwidth};
  }
  return gains;
}

}  // namespace sinew::character
