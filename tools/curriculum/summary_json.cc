#include "tools/curriculum/summary_json.h"

namespace sinew::tools {

nlohmann::ordered_json SummaryJson(const learner::CurriculumSummary& summary) {
  return {{"clips", summary.clips},
          {"left_out_clips", summary.left_out_clips},
          {"drawn_clips", summary.drawn_clips},
          {"bins", summary.bins},
          {"entropy", summary.entropy},
          {"entropy_share", summary.entropy_share},
          {"floor_share", summary.floor_share},
          {"largest_clip_share", summary.largest_clip_share},
          {"clips_of_half", summary.clips_of_half},
          {"failure_rate", summary.failure_rate},
          {"hardest_share", summary.hardest_share},
          {"hardest_failure_rate", summary.hardest_failure_rate},
          {"evaluated_clips", summary.evaluated_clips},
          {"hard_clips", summary.hard_clips},
          {"worst_success", summary.worst_success}};
}

}  // namespace sinew::tools
