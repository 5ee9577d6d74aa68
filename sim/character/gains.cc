#include "sim/character/gains.h"

#include <algorithm>
#include <numbers>
#include <set>

#include "sim/character/model_ptr.h"

namespace sinew::character {
namespace {

// Bodies between the root (excluded) and a foot (included).
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

// m g h, Nm/rad, of what all legs together hold up at the level of the joint
// at `body`: all but the bodies of legs from that level on towards the feet.
double LegLoad(const mjModel& model, const mjData& data,
               const std::set<int>& legs, int body) {
  const int level = Depth(model, body);
  double moment = 0;  // sum of m * (height over the joint)
  for (int other = 1; other < model.nbody; ++other) {
    if (legs.contains(other) && Depth(model, other) >= level) continue;
    moment += model.body_mass[other] *
              (data.xipos[3 * other + 2] - data.xpos[3 * body + 2]);
  }
  return -model.opt.gravity[2] * moment;
}

// m g h of what lies beyond the joint at `body`; negative if it hangs.
double LoadBeyond(const mjModel& model, const mjData& data, int body) {
  return -model.opt.gravity[2] * model.body_subtreemass[body] *
         (data.subtree_com[3 * body + 2] - data.xpos[3 * body + 2]);
}

}  // namespace

GainRule HumanoidGainRule() {
  GainRule rule;
  rule.damping_ratio = 0.5;
  return rule;
}

GainRule G1GainRule() {
  return {.inertia = GainRule::Inertia::kArmature,
          .bandwidth = 10 * 2 * std::numbers::pi,  // 10 Hz
          .damping_ratio = 2,
          // Ankle, knee, hip and waist in series.
          .stability_margin = 4,
          .least_inertia = 0};
}

GainRule H12GainRule() {
  GainRule rule = G1GainRule();
  rule.stability_margin = 6;
  return rule;
}

std::vector<Gains> ComputeGains(const mjModel& model,
                                const std::vector<int>& feet,
                                const GainRule& rule) {
  const DataPtr data(mj_makeData(&model));
  mj_forward(&model, data.get());
  std::vector<mjtNum> mass(model.nv * model.nv);
  mj_fullM(&model, data.get(), mass.data());
  const std::set<int> legs = LegBodies(model, feet);

  std::vector<double> stiffness(model.nbody, 0);
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (model.jnt_type[joint] != mjJNT_HINGE) continue;
    const int body = model.jnt_bodyid[joint];
    const int dof = model.jnt_dofadr[joint];
    const double inertia = rule.inertia == GainRule::Inertia::kArmature
                               ? model.dof_armature[dof]
                               : mass[dof * model.nv + dof];
    const double upright = data->xaxis[3 * joint + 2];
    const double load =
        (1 - upright * upright) * (legs.contains(body)
                                       ? LegLoad(model, *data, legs, body) /
                                             static_cast<double>(feet.size())
                                       : LoadBeyond(model, *data, body));
    stiffness[body] = std::max({stiffness[body], rule.stability_margin * load,
                                std::max(rule.least_inertia, inertia) *
                                    rule.bandwidth * rule.bandwidth});
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
