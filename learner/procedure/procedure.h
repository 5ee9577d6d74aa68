#ifndef SINEW_LEARNER_PROCEDURE_PROCEDURE_H_
#define SINEW_LEARNER_PROCEDURE_PROCEDURE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/types/span.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// The PHC+ procedure (Luo et al., PULSE, 2024) as a sequence of trainings, each
// decided from how those before it ended:
//
//   kFull      primitive 0 on all clips
//   kHard      the same primitive goes on on the hard set
//   kGrown     the next primitive, from the weights before, on the hard set
//   kRecovery  one more primitive, from the last that tracks, on all clips,
//              with starts on the floor and from afar
//   kComposer  chooses among all primitives, frozen, on all clips
//   kSingle    primitive 0 goes on from kFull by itself, on all clips, for as
//              many samples as all stages after that one took: for comparison
//
// The hard set: the clips that no primitive wins by the final evaluation of its
// latest stage. After each stage that tracks:
//
//   1. at most negligible_clips are left           -> no more tracking
//   2. the stage was on a hard set and won less
//      than learnable_share of it                  -> no more tracking
//   3. the stage was kFull or kGrown               -> kHard
//   4. there are max_primitives                    -> no more tracking
//   5. otherwise                                   -> kGrown
//
// Then kRecovery (if recovery_samples > 0), kComposer (if composer_samples > 0
// and there are two primitives or more); then it is decided what the procedure
// comes to, kSingle follows (if compare_single, and there were stages after
// kFull) and decides nothing, and that is the end.
//
// Everything here is pure and thread-safe; nothing blocks or fails.

enum class StageKind { kFull, kHard, kGrown, kRecovery, kComposer, kSingle };

// Whether a stage's starts lie on the clips that no primitive wins.
bool IsOnHardSet(StageKind kind);

// One training.
struct Stage {
  StageKind kind = StageKind::kFull;
  // Number of the primitive, from 0; the recovery one comes after those that
  // track. Of the composer: how many it has.
  int primitive = 0;
  // Index of the stage whose final weights it begins with; -1: none.
  int from = -1;
  // Clips that episodes start in; empty: all that are trained on.
  std::vector<std::string> clips;
  // Composer only: the latest stage of each primitive.
  std::vector<int> primitives;
  // kSingle only: after how many it ends. 0: the recipe says it.
  int64_t samples = 0;

  bool operator==(const Stage&) const = default;
};

// What is known of a stage that has ended.
struct FinishedStage {
  Stage stage;
  bool plateau = false;  // ended there, else after its samples
  int64_t iterations = 0;
  int64_t samples = 0;
  double train_seconds = 0;
  // What its plateau rests on: the best share of starts that succeeded, and
  // evaluations in a row without a gain. 0 where there were none.
  double best_share = 0;
  int stalled = 0;
  // Clips trained on, of the whole library, that its final weights fail.
  std::vector<std::string> failed;
};

// What a decision rests on.
struct Evidence {
  int clips = 0;                  // that are trained on
  std::vector<std::string> hard;  // that no primitive wins, in their order
  // Of the latest stage that tracks, if it was on a hard set: the set's size,
  // how many of it that stage won, and how many clips of `hard` are not in the
  // set, since some primitive won them before.
  int hard_before = 0;
  int hard_won = 0;
  int forgotten = 0;

  bool operator==(const Evidence&) const = default;
};

struct Decision {
  std::optional<Stage> next;  // unset: the procedure is over
  std::string reason;         // in words and numbers, for people
  Evidence evidence;
};

// "primitive_0", "primitive_0_hard", "primitive_1", "recovery", "composer",
// "single".
std::string StageName(const Stage& stage);

// "full", "hard", "grown", "recovery", "composer", "single".
std::string KindName(StageKind kind);
std::optional<StageKind> KindOfName(const std::string& name);

// What comes after the finished stages. `clips`: names of those trained on, in
// the library's order, not empty. `procedure` has its defaults filled.
Decision NextStage(const v1::Procedure& procedure,
                   const std::vector<std::string>& clips,
                   absl::Span<const FinishedStage> finished);

// Index of the stage that the procedure came to, of at least one: that which
// fails the fewest clips, the latest of equals, so that a composer has to be
// worth it. Where one was trained to recover, only it and the composer count:
// a policy that does not get up is not what was asked for. Never kSingle.
int ResultStage(absl::Span<const FinishedStage> finished);

// What the finished stages of the procedure took: all but kSingle.
struct Cost {
  int64_t samples = 0;
  double train_seconds = 0;
};
Cost CostOf(absl::Span<const FinishedStage> finished);

// The procedure beside the single primitive.
struct Comparison {
  struct Side {
    int stage = 0;        // index of the one whose last weights are compared
    int64_t samples = 0;  // of all stages that it took to get there
    int failed = 0;       // clips trained on that those weights fail
  };
  Side procedure;  // took all stages but kSingle
  Side single;     // took kFull and kSingle
};
// Unset before kSingle has ended.
std::optional<Comparison> Compare(absl::Span<const FinishedStage> finished);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_PROCEDURE_PROCEDURE_H_
