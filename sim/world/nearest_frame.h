#ifndef SINEW_SIM_WORLD_NEAREST_FRAME_H_
#define SINEW_SIM_WORLD_NEAREST_FRAME_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/motion/library.h"
#include "sim/world/body_state.h"
#include "sim/world/start.h"

namespace sinew::world {

// Finds the frame of a library that is nearest to a body, wherever it is in the
// plane and wherever it heads: the one from which motion can go on.
//
// Compared are the tracked bodies' positions, and their linear velocities times
// kVelocitySeconds, both seen from the root's place on the floor along its
// heading: the distance is the square root of the sum of squares. Candidates
// are the frames of the clips that IsDrawn says from which the motion goes on
// for some seconds (all frames of a looping clip), or given ones; where there
// are more than `most`, every n-th, so that at most so many are kept.
//
//   NearestFrames frames(recipe.task().start(), library, reader);
//   std::vector<float> scratch(frames.width());
//   if (const auto nearest = frames.Find(body, absl::MakeSpan(scratch))) ...
//
// Thread-safety: immutable; scratch is the caller's. Ownership: copies what it
// needs. Blocking: Find compares with all candidates; it does not allocate.
// Errors: none; a body that is not finite has none.
class NearestFrames {
 public:
  static constexpr double kVelocitySeconds = 0.1;
  static constexpr double kSecondsAhead = 0.5;
  static constexpr int64_t kMostFrames = 32768;

  // `seconds` >= 0, `most` >= 1.
  NearestFrames(const v1::Start& recipe, const motion::Library& library,
                const BodyReader& reader, double seconds = kSecondsAhead,
                int64_t most = kMostFrames);

  // Of these frames instead.
  NearestFrames(const std::vector<StartFrame>& frames,
                const motion::Library& library, const BodyReader& reader,
                int64_t most = kMostFrames);

  // Numbers of scratch that Find needs.
  int width() const { return static_cast<int>(features_.cols()); }
  int64_t size() const { return features_.rows(); }

  // None if there are no candidates; the first of equals.
  std::optional<StartFrame> Find(const BodyState& body,
                                 absl::Span<float> scratch) const;

 private:
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
      features_;  // [size(), 6 B]
  std::vector<StartFrame> frames_;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_NEAREST_FRAME_H_
