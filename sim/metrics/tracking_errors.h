#ifndef SINEW_SIM_METRICS_TRACKING_ERRORS_H_
#define SINEW_SIM_METRICS_TRACKING_ERRORS_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace sinew::metrics {

// Errors of a tracked motion, summed over frames so that results of several
// motions add up: divide by the number of frames that entered.
//
// For B bodies (0 is the root) with position p and reference p^ in metres, and
// the error e = p - p^ at frame t:
//
//   E_g-mpjpe  mean over bodies of |e|                              mm
//   E_mpjpe    mean over bodies of |(p - p_0) - (p^ - p^_0)|        mm
//   E_vel      mean over bodies of |e_t - e_t-1|                    mm/frame
//   E_acc      mean over bodies of |e_t - 2 e_t-1 + e_t-2|          mm/frame^2
//
// as in PULSE (Luo et al. 2024) and its code: only the root's position is
// subtracted, differences are not divided by time. A frame of the last two is
// 1/30 s whatever the rate of the data: at rate f they are multiplied by f / 30
// and (f / 30)^2.
struct TrackingErrorSums {
  int64_t frames = 0;
  int64_t velocity_frames = 0;
  int64_t acceleration_frames = 0;
  double g_mpjpe_mm = 0;
  double mpjpe_mm = 0;
  double velocity = 0;
  double acceleration = 0;
  std::vector<double> body_mm;  // [B] |e| of each body
};

// Frame rate of velocity and acceleration errors, Hz.
inline constexpr double kMetricRate = 30;

// Accumulates the errors of one motion, frame after frame.
//
// Thread-safety: one caller. Ownership: none. Blocking: never; Add does not
// allocate. Errors: none; non-finite in gives non-finite out.
class TrackingErrors {
 public:
  // `rate`: frames per second of what will be added, > 0.
  TrackingErrors(int bodies, double rate);

  // The next frame: [B] positions of body and reference, m, world. Returns the
  // mean distance over bodies, m.
  double Add(absl::Span<const Eigen::Vector3d> body,
             absl::Span<const Eigen::Vector3d> reference);

  // The motion is cut here: the next frame has no velocity error and the one
  // after it no acceleration error.
  void Restart() { since_cut_ = 0; }

  const TrackingErrorSums& sums() const { return sums_; }

 private:
  double rate_ratio_;
  TrackingErrorSums sums_;
  int64_t since_cut_ = 0;                            // frames
  std::vector<Eigen::Vector3d> last_, before_last_;  // errors e
};

}  // namespace sinew::metrics

#endif  // SINEW_SIM_METRICS_TRACKING_ERRORS_H_
