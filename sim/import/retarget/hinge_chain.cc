#include "sim/import/retarget/hinge_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/check.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Below this length a projection has no direction: the axes are aligned.
constexpr double kTiny = 1e-9;

// Angle about unit `axis` that turns `from` onto `to`, both seen along it; 0
// where that is undefined.
double AngleAbout(const Vector3d& axis, const Vector3d& from,
                  const Vector3d& to) {
  const double sine = axis.dot(from.cross(to));
  const double cosine = from.dot(to) - axis.dot(from) * axis.dot(to);
  return std::hypot(sine, cosine) < kTiny ? 0 : std::atan2(sine, cosine);
}

// Angle of the turn about `axis` nearest to `rotation`.
double Twist(const Vector3d& axis, const Quaterniond& rotation) {
  return 2 * std::atan2(axis.dot(rotation.vec()), rotation.w());
}

double NearestToRange(double angle, double lower, double upper) {
  const bool limited = std::isfinite(lower) && std::isfinite(upper);
  return motion::Unwrap(angle, limited ? (lower + upper) / 2 : 0);
}

// R(u1, a1) R(u2, a2) = target as nearly as possible, given where u2 must go.
VectorXd SolveTwo(const HingeChain& chain, const Quaterniond& target) {
  const Vector3d& u1 = chain.axes[0];
  const Vector3d& u2 = chain.axes[1];
  VectorXd angles(2);
  angles[0] = AngleAbout(u1, u2, target * u2);
  angles[1] = Twist(u2, Quaterniond(AngleAxisd(-angles[0], u1)) * target);
  return angles;
}

// R(u1, a1) R(u2, a2) R(u3, a3) = target. u1 . target u3 depends on a2 alone:
// p cos a2 + q sin a2 + r, which has two solutions; a1 and a3 follow.
std::vector<VectorXd> SolveThree(const HingeChain& chain,
                                 const Quaterniond& target) {
  const Vector3d& u1 = chain.axes[0];
  const Vector3d& u2 = chain.axes[1];
  const Vector3d& u3 = chain.axes[2];
  const double r = u1.dot(u2) * u2.dot(u3);
  const double p = u1.dot(u3) - r;
  const double q = u1.dot(u2.cross(u3));
  const Vector3d image = target * u3;
  const double amplitude = std::hypot(p, q);
  if (amplitude < kTiny) return {VectorXd::Zero(3)};
  const double share = std::clamp((u1.dot(image) - r) / amplitude, -1.0, 1.0);
  std::vector<VectorXd> solutions;
  for (const double sign : {1.0, -1.0}) {
    VectorXd angles(3);
    angles[1] = std::atan2(q, p) + sign * std::acos(share);
    const Quaterniond middle(AngleAxisd(angles[1], u2));
    angles[0] = AngleAbout(u1, middle * u3, image);
    const Quaterniond rest =
        middle.conjugate() * Quaterniond(AngleAxisd(-angles[0], u1)) * target;
    angles[2] = Twist(u3, rest);
    solutions.push_back(angles);
  }
  return solutions;
}

void AppendHinge(const mjModel& model, int joint, const Quaterniond& frame,
                 HingeChain* chain) {
  SINEW_CHECK(model.jnt_type[joint] == mjJNT_HINGE)
      << "joint " << joint << " is not a hinge";
  const double infinity = std::numeric_limits<double>::infinity();
  const bool limited = model.jnt_limited[joint];
  const double zero = model.qpos0[model.jnt_qposadr[joint]];
  chain->joints.push_back(joint);
  chain->axes.push_back(frame *
                        Eigen::Map<const Vector3d>(model.jnt_axis + 3 * joint));
  chain->lower.push_back(limited ? model.jnt_range[2 * joint] - zero
                                 : -infinity);
  chain->upper.push_back(limited ? model.jnt_range[2 * joint + 1] - zero
                                 : infinity);
}

}  // namespace

Quaterniond HingeChain::Rotation(const VectorXd& angles) const {
  Quaterniond rotation = Quaterniond::Identity();
  for (int i = 0; i < size(); ++i) {
    rotation = rotation * Quaterniond(AngleAxisd(angles[i], axes[i]));
  }
  return rotation * rest;
}

Eigen::Matrix3Xd HingeChain::Jacobian(const VectorXd& angles) const {
  Eigen::Matrix3Xd jacobian(3, size());
  Quaterniond rotation = Quaterniond::Identity();
  for (int i = 0; i < size(); ++i) {
    jacobian.col(i) = rotation * axes[i];
    rotation = rotation * Quaterniond(AngleAxisd(angles[i], axes[i]));
  }
  return jacobian;
}

std::vector<VectorXd> HingeChain::Solve(const Quaterniond& target) const {
  const Quaterniond turned = target * rest.conjugate();
  std::vector<VectorXd> solutions;
  switch (size()) {
    case 1:
      solutions = {VectorXd::Constant(1, Twist(axes[0], turned))};
      break;
    case 2:
      solutions = {SolveTwo(*this, turned)};
      break;
    case 3:
      solutions = SolveThree(*this, turned);
      break;
    default:
      solutions = {VectorXd::Zero(size())};
  }
  for (VectorXd& angles : solutions) {
    for (int i = 0; i < size(); ++i) {
      angles[i] = NearestToRange(angles[i], lower[i], upper[i]);
    }
  }
  return solutions;
}

HingeChain MakeHingeChain(const mjModel& model, int ancestor, int body) {
  std::vector<int> path;
  for (int b = body; b != ancestor; b = model.body_parentid[b]) {
    SINEW_CHECK(b > 0) << "body " << ancestor << " is no ancestor of " << body;
    path.push_back(b);
  }
  HingeChain chain;
  for (auto b = path.rbegin(); b != path.rend(); ++b) {
    chain.rest = chain.rest * motion::FromWxyz(model.body_quat + 4 * *b);
    for (int i = 0; i < model.body_jntnum[*b]; ++i) {
      AppendHinge(model, model.body_jntadr[*b] + i, chain.rest, &chain);
    }
  }
  return chain;
}

}  // namespace sinew::import
