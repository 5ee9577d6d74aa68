#ifndef SINEW_SIM_WORLD_FALLEN_STATES_H_
#define SINEW_SIM_WORLD_FALLEN_STATES_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "common/stop.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"

namespace sinew::world {

// Positions of a character that has fallen, as in PHC's code (Luo et al. 2023):
//
//   the default pose, turned at random, is dropped from just above the floor;
//   for kDropSeconds (150 steps at 60 Hz) every joint follows random targets,
//   new at each control step: the middle of its range plus half the range
//   times an action uniform within +-0.5;
//   the position is kept, velocities are not.
//
// The asset "fallen": a safetensors file with one tensor "qpos" [N, nq] float64
// (root at x = y = 0, quaternion unit) and, as metadata, format, version,
// character and how it was made.
//
// Thread-safety: immutable. Ownership: owns its numbers. Blocking: Make
// simulates (about 15 ms per state), Parse computes. Errors: Make says which
// state could not be made; Parse names source, field, expected and found.
class FallenStates {
 public:
  static constexpr double kDropSeconds = 2.5;

  static constexpr uint64_t kEvaluationSeed = 20240501;

  // Deterministic in its arguments; of the recipe, physics counts. count >= 1.
  static absl::StatusOr<FallenStates> Make(
      const character::Character& character, const v1::Recipe& recipe,
      int count, uint64_t seed);

  // The same from kEvaluationSeed, for measuring: random numbers are of a
  // stream of their own, so that no recipe trains on them, whatever its
  // fallen_seed. CANCELLED between two states.
  static absl::StatusOr<FallenStates> MakeForEvaluation(
      const character::Character& character, const v1::Recipe& recipe,
      int count, const StopToken& stop = {});

  // Those that a recipe (defaults filled) starts from; null where it starts
  // from none.
  static absl::StatusOr<std::unique_ptr<const FallenStates>> MakeFor(
      const character::Character& character, const v1::Recipe& recipe);

  // From the bytes of a file; it must be of this character. `source` for
  // errors.
  static absl::StatusOr<FallenStates> Parse(
      absl::string_view bytes, const character::Character& character,
      absl::string_view source);

  std::string Serialize() const;

  int size() const { return static_cast<int>(qpos_.size()) / width_; }
  // [nq] of the model. Precondition: 0 <= index < size().
  absl::Span<const double> qpos(int index) const {
    return absl::MakeConstSpan(qpos_).subspan(
        static_cast<size_t>(index) * width_, width_);
  }

 private:
  // State i draws from environment first_environment + i.
  static absl::StatusOr<FallenStates> MakeFrom(
      const character::Character& character, const v1::Recipe& recipe,
      int count, uint64_t seed, uint64_t first_environment,
      const StopToken& stop);

  FallenStates(int width, std::string character_sha256)
      : width_(width), character_sha256_(std::move(character_sha256)) {}

  int width_;
  std::string character_sha256_;
  std::string made_from_;     // seed and physics, for people
  std::vector<double> qpos_;  // [N, width_]
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_FALLEN_STATES_H_
