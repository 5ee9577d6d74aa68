#ifndef SINEW_SIM_IMPORT_APPLY_EDITS_H_
#define SINEW_SIM_IMPORT_APPLY_EDITS_H_

#include "absl/status/status.h"
#include "sim/import/edit.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/retarget.h"

namespace sinew::import {

// Edits a retargeted clip: its motion, and frames and figures anew. Figures
// that hold it against the source are those of the whole clip. The source's
// skeleton is trimmed, mirrored and moved along; of a loop that was looked for
// there is none. `mirror` is used if options.mirror. Errors: those of Edit;
// `played` is then what it was.
//
// Thread-safety: any thread. Blocking: a second per minute of motion.
absl::Status ApplyEdits(const MotionMirror& mirror, const EditOptions& options,
                        Dynamics* dynamics, Retargeted* played);

// True if the options ask for anything.
bool HasEdits(const EditOptions& options);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_APPLY_EDITS_H_
