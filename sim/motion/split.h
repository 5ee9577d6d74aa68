#ifndef SINEW_SIM_MOTION_SPLIT_H_
#define SINEW_SIM_MOTION_SPLIT_H_

#include <string>

#include "absl/strings/string_view.h"
#include "proto/sinew/v1/motion.pb.h"

namespace sinew::motion {

// The split of a library into clips that are trained on and clips that are left
// out, by a rule: whoever imports the same recordings, in whatever order and
// company, leaves out the same ones.

// What must be on one side: the recording (ClipInfo.trial, the same for every
// file format, trim and mirror image), else the name of the clip without
// "_mirror". Pure.
std::string SplitKey(const v1::ClipInfo& clip);

// True for about `share`, [0, 1], of all keys: those whose SHA-256, read as a
// fraction, is below it. What is left out at one share is so at every greater
// one. Pure.
bool IsLeftOut(absl::string_view split_key, double share);

// The same for a clip; one that was joined from two recordings is left out if
// either is. The second goes by its trial, else by the name of its file without
// extension and "_mirror".
bool IsLeftOut(const v1::ClipInfo& clip, double share);

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_SPLIT_H_
