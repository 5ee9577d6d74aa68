#ifndef SINEW_TOOLS_CURRICULUM_SUMMARY_JSON_H_
#define SINEW_TOOLS_CURRICULUM_SUMMARY_JSON_H_

#include <nlohmann/json.hpp>

#include "learner/curriculum/curriculum_summary.h"

namespace sinew::tools {

// All fields of a summary by their names, as metrics.jsonl and `sinew
// curriculum` have them. Pure.
nlohmann::ordered_json SummaryJson(const learner::CurriculumSummary& summary);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_CURRICULUM_SUMMARY_JSON_H_
