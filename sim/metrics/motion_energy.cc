#include "sim/metrics/motion_energy.h"

#include <cmath>
#include <utility>

namespace sinew::metrics {
namespace {

double Mean(double sum, int64_t count) {
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

}  // namespace

void MotionEnergy::Add(const MotionEnergy& other) {
  frames += other.frames;
  differences += other.differences;
  second_differences += other.second_differences;
  root_speed += other.root_speed;
  joint_speed_square += other.joint_speed_square;
  acceleration += other.acceleration;
}

double MotionEnergy::root_speed_m_per_s() const {
  return Mean(root_speed, differences);
}

double MotionEnergy::joint_speed_rad_per_s() const {
  return std::sqrt(Mean(joint_speed_square, frames));
}

double MotionEnergy::acceleration_m_per_s2() const {
  return Mean(acceleration, second_differences);
}

void MotionEnergyMeter::Add(absl::Span<const Eigen::Vector3d> bodies,
                            absl::Span<const double> joint_velocity) {
  double square = 0;
  for (const double velocity : joint_velocity) square += velocity * velocity;
  figures_.joint_speed_square +=
      Mean(square, static_cast<int64_t>(joint_velocity.size()));
  ++figures_.frames;
  if (!last_.empty()) {
    figures_.root_speed += rate_ * (bodies[0] - last_[0]).head<2>().norm();
    ++figures_.differences;
  }
  if (!before_last_.empty()) {
    double sum = 0;
    for (size_t b = 0; b < bodies.size(); ++b) {
      sum += (bodies[b] - 2 * last_[b] + before_last_[b]).norm();
    }
    figures_.acceleration +=
        rate_ * rate_ * Mean(sum, static_cast<int64_t>(bodies.size()));
    ++figures_.second_differences;
  }
  before_last_ = std::move(last_);
  last_.assign(bodies.begin(), bodies.end());
}

}  // namespace sinew::metrics
