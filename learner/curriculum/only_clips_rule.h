#ifndef SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_RULE_H_
#define SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_RULE_H_

#include <memory>
#include <set>
#include <string>

#include "learner/curriculum/start_rule.h"

namespace sinew::learner {

// Another rule, on a table that holds the bins of the named clips alone:
// shares, floors and caps are those of a library of these clips. All other bins
// have probability 0, or share `others` between them, [0, 1), by the same rule
// on a table that holds them alone; clips of which there are none give their
// share to the rest. A table must name its clips, as it does since they are
// remembered, or the rule takes all for others.
std::unique_ptr<StartRule> MakeOnlyClipsRule(std::set<std::string> names,
                                             double others,
                                             std::unique_ptr<StartRule> rule);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_RULE_H_
