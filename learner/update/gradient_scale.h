#ifndef SINEW_LEARNER_UPDATE_GRADIENT_SCALE_H_
#define SINEW_LEARNER_UPDATE_GRADIENT_SCALE_H_

#include <algorithm>

namespace sinew::learner {

// What a gradient of Euclidean norm `norm` is multiplied by so that its norm is
// at most `limit`: 1 where it is already. A clipped norm stays a hair below the
// limit, and 0 / 0 away. Pure.
inline double GradientScale(double norm, double limit) {
  constexpr double kNormFloor = 1e-6;
  return std::min(1.0, limit / (norm + kNormFloor));
}

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_UPDATE_GRADIENT_SCALE_H_
