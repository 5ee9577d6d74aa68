#ifndef SINEW_ACTOR_TESTING_STUDENT_ROLLOUT_H_
#define SINEW_ACTOR_TESTING_STUDENT_ROLLOUT_H_

#include <cstddef>
#include <string>
#include <vector>

#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/rollout.pb.h"

namespace sinew::actor::testing {

// What tests of rollouts that distil share, in the toy world.

inline constexpr int kJoints = 4;
// The third joint's scale is its own.
inline constexpr double kOwnScale = 0.3;
inline constexpr char kAbsolute[] = "action { placement: PLACEMENT_ABSOLUTE }";

// With defaults filled. `task` and `distillation` are the insides of these
// groups; a test failure if they cannot be read.
v1::Recipe StudentRecipe(const std::string& task = "",
                         const std::string& distillation = "");

// Columns of a segment, [T, E, kJoints].
struct Rows {
  explicit Rows(const v1::Segment& segment);

  size_t size() const { return target.size(); }
  // Number i: base + scale * action, limited.
  double Made(const std::vector<double>& bases, size_t i, double scale) const;

  std::vector<float> action, mean;
  std::vector<double> target, base, teacher_base;
};

}  // namespace sinew::actor::testing

#endif  // SINEW_ACTOR_TESTING_STUDENT_ROLLOUT_H_
