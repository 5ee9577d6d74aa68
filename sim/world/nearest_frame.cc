#include "sim/world/nearest_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::world {
namespace {

// [6 B] what bodies are compared by.
void Describe(const BodyState& body, float* out) {
  const Eigen::Quaterniond back = Heading(body.rotation[0]).conjugate();
  const Eigen::Vector3d origin(body.position[0].x(), body.position[0].y(), 0);
  for (size_t b = 0; b < body.position.size(); ++b) {
    const Eigen::Vector3d position = back * (body.position[b] - origin);
    const Eigen::Vector3d velocity =
        back * (NearestFrames::kVelocitySeconds * body.linear_velocity[b]);
    for (int i = 0; i < 3; ++i) {
      *out++ = static_cast<float>(position[i]);
      *out++ = static_cast<float>(velocity[i]);
    }
  }
}

std::vector<StartFrame> Candidates(const v1::Start& recipe,
                                   const motion::Library& library,
                                   double seconds) {
  const int64_t ahead =
      std::llround(seconds * library.manifest().frames_per_second());
  std::vector<StartFrame> all;
  for (int c = 0; c < library.num_clips(); ++c) {
    const v1::ClipInfo& clip = library.clip(c);
    if (!IsDrawn(recipe, clip)) continue;
    const int64_t last = std::min(int64_t{NumStartFrames(clip)} - 1,
                                  motion::LastFrame(clip) - ahead);
    for (int64_t frame = 0; frame <= last; ++frame) {
      all.push_back({.clip = c, .frame = static_cast<int32_t>(frame)});
    }
  }
  return all;
}

// Every n-th, so that there are at most so many.
std::vector<StartFrame> Thin(const std::vector<StartFrame>& all, int64_t most) {
  const auto limit = static_cast<size_t>(most);
  const size_t every = (all.size() + limit - 1) / limit;
  std::vector<StartFrame> kept;
  for (size_t i = 0; i < all.size(); i += every) kept.push_back(all[i]);
  return kept;
}

}  // namespace

NearestFrames::NearestFrames(const v1::Start& recipe,
                             const motion::Library& library,
                             const BodyReader& reader, double seconds,
                             int64_t most)
    : NearestFrames(Candidates(recipe, library, seconds), library, reader,
                    most) {}

NearestFrames::NearestFrames(const std::vector<StartFrame>& frames,
                             const motion::Library& library,
                             const BodyReader& reader, int64_t most)
    : frames_(Thin(frames, most)) {
  const int bodies = reader.num_bodies();
  features_.resize(static_cast<int64_t>(frames_.size()), 6 * bodies);
  BodyState body(bodies, reader.num_joints());
  for (size_t i = 0; i < frames_.size(); ++i) {
    reader.Read(library.frame(frames_[i].clip, frames_[i].frame), &body);
    Describe(body, features_.row(static_cast<int64_t>(i)).data());
  }
}

std::optional<StartFrame> NearestFrames::Find(const BodyState& body,
                                              absl::Span<float> scratch) const {
  Describe(body, scratch.data());
  const Eigen::Map<const Eigen::RowVectorXf> wanted(scratch.data(), width());
  float least = std::numeric_limits<float>::infinity();
  int64_t nearest = -1;
  for (int64_t i = 0; i < size(); ++i) {
    const float distance = (features_.row(i) - wanted).squaredNorm();
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  if (nearest < 0) return std::nullopt;
  return frames_[nearest];
}

}  // namespace sinew::world
