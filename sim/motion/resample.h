#ifndef SINEW_SIM_MOTION_RESAMPLE_H_
#define SINEW_SIM_MOTION_RESAMPLE_H_

#include <Eigen/Geometry>
#include <vector>

#include "absl/types/span.h"

namespace sinew::motion {

// Interpolation of keys at other times. Passes through every key with a
// continuous velocity (cubic Hermite with Catmull-Rom tangents, for rotations
// in the tangent space of the key before), so keys slower than the samples give
// no kinks; between two keys of constant velocity it is the straight line, for
// rotations slerp.
//
// `key_times` rise strictly, at least two; one value per key. Samples outside
// the keys continue with the velocity at the end. Thread-safety: pure.
std::vector<Eigen::Vector3d> ResampleVectors(
    absl::Span<const double> key_times, absl::Span<const Eigen::Vector3d> keys,
    absl::Span<const double> sample_times);

// Unit quaternions; neighbouring keys less than pi apart. The result is
// continuous in sign.
std::vector<Eigen::Quaterniond> ResampleRotations(
    absl::Span<const double> key_times,
    absl::Span<const Eigen::Quaterniond> keys,
    absl::Span<const double> sample_times);

// Sample times of a clip of `duration` seconds at about `rate` per second:
// evenly spaced over the whole clip, at least two; n samples without the end
// for a looping clip (the end is the next cycle's first), n + 1 with it for
// others, n = round(duration * rate). Played at exactly `rate` the clip then
// lasts n / rate instead of `duration`.
std::vector<double> SampleTimes(double duration, double rate, bool loops);

}  // namespace sinew::motion

#endif  // SINEW_SIM_MOTION_RESAMPLE_H_
