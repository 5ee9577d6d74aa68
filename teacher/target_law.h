#ifndef SINEW_TEACHER_TARGET_LAW_H_
#define SINEW_TEACHER_TARGET_LAW_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "teacher/teacher_policy.h"

namespace sinew::teacher {

// From an action and what it is added to, to the joint target: the last line of
// sim/world/action.h, to the bit, from what a bundle's manifest says. The base
// itself depends on reference and body, which actors have and teachers do not.
//
// Thread-safety: immutable. Ownership: none. Blocking: never. Errors: Create.
class TargetLaw {
 public:
  // INVALID_ARGUMENT names the manifest's field: scales, clip, margin or ranges
  // that no bundle has.
  static absl::StatusOr<TargetLaw> Create(const TeacherPolicy& policy);

  // One row: base [A] rad, action [A], target [A] rad.
  void Target(absl::Span<const double> base, absl::Span<const float> action,
              absl::Span<double> target) const;

  // Radians per unit of action of joint j.
  double scale(size_t j) const { return joints_[j].scale; }
  // Defaults filled.
  const v1::Action& action() const { return action_; }

 private:
  struct Joint {
    double scale;      // rad per unit
    double low, high;  // rad, margin included
  };

  TargetLaw(v1::Action action, std::vector<Joint> joints);

  v1::Action action_;
  double clip_;
  std::vector<Joint> joints_;
};

}  // namespace sinew::teacher

#endif  // SINEW_TEACHER_TARGET_LAW_H_
