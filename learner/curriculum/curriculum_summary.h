#ifndef SINEW_LEARNER_CURRICULUM_CURRICULUM_SUMMARY_H_
#define SINEW_LEARNER_CURRICULUM_CURRICULUM_SUMMARY_H_

#include <cstdint>
#include <vector>

#include "learner/curriculum/start_rule.h"
#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// What there is to say of a curriculum table. Pure; nothing blocks or fails.

struct CurriculumSummary {
  int clips = 0;  // that are trained on
  int left_out_clips = 0;
  // Of `clips`, those that starts are drawn from (StartRule::Draws): all,
  // unless the recipe names some. All below is of these alone, but for
  // evaluations.
  int drawn_clips = 0;
  int bins = 0;
  // Of the start probabilities over bins, nats, and relative to that of the
  // uniform rule (1 where there is one bin alone): less is more focused. It may
  // be above 1, since bins are not of one length.
  double entropy = 0;
  double entropy_share = 1;
  double floor_share = 0;         // StartRule::FloorShare
  double largest_clip_share = 0;  // of the starts
  int clips_of_half = 0;          // fewest that have half of the starts
  double failure_rate = 0;        // recent, smoothed, mean over bins by frames
  // Of the tenth of the bins (rounded up) with the highest rates: their share
  // of the starts and mean rate.
  double hardest_share = 0;
  double hardest_failure_rate = 0;
  // Of clips that are trained on: those that were evaluated, those of them that
  // failed the latest time, and the mean share of starts that succeeded, over
  // the worst tenth of them (rounded up; 0 if none was evaluated).
  int evaluated_clips = 0;
  int hard_clips = 0;
  double worst_success = 0;
};

CurriculumSummary Summarise(const v1::CurriculumTable& table,
                            const StartRule& rule);

// Sums over the bins of one clip; zeros and last_seen -1 for a left-out one.
struct ClipStatistics {
  int bins = 0;
  int64_t visits = 0;
  int64_t failures = 0;
  double failure_rate = 0;  // recent, smoothed, mean over bins by frames
  double probability = 0;
  int64_t last_seen = -1;  // of the bin that was seen last
};

// By clip: as many as table.clips, or as the bins name.
std::vector<ClipStatistics> StatisticsByClip(const v1::CurriculumTable& table);

// The `count` bins, or all, with the highest recent failure rates, highest
// first, of equals the first.
std::vector<int> HardestBins(const v1::CurriculumTable& table, int count);

// The `count` clips that are trained on, or all, hardest first: by the share of
// starts that failed their latest evaluation, then by recent failure rate, of
// equals the first. Given DrawnPart of a table, of the clips that starts are
// drawn from.
std::vector<int> HardestClips(const v1::CurriculumTable& table, int count);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_CURRICULUM_SUMMARY_H_
