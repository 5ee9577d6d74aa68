#ifndef SINEW_LEARNER_CURRICULUM_BIN_SUMS_H_
#define SINEW_LEARNER_CURRICULUM_BIN_SUMS_H_

#include <vector>

#include "proto/sinew/v1/snapshot.pb.h"

namespace sinew::learner {

// Sums over the bins of a curriculum table, and what rules make of them. Pure;
// nothing blocks or fails.

// Frames of all bins.
double TotalFrames(const v1::CurriculumTable& table);

// Frames of each clip's bins, by clip: at least as many as table.clips; 0 for
// clips without bins.
std::vector<double> FramesByClip(const v1::CurriculumTable& table);

// Start probability of each clip, likewise.
std::vector<double> ShareByClip(const v1::CurriculumTable& table);

// Smoothed share of recent passages through a bin that failed or led to a
// failure: (failures + 1) / (passages + 2), within (0, 1); 1/2 where nothing
// was seen.
double RecentFailureRate(const v1::CurriculumTable::Bin& bin);

// Divides all probabilities by their sum, which must be > 0.
void Normalise(v1::CurriculumTable& table);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_BIN_SUMS_H_
