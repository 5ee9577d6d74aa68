#ifndef SINEW_SIM_IMPORT_FORMATS_FILE_FRAME_H_
#define SINEW_SIM_IMPORT_FORMATS_FILE_FRAME_H_

#include <optional>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "sim/import/formats/source_clip.h"

namespace sinew::import {

// From a file's units, axes and rate to the world's (source_clip.h): what the
// user says goes first, then what the file says, then what its numbers tell.
//
// Thread-safety: pure functions. Blocking: never. Errors: as stated; messages
// name the source, expected and found.

// What a file says of its frame; unset: nothing.
struct FileFrame {
  std::optional<double> metres_per_unit;
  std::optional<char> up_axis;
  // A convention of the format that not every file keeps: taken if the
  // skeleton is then of a person's size.
  std::optional<double> usual_metres_per_unit;
};

// Frame rates that any file may have, 1/s.
inline constexpr double kMinFramesPerSecond = 1e-3;
inline constexpr double kMaxFramesPerSecond = 1e4;

// INVALID_ARGUMENT unless what is set makes sense: metres_per_unit in
// [1e-6, 1e3], up_axis x, y or z, frames_per_second in the range above,
// quaternion_order wxyz or xyzw.
absl::Status CheckReadOptions(const ReadOptions& options);

// Of a format whose unit and up axis are fixed, so that nothing can be said of
// a file's: INVALID_ARGUMENT if the user says otherwise.
absl::Status CheckFixedFrame(const ReadOptions& options, double metres_per_unit,
                             char up_axis, absl::string_view format,
                             absl::string_view source);

// Moves skeleton and poses of a clip from the file's axes and units into the
// world; notes metres_per_unit and up_axis in clip.facts, and in `concluded`
// if neither user nor file said them.
//
// Unit: of 1, 0.1, 0.01, 0.001, 0.0254 and 0.0564444 m (the last: CMU's) the
// one that makes the legs nearest to a person's, by ratio; where none does, the
// one that makes them a person's, with a warning. Up: the axis, y or z, that
// points from the feet to the hips and on to the head in the rest pose, else
// over the clip in the mean; without feet the one that the root keeps its
// height along. Feet and heads are known by their joints' names.
void MoveToWorld(const FileFrame& file, const ReadOptions& options,
                 SourceClip& clip);

// Spaces the poses (at least one) evenly and notes rate and duration. A single
// pose is held for one frame, with a warning. INVALID_ARGUMENT: longer than
// kMaxClipSeconds.
absl::Status SetTimes(double frames_per_second, absl::string_view source,
                      SourceClip& clip);

// Files round the time of a frame to a few digits: a rate within 0.02 % of a
// whole number is that number.
double RateOfFrameTime(double seconds);

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_FORMATS_FILE_FRAME_H_
