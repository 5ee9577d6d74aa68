#include "sim/metrics/diversity.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"

namespace sinew::metrics {
namespace {

// Mean distance of corresponding points of two frames, [P, 3] each.
double PoseDistance(absl::Span<const float> a, absl::Span<const float> b) {
  double sum = 0;
  for (size_t i = 0; i + 2 < a.size(); i += 3) {
    const double x = static_cast<double>(a[i]) - b[i];
    const double y = static_cast<double>(a[i + 1]) - b[i + 1];
    const double z = static_cast<double>(a[i + 2]) - b[i + 2];
    sum += std::sqrt(x * x + y * y + z * z);
  }
  return a.empty() ? 0 : sum / (static_cast<double>(a.size()) / 3);
}

absl::Span<const float> Frame(const PosePath& path, int64_t frame) {
  const size_t width = path.points.size() / static_cast<size_t>(path.frames());
  return absl::MakeConstSpan(path.points)
      .subspan(static_cast<size_t>(frame) * width, width);
}

void AddPair(const PosePath& a, const PosePath& b, DiversityFigures& sums) {
  const int64_t frames = std::min(a.frames(), b.frames());
  if (frames < 2) return;
  SINEW_CHECK(Frame(a, 0).size() == Frame(b, 0).size());
  double over_time = 0, last = 0;
  for (int64_t t = 1; t < frames; ++t) {
    last = PoseDistance(Frame(a, t), Frame(b, t));
    over_time += last;
  }
  const auto end = static_cast<size_t>(2 * (frames - 1));
  ++sums.pairs;
  sums.over_time_m += over_time / static_cast<double>(frames - 1);
  sums.final_m += last;
  sums.final_root_m +=
      std::hypot(static_cast<double>(a.root[end]) - b.root[end],
                 static_cast<double>(a.root[end + 1]) - b.root[end + 1]);
}

}  // namespace

absl::Status DiversityMeter::AddGroup(absl::Span<const PosePath> group,
                                      const StopToken& stop) {
  for (size_t i = 0; i < group.size(); ++i) {
    for (size_t j = i + 1; j < group.size(); ++j) {
      if (stop.stop_requested()) {
        return absl::CancelledError("diversity: stopped before its end");
      }
      AddPair(group[i], group[j], sums_);
    }
  }
  return absl::OkStatus();
}

DiversityFigures DiversityMeter::figures() const {
  DiversityFigures means = sums_;
  if (means.pairs == 0) return means;
  const auto pairs = static_cast<double>(means.pairs);
  means.over_time_m /= pairs;
  means.final_m /= pairs;
  means.final_root_m /= pairs;
  return means;
}

}  // namespace sinew::metrics
