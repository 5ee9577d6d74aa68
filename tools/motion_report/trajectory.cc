#include "tools/motion_report/trajectory.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "common/status_macros.h"

namespace sinew::motion_report {
namespace {

constexpr double kPerMetre = 1000;
constexpr double kPerUnit = 32767;
// How far a root may go, m: what 16 bits hold, with room for limbs.
constexpr double kReach = 30;

void Append(double value, std::string* bytes) {
  const auto packed = static_cast<uint16_t>(static_cast<int16_t>(
      std::lround(std::clamp(value, -kPerUnit, kPerUnit))));
  bytes->push_back(static_cast<char>(packed & 0xFF));
  bytes->push_back(static_cast<char>(packed >> 8));
}

absl::StatusOr<const HostTensor*> Find(const TensorMap& frames,
                                       const std::string& name, int width) {
  const auto found = frames.find(name);
  if (found == frames.end() || found->second.shape.size() != 3 ||
      found->second.shape[0] < 1 || found->second.shape[2] != width ||
      found->second.dtype != v1::DATA_TYPE_FLOAT32) {
    return absl::InvalidArgumentError(absl::StrCat(
        "clip: tensor ", name, ": expected [frames, bodies, ", width, "]"));
  }
  return &found->second;
}

// Points less the place over the floor where the root begins.
std::string PackPoints(absl::Span<const float> points, double x, double y) {
  std::string bytes;
  bytes.reserve(2 * points.size());
  for (size_t i = 0; i + 2 < points.size(); i += 3) {
    Append(kPerMetre * (points[i] - x), &bytes);
    Append(kPerMetre * (points[i + 1] - y), &bytes);
    Append(kPerMetre * points[i + 2], &bytes);
  }
  return bytes;
}

}  // namespace

absl::StatusOr<Trajectory> MakeTrajectory(const TensorMap& frames, double rate,
                                          const import::SourcePreview& source) {
  SINEW_ASSIGN_OR_RETURN(const HostTensor* position,
                         Find(frames, "body_position", 3));
  SINEW_ASSIGN_OR_RETURN(const HostTensor* rotation,
                         Find(frames, "body_rotation", 4));
  const int64_t count = position->shape[0], bodies = position->shape[1];
  const auto points = position->float32();
  const auto turns = rotation->float32();
  if (turns.size() != static_cast<size_t>(count * bodies * 4)) {
    return absl::InvalidArgumentError(
        "clip: body_position and body_rotation: expected as many frames");
  }
  // The same step as that of the source's preview.
  const auto step =
      static_cast<int64_t>(std::max(1.0, std::round(rate / kShownRate)));
  Trajectory shown;
  shown.frames_per_second = rate / static_cast<double>(step);
  const auto limit = static_cast<int64_t>(
                         std::lround(kShownSeconds * shown.frames_per_second)) +
                     1;
  const int64_t available = (count + step - 1) / step;
  shown.frames = static_cast<int>(std::min(limit, available));
  shown.cut = available > limit;
  shown.bodies = static_cast<int>(bodies);
  const double x = points[0], y = points[1];
  std::string place, turn;
  for (int64_t t = 0; t < shown.frames; ++t) {
    const size_t row = static_cast<size_t>(t * step * bodies);
    if (std::hypot(points[3 * row] - x, points[3 * row + 1] - y) > kReach) {
      shown.frames = static_cast<int>(t);
      shown.cut = true;
      break;
    }
    place += PackPoints(points.subspan(3 * row, 3 * bodies), x, y);
    for (const float value : turns.subspan(4 * row, 4 * bodies)) {
      Append(kPerUnit * value, &turn);
    }
  }
  shown.body_position = absl::Base64Escape(place);
  shown.body_rotation = absl::Base64Escape(turn);
  if (source.frames() == 0) return shown;
  shown.frames = std::min(shown.frames, source.frames());
  shown.source_parents = source.parents;
  shown.source_position = absl::Base64Escape(PackPoints(
      absl::MakeConstSpan(source.positions)
          .subspan(0, 3 * static_cast<size_t>(shown.frames) * source.joints()),
      x, y));
  return shown;
}

}  // namespace sinew::motion_report
