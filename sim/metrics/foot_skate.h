#ifndef SINEW_SIM_METRICS_FOOT_SKATE_H_
#define SINEW_SIM_METRICS_FOOT_SKATE_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"

namespace sinew::metrics {

// A sole no higher than this touches the floor (z = 0), m; as contact in
// observations (sim/world/foot_contact.h).
inline constexpr double kTouchHeight = 0.005;

struct FootSkate {
  int64_t contacts = 0;  // (frame, foot) that entered; 0: no foot touched
  double sum_m_per_s = 0;

  double mean_m_per_s() const {
    return contacts == 0 ? 0 : sum_m_per_s / static_cast<double>(contacts);
  }
  void Add(const FootSkate& other) {
    contacts += other.contacts;
    sum_m_per_s += other.sum_m_per_s;
  }
};

// Foot skate of a motion, frame after frame: mean over (frame, foot) whose
// lowest point touches the floor in this frame and the one before of the
// distance that the foot slides along the floor between the two, times the
// rate. What slides is the point that stays lowest (the lesser of the heights'
// maxima over both frames), so that a foot which rolls over its toe stands.
// It is the figure of imported clips (sim/import/retarget/quality.h), but for
// what counts as contact: height alone, so that no fast slide is left out.
//
// Thread-safety: one caller. Ownership: none. Blocking: never. Errors: none.
class FootSkateMeter {
 public:
  // `foot_of_point` [P]: 0 <= foot < feet; `rate` frames per second.
  FootSkateMeter(std::vector<int> foot_of_point, int feet, double rate);

  // [P] lowest points of the soles in the next frame, m, world.
  void Add(absl::Span<const Eigen::Vector3d> points);
  const FootSkate& figures() const { return figures_; }

 private:
  const std::vector<int> foot_of_point_;
  const int feet_;
  const double rate_;
  std::vector<Eigen::Vector3d> last_;  // empty: before the first frame
  FootSkate figures_;
};

}  // namespace sinew::metrics

#endif  // SINEW_SIM_METRICS_FOOT_SKATE_H_
