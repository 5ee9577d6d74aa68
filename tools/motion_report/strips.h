#ifndef SINEW_TOOLS_MOTION_REPORT_STRIPS_H_
#define SINEW_TOOLS_MOTION_REPORT_STRIPS_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "common/policy/safetensors.h"
#include "sim/character/character.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::motion_report {

// Film strips of clips for a page.
//
// Thread-safety: one thread at a time, always the same. Ownership: borrows the
// character. Blocking: Create ~0.3 s, Draw ~0.5 s. Errors: UNAVAILABLE without
// OpenGL; INVALID_ARGUMENT for frames of another character.
class StripDrawer {
 public:
  static absl::StatusOr<std::unique_ptr<StripDrawer>> Create(
      const character::Character& character);

  // Moments evenly spaced over the clip whose frame tensors are `frames`, as
  // "data:image/jpeg;base64,...".
  absl::StatusOr<std::string> Draw(const TensorMap& frames, double rate);

 private:
  StripDrawer(const character::Character& character,
              std::unique_ptr<render::OffscreenRenderer> renderer);

  const character::Character& character_;
  const std::unique_ptr<render::OffscreenRenderer> renderer_;
};

}  // namespace sinew::motion_report

#endif  // SINEW_TOOLS_MOTION_REPORT_STRIPS_H_
