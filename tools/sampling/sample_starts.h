#ifndef SINEW_TOOLS_SAMPLING_SAMPLE_STARTS_H_
#define SINEW_TOOLS_SAMPLING_SAMPLE_STARTS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/stop.h"
#include "sim/motion/library.h"
#include "tools/sampling/free_body.h"

namespace sinew::sampling {

// A body at this share of its standing height, or above it, is upright.
inline constexpr double kUprightShare = 0.6;
// An upright body whose root is slower than this stands, m/s; its limbs may
// move.
inline constexpr double kStandingSpeed = 0.3;

// A state in which samples begin.
struct SampleStart {
  std::string name;  // "walk at 1.20 s", "fallen 3"
  std::vector<double> qpos, qvel;
};

// What `--start` says: "clip", "standing", "fallen" or CLIP:SECONDS.
struct StartKind {
  enum class Kind { kClip, kStanding, kFallen, kGiven };
  Kind kind = Kind::kClip;
  std::string clip = {};  // kGiven
  double seconds = 0;     // kGiven
};

// INVALID_ARGUMENT says what was expected. Pure.
absl::StatusOr<StartKind> ParseStart(absl::string_view text);

// `count` >= 1 states (one for a given clip):
//   kClip      frames drawn with Philox by (seed, index) from those frames of
//              the library's clips, left-out ones apart, that are upright
//              (kUprightShare) and in which a foot bears; with velocities
//   kStanding  from those of them that stand (kStandingSpeed)
//   kFallen    world::FallenStates::MakeForEvaluation: never trained on
//   kGiven     the clip's frame nearest to that time; with velocities
// Same inputs, same states. Blocking: fallen states are simulated, about 15 ms
// each. Errors: INVALID_ARGUMENT: clips asked for and no `library` (null), a
// time outside of the clip, a library without such frames; NOT_FOUND: no such
// clip; CANCELLED: between two states.
absl::StatusOr<std::vector<SampleStart>> MakeStarts(
    const BodyLaw& law, const motion::Library* library, const StartKind& kind,
    int count, uint64_t seed, const StopToken& stop);

}  // namespace sinew::sampling

#endif  // SINEW_TOOLS_SAMPLING_SAMPLE_STARTS_H_
