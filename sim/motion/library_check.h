#ifndef SINEW_SIM_MOTION_LIBRARY_CHECK_H_
#define SINEW_SIM_MOTION_LIBRARY_CHECK_H_

#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/policy/safetensors.h"
#include "proto/sinew/v1/motion.pb.h"

namespace sinew::motion {

// Newest manifest version that this build reads, and the one that it writes.
inline constexpr int kLibraryFormatVersion = 1;

// manifest.json to message. INVALID_ARGUMENT naming `source`: not a manifest;
// a newer version, by number, before anything else is looked at.
absl::StatusOr<v1::MotionLibrary> ParseManifest(absl::string_view json,
                                                absl::string_view source);

// Everything that a manifest promises by itself: positive sizes, unique names,
// clips in order without gaps, finite numbers. INVALID_ARGUMENT naming
// `source`, clip and field, expected and found.
absl::Status CheckManifest(const v1::MotionLibrary& manifest,
                           absl::string_view source);

// Frame tensors by name, in whoever's memory.
using FrameTensors = std::map<std::string, TensorView>;

// What can be said of the frame tensors without reading them: all there, none
// else, shapes by the manifest, float32 at addresses fit for it. Errors name
// the tensor.
absl::Status CheckFrameShapes(const v1::MotionLibrary& manifest,
                              const FrameTensors& frames,
                              absl::string_view source);

// Every number of tensors with good shapes: finite, unit quaternions, contacts
// in [0, 1]. Errors name clip, frame and tensor.
absl::Status CheckFrameValues(const v1::MotionLibrary& manifest,
                              const FrameTensors& frames,
                              absl::string_view source);

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_LIBRARY_CHECK_H_
