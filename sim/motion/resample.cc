#include "sim/motion/resample.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "sim/motion/rotation.h"

namespace sinew::motion {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Tangents at the keys from the velocities between them: the velocity of the
// parabola through a key and its neighbours, one-sided at the ends.
std::vector<Vector3d> Tangents(absl::Span<const double> times,
                               const std::vector<Vector3d>& velocity) {
  std::vector<Vector3d> tangents = {velocity.front()};
  for (size_t i = 1; i < velocity.size(); ++i) {
    const double before = times[i] - times[i - 1];
    const double after = times[i + 1] - times[i];
    tangents.push_back((after * velocity[i - 1] + before * velocity[i]) /
                       (before + after));
  }
  tangents.push_back(velocity.back());
  return tangents;
}

// Where a sample falls: interval, and time since the interval's first key.
struct Place {
  size_t interval;
  double elapsed;
  double length;
};

Place Find(absl::Span<const double> times, double sample) {
  const auto after = std::upper_bound(times.begin(), times.end(), sample);
  const int64_t index = std::clamp<int64_t>(
      after - times.begin() - 1, 0, static_cast<int64_t>(times.size()) - 2);
  return {static_cast<size_t>(index), sample - times[index],
          times[index + 1] - times[index]};
}

// The cubic from 0 to `end` over `length` with the given velocities, straight
// outside.
Vector3d Hermite(const Vector3d& end, const Vector3d& velocity_begin,
                 const Vector3d& velocity_end, const Place& place) {
  if (place.elapsed < 0) return place.elapsed * velocity_begin;
  if (place.elapsed > place.length) {
    return end + (place.elapsed - place.length) * velocity_end;
  }
  const double s = place.elapsed / place.length;
  return s * s * (3 - 2 * s) * end +
         place.length * s * (1 - s) * (1 - s) * velocity_begin -
         place.length * s * s * (1 - s) * velocity_end;
}

}  // namespace

std::vector<Vector3d> ResampleVectors(absl::Span<const double> key_times,
                                      absl::Span<const Vector3d> keys,
                                      absl::Span<const double> sample_times) {
  SINEW_CHECK(keys.size() >= 2 && keys.size() == key_times.size());
  std::vector<Vector3d> velocity;
  for (size_t i = 0; i + 1 < keys.size(); ++i) {
    velocity.push_back((keys[i + 1] - keys[i]) /
                       (key_times[i + 1] - key_times[i]));
  }
  const std::vector<Vector3d> tangents = Tangents(key_times, velocity);
  std::vector<Vector3d> samples;
  for (const double time : sample_times) {
    const Place place = Find(key_times, time);
    const size_t i = place.interval;
    samples.push_back(keys[i] + Hermite(keys[i + 1] - keys[i], tangents[i],
                                        tangents[i + 1], place));
  }
  return samples;
}

std::vector<Quaterniond> ResampleRotations(
    absl::Span<const double> key_times, absl::Span<const Quaterniond> keys,
    absl::Span<const double> sample_times) {
  SINEW_CHECK(keys.size() >= 2 && keys.size() == key_times.size());
  std::vector<Vector3d> velocity;  // in the body's frame at either key
  for (size_t i = 0; i + 1 < keys.size(); ++i) {
    velocity.push_back(Log(keys[i].conjugate() * keys[i + 1]) /
                       (key_times[i + 1] - key_times[i]));
  }
  const std::vector<Vector3d> tangents = Tangents(key_times, velocity);
  std::vector<Quaterniond> samples;
  for (const double time : sample_times) {
    const Place place = Find(key_times, time);
    const size_t i = place.interval;
    const Vector3d end = velocity[i] * place.length;
    const Vector3d r = Hermite(
        end, tangents[i], InverseRightJacobian(end) * tangents[i + 1], place);
    const Quaterniond q = (keys[i] * Exp(r)).normalized();
    samples.push_back(samples.empty() ? q : Near(q, samples.back()));
  }
  return samples;
}

std::vector<double> SampleTimes(double duration, double rate, bool loops) {
  const auto intervals = std::max<int64_t>(
      loops ? 2 : 1, static_cast<int64_t>(std::llround(duration * rate)));
  std::vector<double> times;
  for (int64_t i = 0; i < intervals + (loops ? 0 : 1); ++i) {
    times.push_back(duration * static_cast<double>(i) /
                    static_cast<double>(intervals));
  }
  return times;
}

}  // namespace sinew::motion
