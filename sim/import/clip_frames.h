#ifndef SINEW_SIM_IMPORT_CLIP_FRAMES_H_
#define SINEW_SIM_IMPORT_CLIP_FRAMES_H_

#include <vector>

#include "common/policy/safetensors.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/quality.h"

namespace sinew::import {

// The frame tensors of one clip as sim/motion/library.h lists them: MuJoCo's
// kinematics of every frame's qpos and qvel. `frames` from AnalyseMotion of the
// same motion.
TensorMap MakeClipFrames(Dynamics* dynamics, const ModelMotion& motion,
                         const std::vector<FrameDynamics>& frames);

// Appends the rows of `clip` to `library`, tensor by tensor; an empty library
// takes them over. Precondition: equal names and row shapes.
void AppendFrames(const TensorMap& clip, TensorMap* library);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_CLIP_FRAMES_H_
