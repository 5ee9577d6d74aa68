#ifndef SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_RULE_H_
#define SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_RULE_H_

#include <memory>
#include <set>
#include <string>

#include "learner/curriculum/start_rule.h"

namespace sinew::learner {

// Another rule, on a table that holds the bins of the named clips alone:
// shares, floors and caps are those of a library of these clips. All other bins
// have probability 0. A table must name its clips, as it does since they are
// remembered, or the rule draws from none of them.
std::unique_ptr<StartRule> MakeOnlyClipsRule(std::set<std::string> names,
                                             std::unique_ptr<StartRule> rule);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_RULE_H_
