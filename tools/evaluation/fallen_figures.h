#ifndef SINEW_TOOLS_EVALUATION_FALLEN_FIGURES_H_
#define SINEW_TOOLS_EVALUATION_FALLEN_FIGURES_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/stop.h"
#include "proto/sinew/v1/rollout.pb.h"
#include "sim/world/fallen_states.h"
#include "tools/evaluation/subject.h"

namespace sinew::evaluation {

// How many bodies get up from the floor, of policies whose recipe has recovery
// and of those whose recipe has none:
//
//   CheckFallenStarts(n);
//   fallen = MakeFallenStates(character_file, n);   // into MakeSubject
//   EvaluateFallen(subject, threads, stop);
//
// Pure functions. Blocking and errors: as stated.

// A share has a standard error of at most 1.6 % then; more starts only take
// longer, 15 ms each to make and seconds to run.
inline constexpr int kMostFallenStarts = 1024;

// Seconds of recovered_5_s: starts are made long enough for it.
inline constexpr double kLateSeconds = 5;

// What became of one start.
struct FallenRow {
  int state = 0;  // index of the fallen state, as `sinew render` takes it
  int clip = 0;   // that it began beside, or the get-up that it began on
  // Since when it stood and tracked to the end; unset: it does not at its end.
  std::optional<double> recovered_s = std::nullopt;
  // When it went on after a get-up; unset: it did not.
  std::optional<double> carried_s = std::nullopt;
  double seconds = 0;  // that it lasted
};

struct FallenFigures {
  // Shares of the starts that stand and track again within 3 and 5 s and keep
  // to it to the end, [0, 1].
  double recovered_3_s = 0;
  double recovered_5_s = 0;
  std::vector<FallenRow> rows = {};  // by state
};

struct FallenEvaluation {
  int starts = 0;
  uint64_t seed = 0;  // of the fallen states
  int clips = 0;      // that are tracked, one start after another
  // Of each start, and of it those in which the reference stands.
  double seconds = 0;
  double reference_stands_seconds = 0;
  FallenFigures policy;
  FallenFigures zero_action;
  // With a get-up for a reference, then whatever clip is near
  // (actor::GetUpStarts); none where the library has no get-up.
  struct GetUp {
    double reference_stands_seconds = 0;
    FallenFigures policy;
    FallenFigures zero_action;
  };
  std::optional<GetUp> get_up = std::nullopt;
};

// Of starts that all name a fallen state.
FallenFigures FiguresOf(const std::vector<v1::EvaluationResult>& results,
                        double control_hz);

// INVALID_ARGUMENT unless `starts` is 1 to kMostFallenStarts.
absl::Status CheckFallenStarts(int starts);

// The first `starts` of the states that are for measuring alone
// (FallenStates::MakeForEvaluation), with the default physics: the same bodies
// for whatever was trained on this character, and none that was trained on.
// `character` as in Character::Load. Blocking: compiles and simulates, about
// 15 ms per state. Errors: those of Character::Load and of FallenStates::Make.
absl::StatusOr<std::unique_ptr<const world::FallenStates>> MakeFallenStates(
    const std::string& character, int starts);

// One start from each of the subject's fallen states (actor::FallenStarts), of
// the policy and of the zero action, and, where the library has get-ups, one on
// such a reference. Same inputs, same bits, however many threads. Blocking and
// errors: those of RunStarts; FAILED_PRECONDITION: the subject has no fallen
// states; NOT_FOUND: no clip of its library is fit to stand up beside, whether
// it has get-ups or not.
absl::StatusOr<FallenEvaluation> EvaluateFallen(const Subject& subject,
                                                int threads,
                                                const StopToken& stop);

}  // namespace sinew::evaluation

#endif  // SINEW_TOOLS_EVALUATION_FALLEN_FIGURES_H_
