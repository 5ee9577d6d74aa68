#ifndef SINEW_SIM_WORLD_REFERENCE_OBSERVATIONS_H_
#define SINEW_SIM_WORLD_REFERENCE_OBSERVATIONS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "sim/motion/feature_file.h"
#include "sim/world/tracking_task.h"

namespace sinew::world {

// What a tracking task's policy would see if the body were exactly on the
// reference: for every frame t of every clip
//
//   o_t = Observe(body = reference(t), reference(t + k) for k in frames_ahead)
//
// with the previous target at the reference's joint positions (so the block
// PREVIOUS_TARGET is 0) and, as the body's own foot contact, the clip's label.
// Computed once into a file beside the library and mapped. For whoever wants
// to know an observation's scale or distribution before any policy has run:
// first normaliser statistics, demonstrations of a discriminator.
//
// Thread-safety: immutable. Ownership: borrows the task's library, not the
// task. Blocking: Open computes (seconds per hour of clips) or opens; Row may
// wait for a page of the disk. Errors: those of the feature file.
class ReferenceObservations {
 public:
  // `directory`: where "observations.features.safetensors" is or goes, the
  // library's.
  static absl::StatusOr<std::unique_ptr<const ReferenceObservations>> Open(
      const TrackingTask& task, const std::string& directory);

  // The task's observation_width().
  int width() const { return width_; }
  // [width] float32, not normalised, columns as the task's ObservationNames().
  // Precondition: 0 <= frame < num_frames of the clip.
  absl::Span<const float> Row(int clip, int64_t frame) const;

  const motion::FeatureFile& file() const { return *file_; }

 private:
  ReferenceObservations(const motion::Library& library, int width,
                        std::unique_ptr<const motion::FeatureFile> file)
      : library_(&library),
        width_(width),
        file_(std::move(file)),
        rows_(file_->tensor("observation")) {}

  const motion::Library* library_;
  int width_;
  std::unique_ptr<const motion::FeatureFile> file_;
  absl::Span<const float> rows_;  // [N, width]
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_REFERENCE_OBSERVATIONS_H_
