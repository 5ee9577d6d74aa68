#ifndef SINEW_LEARNER_CURRICULUM_START_RULE_H_
#define SINEW_LEARNER_CURRICULUM_START_RULE_H_

#include <memory>

#include "absl/functional/function_ref.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// Turns the statistics of a table into start probabilities. Only clips with
// bins are drawn from; left-out ones have none. Where a rule draws from some of
// them alone (only_clips_rule.h), the others keep their bins and have
// probability 0, unless they are given a share.
//
// Thread-safety: stateless. Ownership: borrows the table for a call. Blocking:
// never. Errors: none; probabilities are >= 0 and sum to 1 but for rounding
// (1e-12), the same for the same table, bit for bit.
class StartRule {
 public:
  virtual ~StartRule() = default;
  // Sets `probability` of every bin from the statistics; at least one bin that
  // it draws from.
  virtual void Weigh(v1::CurriculumTable& table) const = 0;
  // Share of the starts that the rule gives whatever the statistics say,
  // [0, 1].
  virtual double FloorShare(const v1::CurriculumTable& table) const = 0;
  // Whether a clip that has bins is one of those that starts are drawn from,
  // whatever the statistics say.
  virtual bool Draws(const v1::CurriculumTable& table, int clip) const;
};

// The table with the bins alone of the clips that `keeps`; all clips stay.
v1::CurriculumTable PartOf(const v1::CurriculumTable& table,
                           absl::FunctionRef<bool(int clip)> keeps);
// Of those that the rule draws from.
v1::CurriculumTable DrawnPart(const v1::CurriculumTable& table,
                              const StartRule& rule);

// Every frame of every clip alike: probability proportional to bin frames.
std::unique_ptr<StartRule> MakeUniformRule();

// Proportional to frames times the smoothed failure rate of the whole run,
// (failures + 1) / (visits + 2), mixed with `uniform_share` of the uniform
// rule, which guarantees every bin its floor.
std::unique_ptr<StartRule> MakeFailureRateRule(double uniform_share);

// PHC's rules, within a clip uniform over frames:
//   soft  a clip's share is that of its failed evaluations in all of them; all
//         clips alike if none failed its latest evaluation
//   hard  clips that failed their latest evaluation alike, others never; all
//         clips alike if none failed
// Clips that never failed have probability 0 once another has failed.
std::unique_ptr<StartRule> MakePhcSoftRule();
std::unique_ptr<StartRule> MakePhcHardRule();

// Recent failures above a floor and below a cap: adaptive_bins.h. Defaults
// filled.
std::unique_ptr<StartRule> MakeAdaptiveBinsRule(
    const v1::AdaptiveBins& adaptive);

// The rule in force under a recipe, of only_clips if some are named; UNIFORM if
// unset.
std::unique_ptr<StartRule> MakeStartRule(const v1::Start& start);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_START_RULE_H_
