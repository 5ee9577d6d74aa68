#include "tools/bench/raw_physics.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/segment/segment_layout.h"

namespace sinew::bench {
namespace {

template <typename T>
std::vector<T> ReadColumn(const v1::Segment& segment, absl::string_view name) {
  const std::string& bytes = FindColumn(segment, name)->data();
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

}  // namespace

RawPhysics::RawPhysics(const world::TrackingTask& task)
    : task_(task),
      model_(task.character().model()),
      data_(mj_makeData(model_)) {}

void RawPhysics::Clear() {
  tracks_.clear();
  open_.clear();
}

// sim/world/actuation.h's law.
void RawPhysics::Record(const v1::EnvironmentState& state,
                        absl::Span<const double> target, Track* track) {
  const bool ramp = task_.recipe().task().action().ramp();
  mj_setState(model_, data_.get(), state.physics().data(), mjSTATE_INTEGRATION);
  for (int k = 1; k <= task_.substeps(); ++k) {
    const double share = static_cast<double>(k) / task_.substeps();
    for (size_t j = 0; j < target.size(); ++j) {
      const character::JointInfo& joint = task_.character().joints()[j];
      const double from =
          ramp ? state.previous_target(static_cast<int>(j)) : target[j];
      const double goal = from + share * (target[j] - from);
      const double velocity = data_->qvel[joint.dof_address];
      const double torque = std::clamp(
          joint.stiffness * (goal - data_->qpos[joint.qpos_address]) -
              joint.damping * velocity,
          -joint.torque_limit, joint.torque_limit);
      data_->qfrc_applied[joint.dof_address] =
          torque + joint.damping * velocity;
    }
    track->forces.insert(track->forces.end(), data_->qfrc_applied,
                         data_->qfrc_applied + model_->nv);
    mj_step(model_, data_.get());
  }
}

absl::Status RawPhysics::Add(const v1::Order& order,
                             const v1::Segment& segment) {
  const auto targets = ReadColumn<double>(segment, column::kTarget);
  open_.resize(order.states_size(), -1);
  const size_t joints = targets.size() / open_.size();
  for (int e = 0; e < order.states_size(); ++e) {
    const v1::EnvironmentState& state = order.states(e);
    const v1::EnvironmentState& end = segment.end_states(e);
    if (state.physics_size() == 0) continue;
    if (open_[e] < 0) {
      open_[e] = static_cast<int>(tracks_.size());
      tracks_.emplace_back();
      tracks_.back().start.assign(state.physics().begin(),
                                  state.physics().end());
    }
    Record(state, absl::MakeConstSpan(targets).subspan(e * joints, joints),
           &tracks_[open_[e]]);
    if (end.physics_size() == 0) {
      open_[e] = -1;
      continue;
    }
    std::vector<double> row(end.physics_size());
    mj_getState(model_, data_.get(), row.data(), mjSTATE_INTEGRATION);
    if (!std::equal(row.begin(), row.end(), end.physics().begin())) {
      return absl::InternalError(
          absl::StrCat("raw physics: environment ", e,
                       " ends in another state than in its ", "rollout"));
    }
  }
  return absl::OkStatus();
}

int64_t RawPhysics::Run() {
  const int nv = static_cast<int>(model_->nv);
  int64_t count = 0;
  for (const Track& track : tracks_) {
    mj_setState(model_, data_.get(), track.start.data(), mjSTATE_INTEGRATION);
    const int64_t steps = static_cast<int64_t>(track.forces.size()) / nv;
    for (int64_t i = 0; i < steps; ++i) {
      std::copy_n(track.forces.data() + i * nv, nv, data_->qfrc_applied);
      mj_step(model_, data_.get());
    }
    count += steps;
  }
  return count;
}

}  // namespace sinew::bench
