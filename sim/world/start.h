#ifndef SINEW_SIM_WORLD_START_H_
#define SINEW_SIM_WORLD_START_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"
#include "sim/motion/library.h"

namespace sinew::world {

// A frame of a clip.
struct StartFrame {
  int32_t clip = 0;
  int32_t frame = 0;
};

// Whether starts are drawn from a clip: it is not left out of training, and
// among only_clips if the recipe names some and leaves no share to the others.
bool IsDrawn(const v1::Start& recipe, const v1::ClipInfo& clip);

// Where episodes start: a distribution over the frames of a library.
//
// Every frame of every clip can be drawn that has a successor (all frames of a
// looping clip, all but the last of others), of the clips that IsDrawn says.
//   UNIFORM  all of them alike;
//   others   a bin by the curriculum's probabilities, which the learner's rule
//            has set, then a frame of the bin uniformly. A curriculum without
//            bins means uniform.
//
// A library without such clips can be evaluated: its table has no frames.
//
// Thread-safety: immutable. Ownership: copies what it needs. Blocking: never;
// Draw does not allocate (binary searches). Errors: Create refuses bins that
// lie outside their clip, are of a left-out one, or whose probabilities do not
// sum to 1, naming bin, expected and found.
class StartTable {
 public:
  static absl::StatusOr<StartTable> Create(
      const v1::Start& recipe, const motion::Library& library,
      const v1::CurriculumTable& curriculum);

  // The start of an episode; pure in its arguments. num_frames() > 0.
  StartFrame Draw(uint64_t seed, uint64_t environment, uint64_t episode) const;

  // Frames that can be drawn, over all clips.
  int64_t num_frames() const { return ends_.empty() ? 0 : ends_.back(); }

 private:
  struct Bin {
    double end;  // cumulative probability
    int32_t clip, first_frame, num_frames;
  };
  StartTable() = default;
  absl::Status AddBins(const motion::Library& library,
                       const v1::CurriculumTable& curriculum);

  std::vector<int64_t> ends_;  // cumulative startable frames, per clip
  std::vector<Bin> bins_;
};

// Frames of a clip that have a successor.
int64_t NumStartFrames(const v1::ClipInfo& clip);

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_START_H_
