#include "tools/motion_report/strips.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/memory/memory.h"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "common/status_macros.h"
#include "tools/render/film_strip.h"
#include "tools/render/image.h"

namespace sinew::motion_report {
namespace {

constexpr int kColumns = 8;
constexpr int kWidth = 150, kHeight = 220;
constexpr int kQuality = 80;

absl::StatusOr<absl::Span<const float>> Rows(const TensorMap& frames,
                                             const std::string& name,
                                             size_t width) {
  const auto found = frames.find(name);
  if (found == frames.end() || found->second.shape.empty() ||
      found->second.dtype != v1::DATA_TYPE_FLOAT32 ||
      found->second.float32().size() !=
          width * static_cast<size_t>(found->second.shape[0])) {
    return absl::InvalidArgumentError(absl::StrCat(
        "clip: tensor ", name, ": expected rows of ", width, " numbers"));
  }
  return found->second.float32();
}

// [frames, nq]
absl::StatusOr<std::vector<double>> Poses(const character::Character& character,
                                          const TensorMap& frames) {
  const size_t joints = character.joints().size();
  const auto nq = static_cast<size_t>(character.model()->nq);
  SINEW_ASSIGN_OR_RETURN(const auto position, Rows(frames, "root_position", 3));
  SINEW_ASSIGN_OR_RETURN(const auto rotation, Rows(frames, "root_rotation", 4));
  SINEW_ASSIGN_OR_RETURN(const auto angles,
                         Rows(frames, "joint_position", joints));
  const size_t count = position.size() / 3;
  if (rotation.size() / 4 != count || angles.size() != joints * count) {
    return absl::InvalidArgumentError(
        "clip: expected tensors of equally many frames");
  }
  std::vector<double> poses(count * nq);
  for (size_t t = 0; t < count; ++t) {
    double* row = poses.data() + t * nq;
    std::copy_n(position.data() + 3 * t, 3, row);
    std::copy_n(rotation.data() + 4 * t, 4, row + 3);
    for (size_t j = 0; j < joints; ++j) {
      row[character.joints()[j].qpos_address] = angles[t * joints + j];
    }
  }
  return poses;
}

}  // namespace

absl::StatusOr<std::unique_ptr<StripDrawer>> StripDrawer::Create(
    const character::Character& character) {
  SINEW_ASSIGN_OR_RETURN(auto renderer,
                         render::OffscreenRenderer::Create(
                             render::PictureModel(character), kWidth, kHeight));
  return absl::WrapUnique(new StripDrawer(character, std::move(renderer)));
}

StripDrawer::StripDrawer(const character::Character& character,
                         std::unique_ptr<render::OffscreenRenderer> renderer)
    : character_(character), renderer_(std::move(renderer)) {}

absl::StatusOr<std::string> StripDrawer::Draw(const TensorMap& frames,
                                              double rate) {
  SINEW_ASSIGN_OR_RETURN(const std::vector<double> poses,
                         Poses(character_, frames));
  SINEW_ASSIGN_OR_RETURN(
      const render::Image strip,
      render::ReferenceStrip(*renderer_,
                             {poses, static_cast<int>(character_.model()->nq)},
                             kColumns, rate));
  return render::JpegDataUri(strip, kQuality);
}

}  // namespace sinew::motion_report
