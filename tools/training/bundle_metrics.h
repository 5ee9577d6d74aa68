#ifndef SINEW_TOOLS_TRAINING_BUNDLE_METRICS_H_
#define SINEW_TOOLS_TRAINING_BUNDLE_METRICS_H_

#include <cstdint>

#include "common/evaluation/evaluation_summary.h"
#include "proto/sinew/v1/bundle.pb.h"

namespace sinew::tools {

// What a bundle says of its policy: an evaluation of the snapshot made after
// `iteration`, which in a run's last bundle is some iterations older than the
// bundle's weights. Pure.
v1::BundleMetrics MakeBundleMetrics(const EvaluationSummary& summary,
                                    int64_t iteration);

}  // namespace sinew::tools

#endif  // SINEW_TOOLS_TRAINING_BUNDLE_METRICS_H_
