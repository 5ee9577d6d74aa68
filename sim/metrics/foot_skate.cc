#include "sim/metrics/foot_skate.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/check.h"

namespace sinew::metrics {

FootSkateMeter::FootSkateMeter(std::vector<int> foot_of_point, int feet,
                               double rate)
    : foot_of_point_(std::move(foot_of_point)), feet_(feet), rate_(rate) {
  for (const int foot : foot_of_point_) {
    SINEW_CHECK(foot >= 0 && foot < feet) << "foot " << foot;
  }
}

void FootSkateMeter::Add(absl::Span<const Eigen::Vector3d> points) {
  SINEW_CHECK(points.size() == foot_of_point_.size());
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (int foot = 0; foot < feet_ && !last_.empty(); ++foot) {
    double before = kFar, now = kFar, stays = kFar, slide = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      if (foot_of_point_[i] != foot) continue;
      before = std::min(before, last_[i].z());
      now = std::min(now, points[i].z());
      const double height = std::max(last_[i].z(), points[i].z());
      if (height >= stays) continue;
      stays = height;
      slide = (points[i] - last_[i]).head<2>().norm();
    }
    if (before > kTouchHeight || now > kTouchHeight) continue;
    ++figures_.contacts;
    figures_.sum_m_per_s += rate_ * slide;
  }
  last_.assign(points.begin(), points.end());
}

}  // namespace sinew::metrics
