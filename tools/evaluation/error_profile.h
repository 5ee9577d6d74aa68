#ifndef SINEW_TOOLS_EVALUATION_ERROR_PROFILE_H_
#define SINEW_TOOLS_EVALUATION_ERROR_PROFILE_H_

#include <mujoco/mujoco.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "proto/sinew/v1/rollout.pb.h"
#include "sim/character/character.h"
#include "sim/motion/library.h"

namespace sinew::evaluation {

// Where in a clip which body is off: the global position error of each tracked
// body, summed over all visits of a bin of the clip's frames. A looping clip's
// frames are taken modulo its period.
//
// Thread-safety: one caller. Ownership: borrows character and library.
// Blocking: never; Add does not allocate. Errors: none.
class ErrorProfile {
 public:
  // At most this many bins; a clip of fewer frames has one bin per frame.
  static constexpr int kMaxBins = 96;

  ErrorProfile(const character::Character& character,
               const motion::Library& library, int clip);

  // The body `frame` steps after `start` (of this clip).
  void Add(const v1::EvaluationStart& start, int frame, const mjData& data);

  // Adds the visits of another profile of the same clip.
  void Merge(const ErrorProfile& other);

  int bins() const { return bins_; }
  // Mean error in a bin, mm; 0 without visits. `body` counts tracked bodies.
  double mean_mm(int body, int bin) const;
  int64_t visits(int bin) const { return visits_[bin]; }
  // Sum of a body's error over all visits, mm.
  double sum_mm(int body) const;

 private:
  const character::Character* character_;
  const motion::Library* library_;
  const int clip_;
  const int bins_;
  std::unique_ptr<motion::ReferenceFrame> reference_;
  std::vector<double> sum_mm_;   // [bodies, bins]
  std::vector<int64_t> visits_;  // [bins]
};

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_ERROR_PROFILE_H_
