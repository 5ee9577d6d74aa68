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

// Steps of an environment until its episode ends, at most all.
int StepsOf(int environment, int environments,
            absl::Span<const uint8_t> terminated,
            absl::Span<const uint8_t> truncated) {
  const int all = static_cast<int>(terminated.size()) / environments;
  for (int step = 0; step < all; ++step) {
    const int row = step * environments + environment;
    if (terminated[row] != 0 || truncated[row] != 0) return step + 1;
  }
  return all;
}

}  // namespace

RawPhysics::RawPhysics(const world::TrackingTask& task)
    : task_(task),
      model_(task.character().model()),
      data_(mj_makeData(model_)) {}

RawPhysics::Track RawPhysics::Record(const v1::EnvironmentState& state,
                                     int steps, int environment,
                                     int environments,
                                     absl::Span<const double> targets) {
  Track track;
  track.start.assign(state.physics().begin(), state.physics().end());
  std::vector<double> previous(state.previous_target().begin(),
                               state.previous_target().end());
  const size_t joints = previous.size();
  const bool ramp = task_.recipe().task().action().ramp();
  mj_setState(model_, data_.get(), track.start.data(), mjSTATE_INTEGRATION);
  for (int step = 0; step < steps; ++step) {
    const double* target =
        targets.data() + (int64_t{step} * environments + environment) * joints;
    for (int k = 1; k <= task_.substeps(); ++k) {
      // sim/world/actuation.h's law.
      const double share = static_cast<double>(k) / task_.substeps();
      for (size_t j = 0; j < joints; ++j) {
        const character::JointInfo& joint = task_.character().joints()[j];
        const double from = ramp ? previous[j] : target[j];
        const double goal = from + share * (target[j] - from);
        const double velocity = data_->qvel[joint.dof_address];
        const double torque = std::clamp(
            joint.stiffness * (goal - data_->qpos[joint.qpos_address]) -
                joint.damping * velocity,
            -joint.torque_limit, joint.torque_limit);
        data_->qfrc_applied[joint.dof_address] =
            torque + joint.damping * velocity;
      }
      track.forces.insert(track.forces.end(), data_->qfrc_applied,
                          data_->qfrc_applied + model_->nv);
      mj_step(model_, data_.get());
    }
    std::copy_n(target, joints, previous.begin());
  }
  return track;
}

absl::Status RawPhysics::Prepare(const v1::Order& order,
                                 const v1::Segment& segment) {
  const auto targets = ReadColumn<double>(segment, column::kTarget);
  const auto terminated = ReadColumn<uint8_t>(segment, column::kTerminated);
  const auto truncated = ReadColumn<uint8_t>(segment, column::kTruncated);
  const int environments = order.states_size();
  tracks_.clear();
  for (int e = 0; e < environments; ++e) {
    const v1::EnvironmentState& state = order.states(e);
    if (state.physics_size() == 0) continue;
    const int steps = StepsOf(e, environments, terminated, truncated);
    tracks_.push_back(Record(state, steps, e, environments, targets));
    const v1::EnvironmentState& end = segment.end_states(e);
    if (end.episode() != state.episode() || end.physics_size() == 0) continue;
    std::vector<double> row(end.physics_size());
    mj_getState(model_, data_.get(), row.data(), mjSTATE_INTEGRATION);
    if (!std::equal(row.begin(), row.end(), end.physics().begin())) {
      return absl::InternalError(absl::StrCat(
          "raw physics: environment ", e, " ends in another state than in its ",
          "rollout of ", steps, " steps"));
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
