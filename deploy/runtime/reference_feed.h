#ifndef SINEW_DEPLOY_RUNTIME_REFERENCE_FEED_H_
#define SINEW_DEPLOY_RUNTIME_REFERENCE_FEED_H_

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "deploy/runtime/pose.h"
#include "proto/sinew/v1/recipe.pb.h"
#include "sim/character/character.h"
#include "sim/character/model_ptr.h"
#include "sim/motion/library.h"
#include "sim/world/body_state.h"
#include "sim/world/nearest_frame.h"
#include "sim/world/recovery.h"

namespace sinew::runtime {

// The reference at the frames that a policy looks at: rows of a library's clip,
// or the caller's poses, whose body poses come by forward kinematics.
//
// Frames are numbered as in offsets(): first the observation's frames ahead,
// then the next frame where the action law needs it and it is not among them.
//
// Thread-safety: one caller. Ownership: borrows character, owns library and
// buffers. Blocking: only LoadLibrary (disk), and the first PlayNearest among
// frames of a kind, which reads the library; all else neither allocates nor
// locks. Errors: name field, expected and found.
class ReferenceFeed {
 public:
  // kToBody: every reset moves the clip to the body.
  enum class Align { kNone, kToBody };
  // Frames of clips that are not left out: all that a clip goes on from for a
  // while, those of get-ups before they leave the floor, those that stay
  // upright for a second (nearest_frame.h, get_up_frames.h).
  enum class Among { kAll, kGetUps, kUpright };

  // `task` has its defaults filled; `control_hz` is the rate of frames.
  ReferenceFeed(const character::Character& character, const v1::Recipe& recipe,
                absl::Span<const int> frames_ahead);

  // Control steps ahead of now, one per frame.
  absl::Span<const int> offsets() const { return offsets_; }

  // INVALID_ARGUMENT: of another character or rate.
  absl::Status LoadLibrary(const std::string& directory);
  // Null before.
  const motion::Library* library() const { return library_.get(); }

  // NOT_FOUND: no such clip, listing those that there are.
  absl::Status Play(absl::string_view clip, double seconds, Align align);
  // Plays from the frame that is nearest to the body, moved to where the body
  // is and heads; it stands for `stand` >= 0 steps before the clip goes on.
  // Returns how far the body is off it: mean over its tracked bodies, m.
  // FAILED_PRECONDITION without a library; NOT_FOUND: it has no such frame.
  absl::StatusOr<double> PlayNearest(const world::BodyState& body, Among among,
                                     int stand);
  absl::Status Seek(double seconds);
  bool playing() const { return clip_ >= 0; }
  // While something plays: which clip of the library, and the frame of now,
  // which of a looping clip counts on.
  int clip() const { return clip_; }
  int64_t frame() const { return frame_; }
  // The clip's last frame is reached: the feed stays there.
  bool is_over() const;
  // Whether a reset moves what plays to where the body stands (AlignTo).
  bool aligns() const { return align_ == Align::kToBody; }
  // Whether it plays from the frame that was nearest to a body.
  bool is_nearest() const { return is_nearest_; }
  // Moves what plays so that the frame of now stands (in the plane) and heads
  // as the body does; `position` is null where only the heading is known.
  void AlignTo(const double* position, const double* rotation_wxyz);

  // Fills all frames. LoadPlayed: a clip plays (CHECKed). LoadGiven: poses that
  // CheckPose accepts, one per offset.
  void LoadPlayed();
  void LoadGiven(absl::Span<const Pose> frames);
  // After a Load, once: hides what is far of a body in recovery.h's sense. True
  // if the next frame is.
  bool Hide(const world::RecoveryLaw& law, const world::BodyState& body);
  // The clip moves on by a frame, unless that of now stands or is its last.
  void Advance() {
    if (stand_ > 0) {
      --stand_;
    } else if (!is_over()) {
      ++frame_;
    }
  }

  // Of the observation's frames, after a Load.
  absl::Span<const world::BodyState> observed() const { return observed_; }
  absl::Span<const float* const> observed_contact() const { return contact_; }
  // Joints and torques of the next frame (of any frame where the action law
  // needs none).
  const motion::FrameView& next() const { return views_[next_]; }
  // Where the root of the reference is now, in the plane, by going back from
  // the first observed frame at its velocity.
  Eigen::Vector2d RootNow() const;

  // Reads the clip's frame `ahead` steps from now, aligned.
  void ReadPlayed(int ahead, PoseBuffer* out);
  // The library's row of now, not aligned, for the initial target.
  const motion::FrameView& RowOfNow();
  // Joints and torques of a pose, until the next Load.
  const motion::FrameView& RowOf(const Pose& pose);

 private:
  void Transform(world::BodyState* state) const;
  // The library's frames of a kind, made when first asked for.
  const world::NearestFrames& Frames(Among among);
  // Copies a pose's joints, torques and contacts into numbers_ and views_.
  void Copy(const Pose& pose, size_t index);

  const character::Character& character_;
  const world::BodyReader reader_;
  const double control_hz_;
  std::vector<int> offsets_;
  size_t next_ = 0;  // index in offsets_

  std::unique_ptr<const motion::Library> library_;
  int clip_ = -1;
  int64_t frame_ = 0;
  int stand_ = 0;  // steps
  Align align_ = Align::kNone;
  bool is_nearest_ = false;
  // Reference to world: turn about z, then move.
  Eigen::Quaterniond turn_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d move_ = Eigen::Vector3d::Zero();
  bool is_moved_ = false;

  std::vector<world::BodyState> observed_;
  std::vector<const float*> contact_;
  std::vector<motion::FrameView> views_;  // by offset; joints, torque, contact
  Eigen::Vector3d next_root_ = Eigen::Vector3d::Zero();  // of the next frame
  std::vector<float> no_contact_;                        // [F] zeros
  // Of a played clip: by offset, and of now.
  std::vector<std::unique_ptr<motion::ReferenceFrame>> rows_;
  std::unique_ptr<motion::ReferenceFrame> row_of_now_;
  // Of given poses: by offset.
  struct Numbers {
    std::vector<float> joint_position, joint_velocity, torque, contact;
  };
  std::vector<Numbers> numbers_;
  const character::DataPtr data_;
  // Of PlayNearest: by Among, null until asked for; scratch.
  std::array<std::unique_ptr<const world::NearestFrames>, 3> nearest_;
  std::vector<float> posture_;
  world::BodyState reference_;
};

}  // namespace sinew::runtime

#endif  // SINEW_DEPLOY_RUNTIME_REFERENCE_FEED_H_
