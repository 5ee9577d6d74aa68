#include "sim/metrics/tracking_errors.h"

#include "common/check.h"

namespace sinew::metrics {
namespace {

constexpr double kMillimetres = 1000;

}  // namespace

TrackingErrors::TrackingErrors(int bodies, double rate)
    : rate_ratio_(rate / kMetricRate),
      last_(bodies, Eigen::Vector3d::Zero()),
      before_last_(bodies, Eigen::Vector3d::Zero()) {
  sums_.body_mm.assign(bodies, 0.0);
}

double TrackingErrors::Add(absl::Span<const Eigen::Vector3d> body,
                           absl::Span<const Eigen::Vector3d> reference) {
  const size_t bodies = last_.size();
  SINEW_DCHECK(body.size() == bodies && reference.size() == bodies);
  double global = 0, local = 0, velocity = 0, acceleration = 0;
  const Eigen::Vector3d root_error = body[0] - reference[0];
  for (size_t b = 0; b < bodies; ++b) {
    const Eigen::Vector3d error = body[b] - reference[b];
    sums_.body_mm[b] += kMillimetres * error.norm();
    global += error.norm();
    local += (error - root_error).norm();
    velocity += (error - last_[b]).norm();
    acceleration += (error - 2 * last_[b] + before_last_[b]).norm();
    before_last_[b] = last_[b];
    last_[b] = error;
  }
  const double scale = kMillimetres / static_cast<double>(bodies);
  sums_.g_mpjpe_mm += scale * global;
  sums_.mpjpe_mm += scale * local;
  if (since_cut_ >= 1) {
    sums_.velocity += scale * velocity * rate_ratio_;
    ++sums_.velocity_frames;
  }
  if (since_cut_ >= 2) {
    sums_.acceleration += scale * acceleration * rate_ratio_ * rate_ratio_;
    ++sums_.acceleration_frames;
  }
  ++sums_.frames;
  ++since_cut_;
  return global / static_cast<double>(bodies);
}

}  // namespace sinew::metrics
