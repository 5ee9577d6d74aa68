#ifndef SINEW_TOOLS_RENDER_FOLLOWING_CAMERA_H_
#define SINEW_TOOLS_RENDER_FOLLOWING_CAMERA_H_

#include "absl/types/span.h"
#include "tools/render/offscreen_renderer.h"

namespace sinew::render {

// Stands to the right of where a body first faces and follows its root over
// the ground. Poses are qpos whose first joint is free: [>= 7].
class FollowingCamera {
 public:
  explicit FollowingCamera(absl::Span<const double> first_pose);

  Camera At(absl::Span<const double> pose) const;

 private:
  const double azimuth_deg_;
};

}  // namespace sinew::render

#endif  // SINEW_TOOLS_RENDER_FOLLOWING_CAMERA_H_
