#include "sim/import/retarget/refine_terms.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Points higher than this are left out of the search for bearing points.
constexpr double kReach = 0.03;

double Square(double x) { return x * x; }

VectorXd PerCoordinate(int nv, double floor, double up, double rotation,
                       double joint) {
  VectorXd weights = VectorXd::Constant(nv, joint);
  weights.head<2>().setConstant(floor);
  weights[2] = up;
  weights.segment<3>(3).setConstant(rotation);
  return weights;
}

// [frames] of those points of `bearing` that are on feet.
std::vector<std::vector<int>> FindSoles(
    const ImportModel& model, const std::vector<std::vector<bool>>& bearing) {
  std::vector<int> on_feet;
  for (int i = 0; i < static_cast<int>(model.points.size()); ++i) {
    if (model.FootOf(i) >= 0) on_feet.push_back(i);
  }
  std::vector<std::vector<int>> soles(bearing.size());
  for (size_t t = 0; t < bearing.size(); ++t) {
    std::copy_if(on_feet.begin(), on_feet.end(), std::back_inserter(soles[t]),
                 [&](int point) { return bearing[t][point]; });
  }
  return soles;
}

}  // namespace

RefineTerms::RefineTerms(Dynamics* dynamics, const ModelMotion& original,
                         const std::vector<std::vector<bool>>& bearing,
                         const RefineOptions& options, HeldFrames held)
    : dynamics_(dynamics),
      original_(original),
      bearing_(bearing),
      options_(options),
      held_(held),
      frames_(original.frames()),
      nv_(dynamics->model().nv),
      self_contacts_(dynamics->import_model()),
      pose_weights_(PerCoordinate(nv_, options.position, options.height,
                                  options.rotation, options.joint)),
      force_weights_(
          ContactFitWeights(dynamics->import_model(), options.torque)),
      original_change_(frames_),
      soles_(FindSoles(dynamics->import_model(), bearing)),
      may_bear_(frames_),
      feet_moves_(frames_),
      last_(nv_, nv_),
      here_(nv_, nv_),
      next_(nv_, nv_) {
  for (int t = 0; t < frames_; ++t) {
    if (options_.self != 0) {
      dynamics_->SetPose(original.qpos[t]);
      self_depths_.push_back(self_contacts_.Deepest(dynamics_->data()));
    }
    if (!HasNeighbours(t)) continue;
    const mjModel& model = dynamics_->model();
    original_change_[t] =
        Displacement(model, original.qpos[t], FrameAt(original, t + 1)) +
        Displacement(model, original.qpos[t], FrameAt(original, t - 1));
  }
}

RefineState RefineTerms::Begin(ModelMotion motion) {
  RefineState state;
  state.motion = std::move(motion);
  state.frames.resize(frames_);
  for (int t = 0; t < frames_; ++t) {
    EvaluateFrame(state.motion, t, &state.frames[t]);
    may_bear_[t] = state.frames[t].low;
    FitForces(t, t > 0 ? &state.frames[t - 1] : nullptr, &state.frames[t]);
  }
  SumCosts(&state);
  return state;
}

RefineState RefineTerms::Evaluate(ModelMotion motion, const RefineState& near) {
  RefineState state;
  state.motion = std::move(motion);
  state.frames.resize(frames_);
  for (int t = 0; t < frames_; ++t) {
    EvaluateFrame(state.motion, t, &state.frames[t]);
    FitForces(t, &near.frames[t], &state.frames[t]);
  }
  SumCosts(&state);
  return state;
}

void RefineTerms::ChooseContacts(RefineState* state) {
  for (int t = 0; t < frames_; ++t) {
    RefineState::Frame& frame = state->frames[t];
    if (frame.low == may_bear_[t]) continue;
    may_bear_[t] = frame.low;
    if (!HasNeighbours(t)) continue;
    dynamics_->SetPose(state->motion.qpos[t]);
    FitForces(t, &frame, &frame);
  }
  SumCosts(state);
}

ModelMotion RefineTerms::Moved(const RefineState& state,
                               const std::vector<VectorXd>& steps) const {
  ModelMotion motion = state.motion;
  for (int t = 0; t < frames_; ++t) {
    if (Unknown(t) < 0) continue;
    mj_integratePos(&dynamics_->model(), motion.qpos[t].data(),
                    steps[Unknown(t)].data(), 1);
  }
  KeepCycle(state.motion.qpos[0].head<3>(), &motion);
  return motion;
}

RefineTerms::Neighbour RefineTerms::Find(const ModelMotion& motion,
                                         int t) const {
  if (t >= 0 && t < frames_) return {t, Eigen::Matrix3d::Identity()};
  const int frame = (t + frames_) % frames_;
  const double yaw = t < 0 ? -motion.cycle.yaw : motion.cycle.yaw;
  return {frame, motion::YawRotation(yaw).toRotationMatrix()};
}

bool RefineTerms::HasNeighbours(int t) const {
  return original_.loops || (t > 0 && t + 1 < frames_);
}

bool RefineTerms::HasNext(int t) const {
  return original_.loops || t + 1 < frames_;
}

int RefineTerms::Unknown(int frame) const {
  return frame >= frames_ - held_.after ? -1 : frame - held_.before;
}

// Leaves the dynamics in the frame's pose.
void RefineTerms::EvaluateFrame(const ModelMotion& motion, int t,
                                RefineState::Frame* frame) {
  const mjModel& model = dynamics_->model();
  dynamics_->SetPose(motion.qpos[t]);
  const int points = static_cast<int>(bearing_[t].size());
  const bool counts = Unknown(t) >= 0;
  if (counts) frame->cost += PoseCost(motion, t) + SelfCost(t);
  for (int i = 0; i < points; ++i) {
    const double height = dynamics_->Height(i);
    if (height <= kReach) frame->low.push_back(i);
    if (!counts) continue;
    if (bearing_[t][i]) frame->cost += Square(options_.contact_height * height);
    if (height < 0) frame->cost += Square(options_.penetration * height);
  }
  for (const int i : soles_[t]) {
    frame->soles.push_back(dynamics_->LowestPoint(i));
  }
  if (!HasNeighbours(t)) return;
  frame->after = Displacement(model, motion.qpos[t], FrameAt(motion, t + 1));
  frame->before = Displacement(model, motion.qpos[t], FrameAt(motion, t - 1));
  const VectorXd change = frame->after + frame->before;
  frame->cost += Square(options_.acceleration) * change.squaredNorm() +
                 Square(options_.change_acceleration) *
                     (change - original_change_[t]).squaredNorm();
  // v = (r+ - r-) / 2 dt, a = (r+ + r-) / dt^2.
  frame->required =
      dynamics_->Inverse((frame->after - frame->before) * (motion.rate / 2),
                         change * (motion.rate * motion.rate));
}

void RefineTerms::FitForces(int t, const RefineState::Frame* near,
                            RefineState::Frame* frame) const {
  if (!HasNeighbours(t)) return;
  std::vector<Contact> contacts;
  for (const int point : may_bear_[t]) {
    contacts.push_back({point, dynamics_->LowestPoint(point)});
  }
  const bool guess = near != nullptr && near->fit.remainder.size() == nv_;
  frame->fit =
      FitContacts(*dynamics_, contacts, frame->required, options_.torque,
                  guess ? &near->fit.remainder : nullptr);
}

double RefineTerms::PoseCost(const ModelMotion& motion, int t) const {
  double cost =
      Displacement(dynamics_->model(), original_.qpos[t], motion.qpos[t])
          .cwiseProduct(pose_weights_)
          .squaredNorm();
  for (const ImportJoint& joint : dynamics_->import_model().joints) {
    const double q = motion.qpos[t][joint.qpos_address];
    const double excess = q - std::clamp(q, joint.lower, joint.upper);
    cost += Square(options_.limit * excess);
  }
  return cost;
}

bool RefineTerms::BodiesMeet(const ModelMotion& motion) {
  for (int t = 0; t < frames_; ++t) {
    if (Unknown(t) < 0) continue;
    dynamics_->SetPose(motion.qpos[t]);
    if (SelfCost(t) > 0) return true;
  }
  return false;
}

double RefineTerms::SelfCost(int t) const {
  if (options_.self == 0) return 0;
  double cost = 0;
  for (const SelfContact& contact :
       self_contacts_.Find(dynamics_->data(), self_depths_[t])) {
    cost += Square(options_.self * (contact.depth - self_depths_[t]));
  }
  return cost;
}

Vector3d RefineTerms::Seen(const ModelMotion& motion, int t,
                           const Vector3d& position) const {
  if (t >= 0 && t < frames_) return position;
  return motion.cycle.Move(position, motion.qpos[0].head<3>(),
                           /*forward=*/t >= frames_);
}

double RefineTerms::SlipCost(const RefineState& state, int t) const {
  if (!HasNext(t)) return 0;
  const int next = (t + 1) % frames_;
  if (Unknown(t) < 0 && Unknown(next) < 0) return 0;
  double cost = 0;
  VisitSlips(soles_[t], soles_[next], [&](size_t a, size_t b) {
    const Vector3d there =
        Seen(state.motion, t + 1, state.frames[next].soles[b]);
    cost += (there - state.frames[t].soles[a]).head<2>().squaredNorm();
  });
  return Square(options_.contact_slip) * cost;
}

void RefineTerms::SumCosts(RefineState* state) const {
  state->cost = 0;
  for (int t = 0; t < frames_; ++t) {
    const RefineState::Frame& frame = state->frames[t];
    state->cost += frame.cost + Square(options_.physics) * frame.fit.cost +
                   SlipCost(*state, t);
  }
}

}  // namespace sinew::import
