#ifndef SINEW_TOOLS_ZOO_CARD_CHAPTERS_H_
#define SINEW_TOOLS_ZOO_CARD_CHAPTERS_H_

namespace sinew::zoo {

// The chapters that every model card has, in order: what writes them and what
// looks for them (zoo_entry.h) call them by the same names.

inline constexpr char kTrainedOn[] = "## Trained on";
inline constexpr char kTraining[] = "## Training";
inline constexpr char kMetrics[] = "## Metrics";
inline constexpr char kLimitations[] = "## Limitations";
inline constexpr char kReproduce[] = "## How to make it again";
inline constexpr char kLoad[] = "## How to load it";

inline constexpr const char* kChapters[] = {kTrainedOn,   kTraining,  kMetrics,
                                            kLimitations, kReproduce, kLoad};

// How the text of what a prior does alone begins, among the metrics.
inline constexpr char kPriorAlone[] = "Its prior alone, ";

}  // namespace sinew::zoo

#endif  // SINEW_TOOLS_ZOO_CARD_CHAPTERS_H_
