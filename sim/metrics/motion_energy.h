#ifndef SINEW_SIM_METRICS_MOTION_ENERGY_H_
#define SINEW_SIM_METRICS_MOTION_ENERGY_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace sinew::metrics {

// Sums over frames, so that figures of several motions add up.
struct MotionEnergy {
  int64_t frames = 0, differences = 0, second_differences = 0;
  double root_speed = 0;          // of differences
  double joint_speed_square = 0;  // of frames: mean over joints of dq^2
  double acceleration = 0;        // of second differences

  void Add(const MotionEnergy& other);
  // Mean speed of the root over the floor, m/s.
  double root_speed_m_per_s() const;
  // Root mean square of joint velocities, rad/s.
  double joint_speed_rad_per_s() const;
  // Mean over bodies and frames of |x_t - 2 x_t-1 + x_t-2| rate^2, m/s^2: what
  // is jittery accelerates much and goes nowhere.
  double acceleration_m_per_s2() const;
};

// How calm or lively a motion is, frame after frame.
//
// Thread-safety: one caller. Ownership: none. Blocking: never. Errors: none.
class MotionEnergyMeter {
 public:
  explicit MotionEnergyMeter(double rate) : rate_(rate) {}

  // The next frame: [B] positions, m, world, the root first; [J] rad/s.
  void Add(absl::Span<const Eigen::Vector3d> bodies,
           absl::Span<const double> joint_velocity);
  const MotionEnergy& figures() const { return figures_; }

 private:
  const double rate_;
  std::vector<Eigen::Vector3d> last_, before_last_;
  MotionEnergy figures_;
};

}  // namespace sinew::metrics

#endif  // SINEW_SIM_METRICS_MOTION_ENERGY_H_
