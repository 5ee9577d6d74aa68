#ifndef SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_CHECK_H_
#define SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_CHECK_H_

#include "absl/status/status.h"
#include "proto/sinew/v1/motion.pb.h"
#include "proto/sinew/v1/recipe.pb.h"

namespace sinew::learner {

// INVALID_ARGUMENT if start.only_clips names a clip that the library does not
// have (with the nearest name) or that is left out of training. Pure.
absl::Status CheckOnlyClips(const v1::Start& start,
                            const v1::MotionLibrary& library);

}  // namespace sinew::learner

#endif  // SINEW_LEARNER_CURRICULUM_ONLY_CLIPS_CHECK_H_
